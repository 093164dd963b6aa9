#include "diagnosis/rounding_check.h"

#include <fmt/format.h>

#include <cmath>
#include <set>
#include <vector>

#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

// Whether the angles of a joint are multiples of `step` [deg] and end with nearly all digits.
bool is_rounded(const Campaign& campaign, int joint, double step) {
  constexpr double kExact = 1e-6;
  constexpr size_t kFewestDigits = 8;
  std::set<int> digits;
  for (const JointVector& q : campaign.q) {
    const double steps = std::abs(q[joint]) / (step * kDegree);
    const double whole = std::round(steps);
    if (std::abs(steps - whole) > kExact) return false;
    digits.insert(static_cast<int>(std::fmod(whole, 10)));
  }
  return digits.size() >= kFewestDigits;
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

std::optional<std::string> find_rounded_angles(const PlainFit& fit) {
  constexpr double kThird = 1.0 / 3;
  const Campaign& readings = fit.readings;
  for (const double step : {0.1, 0.01}) {
    const std::vector<int> joints = rounded_joints(readings, fit.result.robot.chain, step);
    if (joints.empty()) continue;
    const FitEquations equations = fit_equations(fit, joints);
    const double variance = step * kDegree * step * kDegree / 12;
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
        "the joint angles have steps of {:g} deg, which alone is worth {:.2g} mm (RMS): were they "
        "read from a display? Log them with more digits",
        step, moved / kMillimetre);
  }
  return std::nullopt;
}

}  // namespace armtrue
