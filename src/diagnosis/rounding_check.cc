#include "diagnosis/rounding_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/pose.h"
#include "armtrue/kinematics/units.h"
#include "statistics/rounding.h"

namespace armtrue {
namespace {

// The last digit of an angle, in the unit in which it was written.
struct AngleStep {
  double step;  // [rad]
  const char* in_words;
};

// Coarse steps first: what has steps of 0.1 deg has those of 0.01 deg, too.
constexpr std::array<AngleStep, 5> kAngleSteps{{{1e-2, "0.01 rad"},
                                                {0.1 * kDegree, "0.1 deg"},
                                                {1e-3, "0.001 rad"},
                                                {0.01 * kDegree, "0.01 deg"},
                                                {1e-4, "0.0001 rad"}}};

// Whether the angles of a joint are multiples of `step` [rad] and end with nearly all digits.
bool is_rounded(const Campaign& campaign, int joint, double step) {
  std::vector<double> angles;
  for (const JointVector& q : campaign.q) angles.push_back(q[joint]);
  return last_digits(angles, step).value_or(0) >= kFewestLastDigits;
}

// Zero offsets of the joints whose angles are rounded so.
std::vector<int> rounded_joints(const Campaign& campaign, const KinematicChain& chain,
                                double step) {
  std::vector<int> parameters;
  for (int joint = 0; joint < joint_count(chain); ++joint)
    if (!is_prismatic(joint_link(chain, joint)) && is_rounded(campaign, joint, step))
      parameters.push_back(zero_offset(chain, joint));
  return parameters;
}

}  // namespace

namespace {

// Coordinates [m], or angles a, b, c [rad], of all readings.
std::array<std::vector<double>, 3> numbers_read(const Campaign& readings, bool of_orientation) {
  std::array<std::vector<double>, 3> numbers;
  for (int row = 0; row < readings.rows(); ++row) {
    const Eigen::Vector3d read =
        of_orientation ? abc_from_rotation(readings.orientation[row].toRotationMatrix())
                       : readings.position[row];
    for (int axis = 0; axis < 3; ++axis) numbers[axis].push_back(read[axis]);
  }
  return numbers;
}

}  // namespace

std::optional<std::string> find_rounded_readings(const PlainFit& fit) {
  // A third of the variance that is left; beside less the rounding is lost in the noise.
  constexpr double kThird = 1.0 / 3;
  const Campaign& readings = fit.readings;
  const auto is_rounded_to = [&](bool of_orientation, double step) {
    return std::ranges::all_of(numbers_read(readings, of_orientation), [&](const auto& numbers) {
      return last_digits(numbers, step).value_or(0) >= kFewestLastDigits;
    });
  };
  const auto is_felt = [&](double step, double sigma) {
    return step * step / 12 > kThird * sigma * sigma;
  };
  for (const double step : {1.0, 0.1, 0.01})
    if (!readings.position.empty() && is_felt(step * kMillimetre, fit.result.sigma.position) &&
        is_rounded_to(false, step * kMillimetre))
      return fmt::format(
          "the points have steps of {:g} mm, which alone is worth {:.2g} mm (RMS), also where "
          "repeats read the same: export them with more digits",
          step, step * std::sqrt(3.0 / 12));
  for (const double step : {1.0, 0.1, 0.01})
    if (readings.has_orientation() && is_felt(step * kDegree, fit.result.sigma.orientation) &&
        is_rounded_to(true, step * kDegree))
      return fmt::format(
          "the orientations have steps of {:g} deg, which alone is worth {:.2g} mrad (RMS): export "
          "them with more digits",
          step, step * kDegree / kMilliradian * std::sqrt(3.0 / 12));
  return std::nullopt;
}

std::optional<std::string> find_rounded_angles(const PlainFit& fit) {
  constexpr double kThird = 1.0 / 3;
  const Campaign& readings = fit.readings;
  for (const auto& [step, in_words] : kAngleSteps) {
    const std::vector<int> joints = rounded_joints(readings, fit.result.robot.chain, step);
    if (joints.empty()) continue;
    const FitEquations equations = fit_equations(fit, joints);
    const double variance = step * step / 12;
    const double share =
        equations.columns.squaredNorm() * variance / equations.residual.squaredNorm();
    if (share < kThird || share > 1 / kThird) return std::nullopt;
    double position = 0;
    for (int row = 0; row < readings.rows(); ++row)
      position +=
          equations.columns.middleRows(row * equations.row_size, readings.reading_size().position)
              .squaredNorm();
    const double moved =
        fit.result.sigma.position * std::sqrt(position * variance / readings.rows());
    return fmt::format(
        "the joint angles have steps of {}, which alone is worth {:.2g} mm (RMS): were they "
        "read from a display? Log them with more digits",
        in_words, moved / kMillimetre);
  }
  return std::nullopt;
}

}  // namespace armtrue
