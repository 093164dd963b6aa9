#include "diagnosis/impossible_change.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "calibration/prior.h"

namespace armtrue {

std::optional<std::string> find_impossible_change(const Robot& nominal,
                                                  const CalibrationResult& result) {
  // Larger than any error of an arm, and than the uncertainty that poorly chosen poses leave.
  constexpr double kImpossibleLength = 0.1, kImpossibleAngle = 0.5;  // m, rad
  constexpr double kClearly = 5;                                     // standard deviations
  for (size_t i = 0; i < result.set.kept.size(); ++i) {
    const int parameter = result.set.kept[i];
    const auto k = static_cast<Eigen::Index>(i);
    const bool is_length = parameter_unit(nominal.chain, parameter) == ParameterUnit::metre;
    const double moved = result.change[k];
    if (std::abs(moved) < kClearly * std::sqrt(result.covariance(k, k))) continue;
    const double change = std::abs(is_length ? moved : std::remainder(moved, 2 * std::numbers::pi));
    const bool is_link = layout_of(nominal.chain).is_of_links(parameter) &&
                         !places_positioner(nominal, parameter);
    if (!is_link || change < (is_length ? kImpossibleLength : kImpossibleAngle)) continue;
    return fmt::format("these readings would change {} by {:.4g} {}, which is no error of an arm{}",
                       parameter_name(nominal.chain, parameter),
                       change / (is_length ? kMillimetre : kDegree), is_length ? "mm" : "deg",
                       kCheckColumnsAndJoints);
  }
  return std::nullopt;
}

}  // namespace armtrue
