#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/kinematics/chain.h"
#include "armtrue/kinematics/pose.h"
#include "armtrue/programs/configuration.h"
#include "armtrue/programs/motion.h"
#include "armtrue/programs/program_text.h"
#include "armtrue/statistics/check_digits.h"
#include "armtrue/text/input_error.h"

namespace armtrue {

class Dialect;  // armtrue/programs/dialect.h

/// A number of a program that a correction may replace.
struct ProgramNumber {
  int text = 0;               ///< index in RobotProgram::texts
  size_t begin = 0, end = 0;  ///< in that text; begin == end: not written, and may be added here
  double value = 0;           ///< as written, in the unit of the dialect
  std::string prefix;         ///< stands before the number where it is added
  bool is_written() const { return end > begin; }
};

enum class TargetKind { joints, cartesian };

/// A pose that a program states beside the joint angles q of a point: before F(q) behind, where F
/// is the flange of RobotProgram::stated_arm. It follows the joint angles.
struct StatedPose {
  std::vector<ProgramNumber> numbers;  ///< in the order of the dialect
  Pose before, behind;
};

/// The numbers of a point: those of a declaration that several moves may use, or of one move.
struct ProgramPoint {
  std::string name;           ///< for messages: `XP1`, or empty where a move has its own numbers
  int line = 0;               ///< of the numbers, in their text
  int text = 0;               ///< index in RobotProgram::texts
  size_t begin = 0, end = 0;  ///< in that text: of the point with its brackets or its name
  /// Something besides the moves of this program uses it, or may: it must stay.
  bool is_shared = false;
  /// Texts of others declare it, or use it, too: it stays, unless they are corrected with this
  /// program.
  bool is_of_others = false;
  /// The point is an expression of one move, and [begin, end) is its text: a declared point that is
  /// displaced by constants (RAPID Offs, RelTool; KUKA `XP1:{Z 50,..}`). Its numbers are the
  /// result, and stand nowhere in the text. A correction writes the point out in the move.
  bool is_expression = false;
  int starts_from = -1;  ///< in RobotProgram::points: the declared point of an expression; -1: none
  std::string before, behind;  ///< an expression: what stands beside the point that is written out
  TargetKind kind = TargetKind::cartesian;
  /// In the order of the dialect: position and orientation, or the six joints.
  std::vector<ProgramNumber> numbers;
  /// Joint angles that are written as counts of encoders, whole numbers: how many a unit of the
  /// dialect has, for each joint; empty of others.
  std::vector<double> counts_per_unit;
  /// What a Cartesian point states about the branch, in the order of the dialect; empty if nothing.
  std::vector<ProgramNumber> configuration;
  std::vector<ProgramNumber> external;  ///< E1 to E6; empty if the dialect has none
  std::vector<StatedPose> poses;        ///< of joint angles: what the program states beside them
};

/// A coordinate system that a program names.
struct ProgramFrame {
  std::string name;  ///< `BASE_DATA[3]`; `{...}` for one that is written out
  Pose pose;
  bool is_known = false;
};

/// The text of a move that may be inserted before a straight or circular one, but for its points.
struct ProgramInsertion {
  size_t at = 0;               ///< in texts[0]: where lines begin that stand before the move
  std::string before, behind;  ///< the point, or both points of a circular move
  std::string middle;          ///< between the auxiliary point and the end
  /// What stands before the point of a straight move on the way of a circular one; empty if there
  /// can be none.
  std::string before_line;
  std::string line_end;
};

/// A point to which the arm drives, in the order of the text.
struct ProgramTarget {
  int line = 0;               ///< of the move, in texts[0]
  size_t begin = 0, end = 0;  ///< in texts[0]: what names or states the point in the move
  MotionKind motion = MotionKind::joint;
  /// Whether the arm always comes from the target before: no branch, repetition or call lets it
  /// come from elsewhere.
  bool follows_target = false;
  int node = -1;  ///< in RobotProgram::ways; -1: none
  /// The targets at which its move may start, if the reader follows branches and loops; none if one
  /// of them is not known.
  std::vector<size_t> starts;
  bool is_in_loop = false;
  /// A relative move: its text states the displacement from the target before. `pose` is its end.
  bool is_relative = false;
  /// No path through the program leads here: after RETURN or a jump, or in a local routine that
  /// nothing calls.
  bool never_runs = false;
  bool ends_elsewhere = false;  ///< a circle whose angle says where it ends
  bool is_room_tool = false;    ///< the tool is fixed in the room, and the robot holds the part
  /// With a tool in the room: `pose` is the inverse of what is written, `base` the tool and `tool`
  /// the frame of the part, which the robot holds: flange part = room tool * inverse(written).
  bool is_inverse = false;
  /// Distance before the target at which the arm may leave its path [m], if the program states it
  /// in mm.
  double blend = 0;
  /// Whether the arm passes the target without a stop, however near; a blend says so, too.
  bool is_passed = false;
  ArcTurning turning = ArcTurning::in_frame;
  /// Of a straight or circular move: why no point can be inserted before it; empty if some can.
  std::string obstacle;
  ProgramInsertion insertion;  ///< if there is no obstacle
  std::string remark;          ///< a warning, if points are written into the move; else empty
  int point = -1;
  int base = -1, tool = -1;  ///< in RobotProgram::frames; -1: the program names none
  TargetKind kind = TargetKind::cartesian;
  Pose pose;  ///< Cartesian: base from TCP, as written
  /// Where the move displaces its point, such as by Tool_Offset: `pose` is before * point * behind.
  Pose before, behind;
  /// Whether the point states the orientation; else it is not known, and pose.rotation a guess or
  /// the identity.
  bool has_orientation = true;
  std::vector<double> external;  ///< E1 to E6, as written; NaN: not known; or none
  /// External axes that corrections of this dialect cannot change, such as eax_a, as written.
  std::map<std::string, double> other_axes;
  /// Of joints: encoder angles of the model [rad].
  JointVector q = JointVector::Zero(kProgramAxes);
  std::optional<JointVector> near;  ///< angles near the solution that the program states [rad]
  Configuration configuration;
};

/// The arm by which a program, or a point of it, has its joint angles: rows of Denavit and
/// Hartenberg, as the program states them.
struct StatedArm {
  int line = 0;
  KinematicChain chain;
};

/// A name in the program that must be the name of the file.
struct ProgramName {
  int text = 0;
  size_t begin = 0, end = 0;
};

/// A copy of a routine for calls that hand on another tool or frame than other calls of it. It is
/// written only if its numbers differ from those of the routine.
struct RoutineCopy {
  /// The call of the copy, and the original text of the call.
  struct Call {
    size_t begin = 0, end = 0;
    std::string was;
  };
  std::string name, of;  ///< of the copy, of the routine
  // In texts[0]:
  size_t begin = 0, end = 0;        ///< of the copy, whole lines
  size_t of_begin = 0, of_end = 0;  ///< of the routine
  std::vector<Call> calls;
};

/// A frame or a tool that a call hands on between programs of a project.
struct HandedFrame {
  enum class Kind {
    as_before,  ///< that of the caller's own caller; after a call: what it was before
    stated,
    calculated,  ///< as the program runs
    several      ///< one of them; which one is not known
  } kind = Kind::as_before;
  std::string name;          ///< as of ProgramFrame
  std::optional<Pose> pose;  ///< if it is known
};
bool operator==(const HandedFrame& a, const HandedFrame& b);
using HandedFrames = std::vector<HandedFrame>;  ///< in the order of the dialect

/// What a program and the others of its project that call it, or that it calls, hand on. All
/// routines are named in capitals.
struct ProgramNeighbours {
  std::map<std::string, HandedFrames> begins;  ///< by its routines that others call: what they
                                               ///< begin with
  std::map<std::string, std::string> callers;  ///< of its routines: `a.src:12, b.src:7`
  std::map<std::string, HandedFrames> leaves;  ///< by routines of others that it calls: what they
                                               ///< leave
  /// Global variables that several programs set.
  struct SharedVariables {
    std::map<std::string, std::set<std::string>> set_by;  ///< calls of routines of others
    std::set<std::string> set_at_any_time;                ///< by interrupts or submit programs
  };
  std::optional<SharedVariables> shared;  ///< nothing: not known
};

/// A call of a routine.
struct ProgramCall {
  int line = 0;  ///< in texts[0]
  std::string routine;
  int node = -1;  ///< in RobotProgram::ways; -1: none
};

/// A robot program: its text, byte by byte, and the numbers in it that state its targets.
struct RobotProgram {
  const Dialect* dialect = nullptr;
  /// The program, and its data list if there is one (KUKA .dat); after `own_texts` of them, those
  /// of others, for names that the program does not declare itself.
  std::vector<ProgramText> texts;
  size_t own_texts = 1;
  ProgramNeighbours neighbours;
  std::vector<RoutineCopy> copies;  ///< that stand in texts[0]
  std::string without_copies;       ///< texts[0] without them; empty if there are none
  std::vector<int> lines;           ///< of texts[0], each as it counts without copies; or empty
  std::vector<ProgramPoint> points;
  std::vector<ProgramTarget> targets;
  /// The ways between targets, as a graph: of each node those from which the arm comes to it. A
  /// node is a target, or where ways meet, or the begin of the program. Empty: the order of the
  /// targets.
  std::vector<std::vector<int>> ways;
  std::vector<ProgramFrame> frames;
  std::optional<KinematicChain> stated_arm;  ///< if the program states it; see StatedPose
  std::vector<StatedArm> stated_arms;        ///< that one and those of points, each once
  std::vector<ProgramName> names;
  int own_model_line = 0;  ///< the first one that uses DialectFacts::own_model; 0: none does
  int own_model_text = 0;  ///< in which it stands
  /// The arm as files of its controller name it, `#KR210R2700_2 S C2 FLR`, and where: text, line.
  std::string arm_name;
  int arm_name_text = 0, arm_name_line = 0;
  /// Of KUKA: calls of routines that no text has, before a move whose frame and tool were set
  /// before the call.
  std::vector<ProgramCall> calls_not_given;
  std::set<std::string> routines;            ///< its own, in capitals, if the reader follows ways
  std::vector<ProgramCall> calls_of_others;  ///< of routines with other names
  int left_alone = 0;  ///< moves that may run and that the parser does not understand
  int never_run = 0;   ///< moves that remove_what_never_runs() has removed
  std::vector<std::string> why_left_alone;  ///< of each of them
  std::vector<std::string> warnings;
};

/// Frames and tools that the program only names, by name (`BASE_DATA[3]`, `wobj1`, `UF[2]`).
using KnownFrames = std::map<std::string, Pose>;

/// A program has no target.
class NoTargets : public InputError {
 public:
  NoTargets(const std::string& message, std::vector<std::string> left)
      : InputError(message), why_left_alone(std::move(left)) {}
  std::vector<std::string> why_left_alone;  ///< of each of its moves
};

/// What must be known of a Cartesian target. For `position`, its orientation or its frame may be
/// unknown.
enum class TargetParts { pose, position };

/// Reads a program. `texts`: the program and its data list if there is one (KUKA .dat). `others`:
/// texts that declare what the program may use, too, as its controller looks names up (KRL: what
/// $config.dat and PUBLIC data lists declare as GLOBAL). What the parser does not understand
/// (expressions, offsets, relative moves, points that are assigned at run time) gives a warning
/// with file and line, and stays as it is. `neighbours`: see neighbours_in(). Throws NoTargets if
/// there is no target.
RobotProgram parse_program(const Dialect& dialect, std::vector<ProgramText> texts,
                           const KnownFrames& known, TargetParts parts = TargetParts::pose,
                           std::vector<ProgramText> others = {}, ProgramNeighbours neighbours = {});

/// Throws InputError if a text begins a part that it does not end (Dialect::open_part): no
/// controller loads it, and a copy that was cut off lacks moves.
void refuse_cut_off(const Dialect& dialect, const std::vector<ProgramText>& texts);

/// Indices of the targets of the move to one of them: an arc has two, others have one.
std::vector<size_t> targets_of_move(const RobotProgram& program, size_t target);

/// Removes targets, with the reasons `why` by index, and leaves their moves as they are; an arc
/// goes with either of its points. Declared points that they use stay as they are.
void leave_alone(RobotProgram& program, const std::map<size_t, std::string>& why);

/// Removes the targets of moves that never run, unless all are such: their moves stay as they are,
/// but for declared points that other moves use, too.
void remove_what_never_runs(RobotProgram& program);

/// The command that replaces a target.
struct ProgramCommand {
  bool is_corrected = false;
  JointVector programmed = JointVector::Zero(kProgramAxes);  ///< joint angles of the target [rad]
  JointVector q = JointVector::Zero(kProgramAxes);           ///< joint angles of the command [rad]
  Pose pose;                                                 ///< of the controller's model at `q`
  std::vector<double> external;  ///< as ProgramTarget::external; empty: as programmed
  /// Derivative of `q` by the pose, in the axes of its frame: per m and per rad. The numbers of a
  /// pose are rounded, and its branch is stated for the joint angles at what is written. Nothing:
  /// it is stated for `q`.
  std::optional<Eigen::Matrix<double, kProgramAxes, 6>> by_pose;
};

/// A number of a point as written, and the number of another pose or posture at its place.
struct NumberBeside {
  int component = 0;  ///< in ProgramPoint::numbers of a pose; those of joint angles come after
  double written = 0, beside = 0;  ///< in the unit of the dialect
  int decimals = 0;                ///< fewest decimals of a correction of it
  double moved = 0;                ///< largest change by its check digits
  size_t target = 0;
};

/// The numbers of the points that targets use, each of them once, beside those of a command for
/// each target.
std::vector<NumberBeside> numbers_beside(const RobotProgram& program,
                                         const std::vector<ProgramCommand>& commands);

/// A point on the way of a straight or circular move. An arc is divided into arcs, so its points
/// come in turn: an auxiliary point and the end of a piece. The last piece is the move of the
/// program, and its auxiliary point, the last of the move, takes the place of the program's.
struct ProgramPointBetween {
  size_t target = 0;  ///< the end of the move, or its auxiliary point
  Pose pose;          ///< the commanded pose
  /// Of the controller's model there [rad]; nothing: on the branch of the target, with its turns.
  std::optional<JointVector> q;
  double blend = 0;                      ///< radius within which it may be passed [m]
  MotionKind motion = MotionKind::line;  ///< line, via, arc; a line may be a piece of an arc
  std::vector<double> external;          ///< as ProgramTarget::external
  bool is_left_out = false;  ///< via: no auxiliary point, because the rest of the arc is a line
};

/// Number of moves to the points: one for each that is no auxiliary point.
int moves_of(const std::vector<ProgramPointBetween>& between);

/// The result of rewrite().
struct RewrittenProgram {
  std::vector<std::string> texts;
  int changed = 0;   ///< points with another number
  int inserted = 0;  ///< moves
  std::vector<std::string> warnings;
  std::vector<TextEdit> edits;  ///< of the texts of the program, with all copies of routines
};

/// The texts with the numbers of the commands, one for each target, and with a move for each point
/// `between`, in the order in which the arm passes them. But for these moves only bytes of numbers
/// change, and only of numbers that differ after rounding to Dialect::decimals(), or finer where
/// more decimals were written. A declared point changes where it is declared, if all its moves need
/// the same numbers and nothing else uses it; otherwise each move that needs other numbers gets a
/// point of its own, written out in the move, of FANUC as a new position. Numbers that a point
/// leaves out are added if the point before no longer gives them. An inserted point is written as
/// the end of its move is, with other numbers; its move has the speed of that move and is passed
/// without a stop; of FANUC the lines and LINE_COUNT are numbered anew. The auxiliary point of a
/// divided arc is written out too. No point is inserted in a move one of whose ends is not
/// corrected. With `by`, changed numbers have check digits: two more decimals, except for FANUC,
/// whose files have three decimals; numbers of poses, but for quaternions, are checked also if they
/// are rounded to three decimals (six of UR), for which they move by up to kMostMovedIfRounded.
/// Throws InputError if the controller would not load the program.
RewrittenProgram rewrite(const RobotProgram& program, const std::vector<ProgramCommand>& commands,
                         const std::vector<ProgramPointBetween>& between = {},
                         std::optional<Corrector> by = std::nullopt);

/// Marks each own text of a program that a correction has changed: adds a line of comment after the
/// line that begins the program, for FANUC after its last instruction; at the beginning if no line
/// begins it. Call it before rename().
void mark_corrected(const RobotProgram& program, Corrector by, std::vector<std::string>& texts);
/// The same for one text.
void mark_corrected(const Dialect& dialect, Corrector by, std::string& text);

/// The mark of a text; case and blanks do not count.
struct CorrectionMark {
  std::string text;  ///< name of the text
  int line = 0;
};
std::optional<CorrectionMark> find_correction_mark(const std::vector<ProgramText>& texts,
                                                   Corrector by);

/// Whether the numbers of the program have the check digits that rewrite() writes.
bool has_check_digits(const RobotProgram& program, Corrector by);

/// Replaces the name of the program in its texts by `name`.
void rename(const RobotProgram& program, const std::string& name, std::vector<std::string>& texts);

/// Why a name is illegal for a program of the dialect, with a legal name; empty if it is legal.
std::string why_illegal_name(const Dialect& dialect, const std::string& name);

}  // namespace armtrue
