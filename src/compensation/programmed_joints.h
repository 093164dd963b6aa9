#pragma once

#include <optional>
#include <span>

#include "armtrue/compensation/compensation.h"
#include "armtrue/effects/arrival.h"
#include "compensation/program_arm.h"

namespace armtrue {

/// Throws std::invalid_argument if the visits lack the driver of an effect that moves a program.
/// Only directions and strokes of the joints may follow from the sequence of the rows; if
/// directions are stated, strokes must be stated too.
void require_context(const Robot& robot, const Campaign& visits, bool tool_is_measured);

/// Whether an effect follows the direction or the stroke by which a joint arrives.
bool follows_motion(const Effect& effect);
/// Whether one of its effects does.
bool follows_motion(const Robot& robot);

/// Directions and strokes of the joints from one row of a program to the next: as the rows state
/// them, otherwise from the sequence of the commands.
class CommandedMotion {
 public:
  explicit CommandedMotion(const Campaign& visits)
      : states_arrival_(!visits.arrival.empty()), states_stroke_(!visits.stroke.empty()) {}

  /// Sets arrival and stroke of a context by the motion from the last command through `way`, whose
  /// last place is the next command. Between two places every joint moves in one direction.
  void arrive(Context& context, std::span<const JointVector> way) const;
  void arrive(Context& context, const JointVector& q) const { arrive(context, std::span(&q, 1)); }
  /// Makes the last place of `way` the last command.
  void go_to(std::span<const JointVector> way) { last_ = behind(way); }
  void go_to(const JointVector& q) { go_to(std::span(&q, 1)); }

 private:
  Arrival behind(std::span<const JointVector> way) const;

  bool states_arrival_, states_stroke_;
  std::optional<Arrival> last_;  // at the last command
};

/// The result of a search for joint angles on a branch.
enum class Reach { reached, on_another_branch, unreachable };
struct FoundJoints {
  JointVector q;
  Reach reach = Reach::unreachable;
};

/// Number of starts of an exhaustive search.
inline constexpr int kAllStarts = 60;

/// Joint angles at which the arm has the pose R_0 from TCP, on the branch of `hint` and within a
/// whole turn of it. The first start is the hint; `more_starts` lie beside it, in a fixed order.
FoundJoints joints_on_branch(const ProgramArm& arm, const Context& context, const Pose& wanted,
                             const JointVector& hint, int more_starts);

/// Joint angles at which the controller's model has the targets of a program.
class ProgrammedJoints {
 public:
  /// All must outlive it.
  ProgrammedJoints(const Program& program, const CompensationOptions& options,
                   const ProgramArm& controller)
      : program_(program), options_(options), controller_(controller) {}

  /// Angles near those of a row: the joint target itself or, of a Cartesian one, its hint, else
  /// `previous`, else CompensationOptions::start. Throws UnreachableTarget if there are none.
  JointVector hint(int row, const std::optional<JointVector>& previous) const;

  /// Why a first Cartesian row has no hint.
  std::string why_no_hint() const;

  /// The angles, with the turns that the row states. Throws OutOfReach if the model does not reach
  /// the pose on the branch of the hint, UnreachableTarget if its turn contradicts it.
  JointVector at(int row, const Context& context, const JointVector& hint,
                 int more_starts = kAllStarts) const;

 private:
  // Of a robot program, which has no columns; a table states no configurations.
  bool is_text() const { return !program_.configurations.empty(); }
  // The joints with the external axes of the row, if the program states them.
  JointVector with_external(int row, JointVector q) const;
  void check_turn(int row, const JointVector& q) const;
  JointVector in_turn(int row, JointVector q) const;

  const Program& program_;
  const CompensationOptions& options_;
  const ProgramArm& controller_;
};

}  // namespace armtrue
