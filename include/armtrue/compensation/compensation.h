#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/pose.h"
#include "armtrue/programs/configuration.h"

namespace armtrue {

/// Why a command needs attention. Those up to `beyond_max` leave the target as it was programmed.
enum class CommandNote {
  unreachable,       ///< the identified arm does not reach the pose on this branch
  limit,             ///< a joint would stand outside its travel
  beyond_max,        ///< the correction is larger than is allowed
  singular,          ///< near a singular posture: the correction is damped, or the wrist stretched
  outside_readings,  ///< leverage above 1: the calibration measured nothing of the kind
  below_std,         ///< the correction is smaller than its own standard deviation
  turn,              ///< a joint crosses zero: its turn (KUKA: bit of T) changes
  arrival,           ///< the correction contradicts the motion that it assumes, whichever way
};

/// As in files: `outside-readings`.
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
  std::vector<Pose> poses;   ///< Cartesian targets: program's frame from TCP; else empty
  std::vector<bool> hinted;  ///< of Cartesian targets: whether `q` holds a hint
  /// KUKA's turn of each target, bit j set if joint j + 1 is below zero; empty if not stated.
  std::vector<int> turns;
  /// Of a program that mixes both kinds: whether a row is a joint target; else empty.
  std::vector<bool> joints;
  /// What Cartesian targets say of their branch; empty if none says anything but a hint.
  std::vector<Configuration> configurations;
  /// Frames and tools, and the one of each row; empty if those of CompensationOptions hold for all.
  std::vector<ProgramSetUp> set_ups;
  std::vector<int> set_up;

  int rows() const { return visits.rows(); }
  bool is_cartesian() const { return !poses.empty(); }
  bool is_cartesian(size_t row) const { return is_cartesian() && (joints.empty() || !joints[row]); }
};

struct CompensationOptions {
  Pose base;  ///< R_0 from the program's frame (KUKA: $BASE)
  Pose tool;  ///< R_7 from the TCP (KUKA: $TOOL, if R_7 is the flange)
  /// The TCP is the frame that was measured: `tool` of the identified robot holds, and what its
  /// effects say about it.
  bool tool_is_measured = false;
  double max_correction = 5e-3;  ///< [m]
  /// Whether targets are corrected that the readings do not cover (outside_readings, below_std).
  bool correct_uncovered = true;
  /// Whether the correction may move external axes; otherwise they stay as programmed. They are
  /// coarser than the joints of the arm, and in the minimisation a metre counts as a radian.
  bool move_external_axes = false;
  std::optional<JointVector> start;  ///< hint of the branch of a first Cartesian target
};

/// How far one pose is from another.
struct PoseDifference {
  double position = 0;     ///< [m]
  double orientation = 0;  ///< angle of the rotation between them [rad]
};

/// A target and the command that stands in its place. Poses are program's frame from TCP.
struct CorrectedTarget {
  JointVector programmed;  ///< where the controller's model has the intended pose [rad]
  Pose intended;
  JointVector q;  ///< commanded [rad]
  Pose pose;      ///< of the controller's model at `q`: what a Cartesian program commands
  bool is_corrected = false;
  /// Of the identified arm, without a correction and at the command.
  PoseDifference before, after;
  /// Of the position after the correction, by what the calibration says of links and effects; root
  /// of the sum over the axes [m]. Nothing if the robot does not state its uncertainty.
  std::optional<double> deviation;
  std::optional<double> leverage;  ///< as Prediction::leverage
  std::vector<CommandNote> notes;

  bool has(CommandNote note) const;
  /// Root mean square of the position error that is expected after the correction [m].
  double expected() const;
};

/// A target that gives the controller no joint angles: out of reach, without a hint of its branch,
/// or with a turn that contradicts it.
class UnreachableTarget : public std::runtime_error {
 public:
  UnreachableTarget(int target_row, const std::string& what)
      : std::runtime_error(what), row(target_row) {}
  int row;
};

/// One that the controller's model does not reach on the branch of its hint.
class OutOfReach : public UnreachableTarget {
 public:
  using UnreachableTarget::UnreachableTarget;
};

/// Whether an effect belongs to the arm, and so moves a program. Effects on links do. Effects on
/// `base` do if a load or the posture drives them: the foot gives way. Driven by time or
/// temperature alone they are the instrument's. Effects on `tool` belong to what carried the
/// reflectors; they move a program only if that is its tool. Those on the instrument, targets and
/// anchors never do, nor do those that may be the instrument's.
bool moves_program(const Effect& effect, bool tool_is_measured);

/// Whether a robot file says that it comes from a calibration: standard deviations, an uncertainty,
/// or effects.
bool states_calibration(const Robot& robot);

/// Identified parameters of links that hold the place of the instrument or of the reflector,
/// because `base` or `tool` was not identified with them: of the first link, which follows the
/// base, and of the last joint and link, which the tool follows. Where base and tool were known
/// otherwise they are the arm's.
std::vector<std::string> parameters_of_station(const Robot& robot);

/// The robot with the zero offsets of one of its sessions. Throws std::invalid_argument if it has
/// no such session, or if none is named and its sessions differ in zero offsets.
Robot in_session(Robot robot, const std::string& session);

/// Finds for each target the joint angles q* at which the identified arm stands where the
/// controller's model puts the target's pose:
///     F_identified(q*, context) tool = F_controller(q_programmed, context) tool,
/// with F the pose R_0 from R_7, without the station's base and tool. Directions of arrival follow
/// the commands from row to row unless the visits state them. Throws UnreachableTarget, and
/// std::invalid_argument if an effect's driver is missing.
std::vector<CorrectedTarget> compensate(const Robot& identified, const Robot& controller,
                                        const Program& program, const CompensationOptions& options);

/// The rows of the worst `count` targets by expected(), then by the error before; worst first.
std::vector<int> worst_targets(const std::vector<CorrectedTarget>& targets, int count);

/// How many targets have a note.
int count_of(const std::vector<CorrectedTarget>& targets, CommandNote note);

/// All in a sentence or two: how many are corrected, what is expected, what to do about the rest.
std::string compensation_sentence(const std::vector<CorrectedTarget>& targets);

/// All notes, in the order of the enumeration.
const std::vector<CommandNote>& command_notes();

}  // namespace armtrue
