#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/pose.h"
#include "armtrue/programs/configuration.h"
#include "armtrue/programs/motion.h"

namespace armtrue {

/// Why a command needs attention. With `unreachable`, `limit` or `beyond_max` the target stays as
/// programmed.
enum class CommandNote {
  unreachable,  ///< the identified arm does not reach the pose on this branch
  limit,        ///< a joint would stand, or was programmed, outside its travel
  beyond_max,   ///< the correction is larger than CompensationOptions::max_correction
  singular,     ///< near a singular posture: the correction is damped, or the wrist is stretched
  outside_readings,  ///< leverage above 1: no pose of the calibration was like this
  below_std,         ///< the error before is below the standard deviation after correction
  turn,              ///< a joint crosses zero: its turn (KUKA: bit of T) changes
  arrival,           ///< no command keeps the direction of arrival that its correction assumes
  fewer_axes,  ///< of an arm of fewer than six axes: `after` is the error that it cannot correct
};

/// The name in files: `outside-readings`.
std::string to_string(CommandNote note);

/// Frame and tool of a target.
struct ProgramSetUp {
  Pose base;  ///< R_0 from the program's frame (KUKA: $BASE)
  Pose tool;  ///< R_7 from the TCP (KUKA: $TOOL, if R_7 is the flange)
};

/// The targets of a program, in the order in which the arm drives to them.
struct Program {
  /// One row for each target: its name, line and context. `q` is the joint target [rad] or, of a
  /// Cartesian target, the hint of its branch. Forces are in the axes of the program's frame.
  /// Nothing is measured.
  Campaign visits;
  std::vector<Pose> poses;   ///< of Cartesian targets, program's frame from TCP; else empty
  std::vector<bool> hinted;  ///< of Cartesian targets: whether `q` holds a hint
  /// KUKA's turn of each target, bit j set if joint j + 1 is below zero; empty if not stated.
  std::vector<int> turns;
  /// If a program mixes both kinds: whether a row is a joint target; else empty.
  std::vector<bool> joints;
  /// What Cartesian targets state about their branch; empty if none states more than a hint.
  std::vector<Configuration> configurations;
  /// How the arm comes to each row; empty: all joints move together. On a line or an arc a joint
  /// may reverse on the way; its direction of arrival is then that at the end.
  std::vector<ProgramMotion> motions;
  /// Frames and tools, and the index of that of each row; empty if those of CompensationOptions
  /// hold for all rows.
  std::vector<ProgramSetUp> set_ups;
  std::vector<int> set_up;
  /// The ways between the rows, as RobotProgram::ways, and the node of each row; no ways: the order
  /// of the rows.
  std::vector<std::vector<int>> ways;
  std::vector<int> node;
  /// Whether `q` of every row holds the external axes as programmed, those of Cartesian targets
  /// too.
  bool states_external = false;

  int rows() const { return visits.rows(); }
  bool is_cartesian() const { return !poses.empty(); }
  bool is_cartesian(size_t row) const { return is_cartesian() && (joints.empty() || !joints[row]); }
};

struct CompensationOptions {
  Pose base;  ///< R_0 from the program's frame (KUKA: $BASE)
  /// R_7 from the flange, in which tools of a program stand; R_7 is the flange of most robot files.
  Pose flange;
  Pose tool;  ///< R_7 from the TCP (KUKA: $TOOL, if R_7 is the flange)
  /// Whether the TCP is the frame that was measured: then `tool` of the identified robot and
  /// effects on it apply.
  bool tool_is_measured = false;
  double max_correction = 5e-3;  ///< [m]
  /// Whether to correct targets that the readings do not cover (outside_readings, below_std).
  bool correct_uncovered = true;
  /// Whether the correction may move external axes; otherwise they stay as programmed. External
  /// axes are coarser than the joints of the arm, and in the minimisation a metre counts as a
  /// radian.
  bool move_external_axes = false;
  std::optional<JointVector> start;  ///< hint of the branch of a first Cartesian target
};

/// How far one pose is from another.
struct PoseDifference {
  double position = 0;     ///< [m]
  double orientation = 0;  ///< angle of the rotation between them [rad]
};

/// A target and the command that replaces it. Poses are program's frame from TCP.
struct CorrectedTarget {
  JointVector programmed;  ///< the intended pose in the controller's model [rad]
  Pose intended;
  JointVector q;  ///< commanded [rad]
  Pose pose;      ///< of the controller's model at `q`: the command of a Cartesian program
  bool is_corrected = false;
  /// Error of the identified arm at `programmed` and at `q`.
  PoseDifference before, after;
  Pose reached;  ///< of the identified arm at `programmed`
  /// Of a joint target: the joint angles at which the controller's model has the pose `reached`
  /// [rad]; `programmed` if there are none, near a stretched elbow, and of a Cartesian target.
  JointVector reached_q;
  /// Standard deviation of the position after the correction, from the uncertainty of links and
  /// effects and from what the model lacks (Uncertainty::rest); root of the sum of squares over the
  /// axes [m]. Empty if the robot does not state its uncertainty.
  std::optional<double> deviation;
  std::optional<double> leverage;  ///< as Prediction::leverage
  std::vector<CommandNote> notes;
  /// dq/dt of each joint at the end of the line or arc to the target, t from 0 to 1 on it [rad or
  /// m]. Empty for other moves, and without effects that follow the motion.
  JointVector pace;

  bool has(CommandNote note) const;
  /// Expected root mean square of the position error after the correction [m].
  double expected() const;
};

/// A target for which the controller's model has no joint angles: it is out of reach, has no hint
/// of its branch, or states a turn that contradicts its pose.
class UnreachableTarget : public std::runtime_error {
 public:
  UnreachableTarget(int target_row, const std::string& what)
      : std::runtime_error(what), row(target_row) {}
  int row;
  /// All targets that are out of reach, with the reasons; empty if the first one ended the
  /// computation.
  std::vector<std::pair<int, std::string>> out_of_reach;
  /// All to which ways with several postures lead, or none of which the posture is known.
  std::vector<std::pair<int, std::string>> in_doubt;
  /// One of them has none because nothing says in which one the program begins.
  bool lacks_start = false;
};

/// A target that the controller's model does not reach on the branch of its hint.
class OutOfReach : public UnreachableTarget {
 public:
  using UnreachableTarget::UnreachableTarget;
};

/// Whether `tool` of a controller's model may be the flange of a program and not the place of a
/// reflector: the last link changes nothing, so R_7 is the frame of the last axis, and the tool is
/// turned by right angles. convert-robot once left the flange of a URDF there.
bool may_hold_flange_in_tool(const Robot& controller);

/// The angle [rad] by which the last frames of two models of one arm are turned against each other,
/// though their last axes are the same within 5 deg; 0 if these are not.
double turn_of_last_frame(const Robot& robot, const Robot& controller);

/// Identified parameters of links that may contain errors of base or tool, because these were not
/// identified: those of the first link without `base`, those of the last joint and link without
/// `tool`. If base and tool were known otherwise, these parameters belong to the arm.
std::vector<std::string> parameters_of_station(const Robot& robot);

/// The robot with the zero offsets of one of its sessions. Throws std::invalid_argument if it has
/// no such session, or if none is named and its sessions differ in zero offsets.
Robot in_session(Robot robot, const std::string& session);

/// Finds for each target the joint angles q* at which the identified arm reaches the pose that the
/// target has in the controller's model:
///     F_identified(q*, context) tool = F_controller(q_programmed, context) tool,
/// with F the pose R_0 from R_7, without base and tool of the measurement. Directions of arrival
/// are those of the commands from row to row, along Program::motions, unless the visits state them.
/// Throws UnreachableTarget, and std::invalid_argument if an effect's driver is missing.
std::vector<CorrectedTarget> compensate(const Robot& identified, const Robot& controller,
                                        const Program& program, const CompensationOptions& options);

/// The rows of the worst `count` targets by expected(), then by the error before; worst first.
std::vector<int> worst_targets(const std::vector<CorrectedTarget>& targets, int count);

/// How many targets have a note.
int count_of(const std::vector<CorrectedTarget>& targets, CommandNote note);

/// Whether the arm reaches every target without a correction, to 1e-9 m and rad: the controller
/// runs its model.
bool need_no_correction(const std::vector<CorrectedTarget>& targets);

/// A summary in one or two sentences: how many targets are corrected, the expected error, and what
/// to do about the others.
std::string compensation_sentence(const std::vector<CorrectedTarget>& targets);

/// All notes, in the order of the enumeration.
const std::vector<CommandNote>& command_notes();

}  // namespace armtrue
