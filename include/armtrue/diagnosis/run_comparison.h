#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/campaign/reading_sigma.h"
#include "armtrue/campaign/training_rows.h"
#include "armtrue/diagnosis/arm_difference.h"
#include "armtrue/diagnosis/change.h"
#include "armtrue/diagnosis/readings_difference.h"
#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/parameters.h"

namespace armtrue {

/// A number of two runs, SI. Fields that are not known are empty.
struct NumberChange {
  std::optional<double> before, after;
  std::optional<double> change;
  std::optional<double> std;  ///< of the change, sqrt(s1^2 + s2^2); only of independent readings
  /// 95 % interval: Student's t with the degrees of freedom of both (Welch, Satterthwaite).
  std::optional<std::array<double, 2>> ci95;
  std::optional<double>
      p_value;  ///< two-sided, times the number of all that are tested (Bonferroni)

  bool moved() const { return p_value && *p_value < kChangeSignificance; }
};

/// Whether an effect has no known cause: kRemainder, or a curve over one joint that the catalogue
/// does not explain.
bool is_nameless(const Effect& effect);

/// In which of the runs something was identified or found.
enum class InRuns { both, before, after };

/// Whose runs are compared: those of one arm, earlier and later, or those of two arms of one type,
/// the first of which stands for `before` and the second for `after`.
enum class ComparedArms { one, two };

/// A geometric parameter of two runs.
struct ComparedParameter {
  std::string name;
  DisplayUnit unit;  ///< in files
  bool of_arm;       ///< of a link or a coupling; else of base, tool, target, anchor or contact
  InRuns in;         ///< which runs identified it
  NumberChange number;
  /// Mean motion of the tool by this change alone, base and tool placed [m]; of a parameter that
  /// moved.
  std::optional<double> at_tool;
  /// ArmDifference::mean that this change alone leaves [m]; of a parameter that moved, where a
  /// scale is its rival.
  std::optional<double> left_beside;
};

/// A coefficient of a NamedEffect.
struct NamedCoefficient {
  std::string name, unit;
  double value = 0, std = 0;  ///< [SI]; std 0: not identified
};

/// An effect as a document states it.
struct NamedEffect {
  std::string name, parameter, driver, shape;
  std::string
      inner;  ///< inner values of the shape: only coefficients of equal ones can be compared
  std::vector<NamedCoefficient> coefficients;

  bool of_arm() const;
  /// Whether the 95 % intervals of all coefficients contain zero, as with effects that only a prior
  /// keeps in a model: a model without the effect predicts the same.
  bool may_be_none() const;
  std::string in_words() const;  ///< "joint compliance (A3.theta follows gravity-torque 3)"
};

/// One effect, or one that both runs have.
struct ComparedEffect {
  NamedEffect effect;  ///< of the run after, if that has it
  InRuns in;
  bool same_inner = true;             ///< else `change` of its coefficients is empty
  std::vector<NumberChange> numbers;  ///< one for each of its coefficients
  std::vector<double> std_before;     ///< NamedCoefficient::std of the run before; if both have it
};

/// The effects without a name (is_nameless()) that move one parameter by the angle of one joint,
/// added up, over the angles that both runs have seen.
struct RemainderCurve {
  std::string parameter;
  int joint = 0;                                         ///< 0-based
  JointName name;                                        ///< of the joint
  DisplayUnit unit;                                      ///< of the values
  std::vector<double> q;                                 ///< [rad or m]
  std::vector<double> before, after;                     ///< [rad or m]
  double rms_before = 0, rms_after = 0, rms_change = 0;  ///< without their means
};

/// Which inputs, such as readings, two runs have in common.
enum class Shared {
  all,      ///< the same
  some,     ///< some of them
  none,     ///< others
  unknown,  ///< a file does not state it
};

/// The figures of a loop or an evaluation [m].
struct RunErrors {
  std::string verdict, sentence;        ///< of a loop
  std::optional<double> before, after;  ///< mean error without and with what the run found
  std::optional<double> floor;
  int poses = 0;
};

/// One side of a comparison.
struct ComparedRun {
  std::string name;                        ///< of its file, for sentences
  const Robot* robot = nullptr;            ///< of a calibrated robot
  const TrainingRows* training = nullptr;  ///< its readings
  std::optional<ReadingSigma> spread{};    ///< of its residuals
  std::vector<NamedEffect> effects{};
  std::optional<RunErrors> errors{};
  // What made it, as its file states it; empty if it does not.
  std::string command{}, version{}, nominal{};  ///< `nominal`: SHA-256 of the robot file
  std::vector<std::string> readings{};          ///< SHA-256 of the files
  const Campaign* campaign = nullptr;           ///< the readings themselves, if they are at hand
};

/// Whether readings of one run are among those of the other, by the marks of their rows or else by
/// the SHA-256 of their files.
Shared shared_readings(const ComparedRun& before, const ComparedRun& after);

/// Sentences on what a difference depends on: readings, nominal robots, commands and versions,
/// names of the robots, residuals.
std::vector<std::string> notes_of_runs(const ComparedRun& before, const ComparedRun& after,
                                       ComparedArms arms = ComparedArms::one);

/// Poses at which arms are compared.
struct NamedPoses {
  std::vector<std::string> names;
  std::vector<JointVector> q;
};

/// The result of compare_runs().
struct RunComparison {
  ComparedArms arms = ComparedArms::one;
  Shared readings = Shared::unknown;
  /// Why no number is tested, each a sentence without a full stop; empty if they are.
  std::vector<std::string> untested;
  int tested = 0;  ///< numbers
  std::vector<ComparedParameter> parameters;
  /// Parameters of links that neither run identified and that differ: by other nominal robots, or
  /// by an Effect::mean that a loop added.
  std::vector<std::string> held_apart;
  std::vector<ComparedEffect> effects;
  std::vector<RemainderCurve> remainder;
  std::optional<ArmDifference> arm;
  std::string largest_pose;  ///< name of that with the largest distance; empty if it has none
  std::optional<ReadingsDifference> by_readings;  ///< where those of both runs are at hand
  std::optional<std::array<RunErrors, 2>> errors;
  /// What changed, in one sentence or two.
  std::string sentence;

  /// Whether a number of the arm, or the arm as a whole, changed by more than chance, or the two
  /// arms differ by more; nothing where that is not tested, or undecided() says why it is not
  /// known.
  std::optional<bool> arm_moved() const;
  /// Why the test does not tell whether the arm changed, as a sentence without a full stop: the
  /// arms differ by more than noise and by less than what the models lack may make and no readings
  /// are at hand, or one scale of all lengths explains the difference. Empty if it tells.
  std::string undecided() const;
  /// The smallest RMS distance of the arms that would have been seen [m].
  std::optional<double> smallest_seen() const;
};

/// Why the numbers of two robots mean different things, as an error with its remedy; empty if they
/// do not: other links, kinds of joints or signs, or frames of another convention.
std::string why_not_comparable(const Robot& before, const std::string& name_before,
                               const Robot& after, const std::string& name_after);

/// Compares two runs. With robots, their arms are compared at `poses`, or at poses_of_both() if
/// there are none.
///
/// Numbers are tested if the readings of the runs are others, and if both have the same unknowns:
/// where one model holds a parameter, or lacks an effect that is not NamedEffect::may_be_none(),
/// other parameters compensate it, and their change is no change of the arm. Of independent
/// readings the change of a number has the standard deviation sqrt(s1^2 + s2^2); it is significant
/// if its p-value, times the number of all that are tested, is below kChangeSignificance.
RunComparison compare_runs(const ComparedRun& before, const ComparedRun& after,
                           const NamedPoses& poses = {}, ComparedArms arms = ComparedArms::one);

/// How many of the tested parameters of the arm moved, and how many are tested.
std::array<int, 2> moved_of_tested(const RunComparison& found);

}  // namespace armtrue
