#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/doubts.h"
#include "armtrue/diagnosis/change.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// All lengths of the later arm are longer by one ratio, as by the scale of an instrument or by the
/// temperature of the arm.
struct CommonScale {
  double ratio = 0;    ///< later over earlier, less 1
  double mean = 0;     ///< ArmDifference::mean that the scale leaves [m]
  double p_value = 0;  ///< ArmDifference::p_value of what it leaves
};

/// How far two models of one arm are apart, at the measured point of the second, after base and
/// tool of the first are fitted to it: a difference that base and tool can imitate is none of the
/// arm.
struct ArmDifference {
  double mean = 0, rms = 0, max = 0;  ///< distance between the points of both models [m]
  std::vector<JointVector> q;         ///< the poses
  std::vector<double> distance;       ///< at each [m]
  int largest = 0;                    ///< index of the pose with the largest distance
  HiddenError hidden;                 ///< what the fit of base and tool to these poses hides
  /// Effects of the arm that joint angles do not determine, such as backlash and temperature; they
  /// are left out.
  std::vector<std::string> left_out;
  /// RMS distance that two calibrations of one unchanged arm would show, by the uncertainties of
  /// both files [m]. Empty if one states none, or not that of all its effects, or has a kRemainder.
  std::optional<double> by_chance;
  /// p-value of rms^2 / by_chance^2, taken as F-distributed with the degrees of freedom of
  /// Satterthwaite and the fewest poses of a calibration - 1.
  std::optional<double> p_value;
  /// p-value of the same against the noise of the readings alone: each root of a covariance times
  /// sqrt(1 - rest^2 / reading^2) of its file, and not widened.
  std::optional<double> p_value_of_noise;
  /// The smallest RMS distance that would be more than chance [m].
  std::optional<double> smallest_seen;
  /// One scale of all lengths in place of a change of the arm; where `by_chance` is known.
  std::optional<CommonScale> scale;

  /// By how many times the RMS distance is larger where base and tool are fitted to other poses
  /// than to these; infinite if nothing of the distance is left.
  double times_elsewhere() const {
    return std::sqrt((hidden.freedom + hidden.unknowns) / hidden.freedom);
  }
  bool moved() const { return p_value && *p_value < kChangeSignificance; }
  /// More than noise makes, and less than what the models lack may make: the arm may have changed,
  /// or may not.
  bool is_undecided() const {
    return !moved() && p_value_of_noise && *p_value_of_noise < kChangeSignificance;
  }
};

/// Up to 200 of 2000 random poses over the travel of the joints, always the same ones: those that
/// the readings of both calibrations cover (Prediction::leverage of at most 1), at the angles that
/// curves over a joint have seen (Effect::measured). If fewer than 40 remain, the first 200 of the
/// 2000.
std::vector<JointVector> poses_of_both(const Robot& before, const Robot& after);

/// The difference at these poses, without payload and forces. Effects of the station do not count,
/// see moves_program(). Throws std::invalid_argument if the poses do not show base and tool.
ArmDifference arm_difference(const Robot& before, const Robot& after,
                             const std::vector<JointVector>& poses);

/// ArmDifference::mean alone [m].
double mean_arm_difference(const Robot& before, const Robot& after,
                           const std::vector<JointVector>& poses);

}  // namespace armtrue
