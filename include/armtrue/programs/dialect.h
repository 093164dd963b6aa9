#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/kinematics/chain.h"
#include "armtrue/kinematics/pose.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/programs/program_text.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

class MoveWriter;  // programs/insertion.h
struct Routine;    // programs/routine_copies.h

/// Legal names of programs: of letters, digits and underscores.
struct NameRule {
  /// Largest number of characters; 0: any file name is legal, because the controller takes the name
  /// from the text.
  size_t longest = 0;
  std::string others;  ///< other characters
  bool may_begin_with_digit = false;
  bool are_capitals = false;  ///< a name is written in capitals
};

/// Facts that hold for all programs of a maker.
struct DialectFacts {
  std::string name;                  ///< in options: `krl`
  std::string maker;                 ///< `KUKA`
  std::vector<std::string> endings;  ///< of files of programs, in capitals; the usual one first
  char comment = '!';          ///< a comment goes from it to the end of its line; 0: none does
  bool may_be_packed = false;  ///< its files may be packed by gzip
  double length = kMillimetre;       ///< unit of lengths [m]
  double angle = kDegree;            ///< unit of angles [rad]

  NameRule names;

  /// How a move names its frame and its tool.
  std::string frame = "its frame", tool = "its tool";
  /// What sets the tool, if a move without it takes the one that is active; empty: every move of a
  /// pose has a tool.
  std::string sets_active_tool;
  /// A program that states neither frame nor tool has those of its caller.
  bool has_frames_of_caller = false;

  bool has_external_axes = false;       ///< targets state E1 to E6
  bool counts_axis_3_from_arm = false;  ///< see program_joints()
  /// Frames that a program names stand in the base of its other poses; else they take its place.
  bool has_frames_in_base = false;
  std::string fixed_turns;  ///< what states turns, if a correction cannot change them; else empty
  std::string own_model;    ///< variable of the controller's calibrated model; else empty

  /// Words that begin and end a part of a text, as first words of a line: DEF and END.
  std::vector<std::pair<std::string, std::string>> parts;

  // A data list beside a program, which has its points: part.dat of part.src.
  std::string data_list;                      ///< its ending in capitals; empty: there is none
  std::vector<std::string> with_data_list;    ///< endings of texts that have one
  std::vector<std::string> controller_texts;  ///< names of the controller's own files, in capitals
  std::string controller_mark;  ///< a text that each controller has once, in capitals; or empty
};

/// Check digits of a changed number.
struct NumberCheck {
  int decimals = 0;  ///< of the number with its two check digits; 0: there is no room
  int rounded = 0;   ///< decimals to which it may be rounded and still be checked; 0: none
};

/// A point of a move, or an expression in its place, written out as text.
struct WrittenPoint {
  std::vector<std::string> numbers;        ///< one text for each number
  std::vector<std::string> configuration;  ///< empty where it stays
  std::vector<std::string> external;       ///< of the external axes that are added or changed
};

/// A part of a text without its end: DEF without END.
struct OpenPart {
  size_t at = 0;    ///< in the text, in the line that begins it
  std::string end;  ///< the word that is missing
};

/// The texts of a folder, read once, to find what a program among them needs of the others.
class FolderTexts {
 public:
  FolderTexts() = default;
  FolderTexts(const FolderTexts&) = delete;
  FolderTexts& operator=(const FolderTexts&) = delete;
  virtual ~FolderTexts() = default;

  /// Texts of the folder that a program needs: the whole texts of others that declare names which
  /// it uses, and a short text of what others do to these names. `own`: the program's own texts,
  /// which are in the folder.
  virtual std::vector<ProgramText> for_program(
      const std::vector<const ProgramText*>& own) const = 0;
};

/// The language of the robot programs of one maker. Each has a folder in src/programs and a line in
/// dialects.cc; other rooms and commands ask a maker only through this class.
class Dialect {
 public:
  explicit Dialect(DialectFacts facts) : facts_(std::move(facts)) {}
  Dialect(const Dialect&) = delete;
  Dialect& operator=(const Dialect&) = delete;
  virtual ~Dialect() = default;

  const DialectFacts& facts() const { return facts_; }

  /// Reads a program whose texts are there; see parse_program().
  virtual void parse(RobotProgram& program, const KnownFrames& known, TargetParts parts) const = 0;

  /// The routines of a program that was read, in the order of the text, for copies of them; by
  /// default none.
  virtual std::vector<Routine> routines(const RobotProgram& program,
                                        const KnownFrames& known) const;

  // Numbers.

  /// The pose of the numbers of a point: by default x, y, z [mm] and the angles about the fixed
  /// axes x, y, z [deg], R = Rz Ry Rx.
  virtual Pose pose_of_numbers(const std::vector<double>& numbers) const;
  /// The numbers of a pose. Of angles that give the same rotation, those nearest to `written`.
  virtual std::vector<double> numbers_of_pose(const Pose& pose,
                                              const std::vector<double>& written) const;
  /// The encoder angles [rad] of the model, and back; see counts_axis_3_from_arm.
  virtual JointVector joints_of_numbers(const std::vector<double>& numbers) const;
  virtual std::vector<double> numbers_of_joints(const JointVector& q) const;
  /// Decimals that a changed number has at least, in the order of ProgramPoint::numbers.
  virtual int decimals(TargetKind kind, size_t component) const = 0;
  virtual NumberCheck check(TargetKind kind, size_t component) const;
  /// Largest change of a number by its check digits, in its unit.
  double moved_by_check(TargetKind kind, size_t component) const;

  // The branch that a Cartesian point states.

  /// Whether a point states the turns of the joints, and a correction changes them.
  virtual bool states_turn(const ProgramPoint& point) const;
  /// A text for each number of ProgramPoint::configuration, by the corrected joints; empty where it
  /// stays. A number or bit that contradicts the programmed joints stays.
  virtual std::vector<std::string> configuration_texts(const ProgramPoint& point,
                                                       const ProgramCommand& command) const;
  /// The edits that make a point state the branch of the joints `q`.
  virtual std::vector<TextEdit> configuration_edits(const RobotProgram& program,
                                                    const ProgramPoint& point,
                                                    const JointVector& q) const;

  // Text.

  /// The text of an expression (ProgramPoint::is_expression) that is written out in its move.
  virtual std::string written_out(const RobotProgram& program, const ProgramPoint& point,
                                  const WrittenPoint& texts) const;
  /// Writes points and moves into the text of a program.
  virtual std::unique_ptr<MoveWriter> move_writer(const RobotProgram& program) const;
  /// Throws InputError if the controller would not load the program with `inserted` more moves.
  virtual void refuse_what_does_not_load(const RobotProgram& program, size_t inserted) const;
  /// Adds a comment to a text, after the line that begins the program.
  virtual void add_comment(const std::string& comment, std::string& text) const;

  /// The first part of a text that does not end, as in a copy that was cut off; nothing in a text
  /// that begins none. By default by the first word of each line, see DialectFacts::parts.
  virtual std::optional<OpenPart> open_part(const std::string& text) const;

  // Texts that belong together.

  /// See TextsOfOthers; the texts must outlive the result. By default null: nothing of others
  /// counts.
  virtual std::unique_ptr<FolderTexts> folder_texts(
      const std::vector<const ProgramText*>& texts) const;
  /// The folder in which the controller looks up names of the program `path`, with the slash at its
  /// end, and whether it looks in the folders within it, too.
  struct SearchFolder {
    std::string folder;
    bool is_deep = true;
  };
  /// `marks`: the texts called DialectFacts::controller_mark.
  virtual SearchFolder search_folder(const std::vector<std::string>& marks,
                                     const std::string& path) const;
  /// See neighbours_in(); by default none.
  virtual std::map<std::string, ProgramNeighbours> neighbours(
      const std::vector<ProgramText>& project, const KnownFrames& known) const;

 protected:
  /// Whether a line with this first word begins the program; if no line does, add_comment() writes
  /// at the beginning of the text.
  virtual bool begins_program(const std::string& word) const;

 private:
  DialectFacts facts_;
};

/// All dialects; the first one is the default for a program whose file name shows none.
const std::vector<const Dialect*>& dialects();
/// The dialect with a name in options; null if there is none.
const Dialect* find_dialect(const std::string& name);
/// The dialect of a file by its ending; null if none has it.
const Dialect* dialect_of_file(const std::string& path);
/// The same, or the first one.
const Dialect& likely_dialect(const std::string& path);

}  // namespace armtrue
