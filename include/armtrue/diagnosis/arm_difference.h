#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/diagnosis/change.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// How far two models of one arm are apart, at the measured point of the second, after base and
/// tool of the first are fitted to it: what base and tool can imitate is no difference of the arm.
struct ArmDifference {
  double mean = 0, rms = 0, max = 0;  ///< distance of the points [m]
  std::vector<JointVector> q;         ///< the poses
  std::vector<double> distance;       ///< at each [m]
  int largest = 0;                    ///< pose with the largest
  /// Effects of the arm that the joint angles do not decide, such as backlash and temperature; they
  /// are left out.
  std::vector<std::string> left_out;
  /// RMS distance that two calibrations of one unchanged arm would show: by the uncertainties that
  /// both files state [m]. Empty if one states none, or has effects of which none is stated.
  std::optional<double> by_chance;
  /// Of the RMS distance against `by_chance`: the square of a sum of normal errors, taken as F with
  /// the degrees of freedom of Satterthwaite and those of the poses of the calibrations.
  std::optional<double> p_value;

  bool moved() const { return p_value && *p_value < kChangeSignificance; }
};

/// Up to 200 of 2000 random poses over the travel of the joints, always the same ones: those that the
/// readings of both calibrations cover (Prediction::leverage of at most 1), at the angles that curves
/// over a joint have seen (Effect::measured). Fewer than 40 are too few: then 200 of these angles.
std::vector<JointVector> poses_of_both(const Robot& before, const Robot& after);

/// At these poses, without payload and forces. Effects of the station do not count, see
/// moves_program(). Throws std::invalid_argument if the poses do not show base and tool.
ArmDifference arm_difference(const Robot& before, const Robot& after,
                             const std::vector<JointVector>& poses);

/// Only the mean distance [m].
double mean_arm_difference(const Robot& before, const Robot& after,
                           const std::vector<JointVector>& poses);

}  // namespace armtrue
