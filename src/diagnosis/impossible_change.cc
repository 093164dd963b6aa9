#include "diagnosis/impossible_change.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/worthwhile.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

namespace {

struct LargeChange {
  int parameter;
  double size;  // m or rad
};

// The first parameter of a link that changes by so much, and clearly.
std::optional<LargeChange> find_large_change(const Robot& nominal, const CalibrationResult& result,
                                             double length, double angle) {
  constexpr double kClearly = 5;  // standard deviations
  for (size_t i = 0; i < result.set.kept.size(); ++i) {
    const int parameter = result.set.kept[i];
    const Eigen::Index k = i;
    const bool is_length = parameter_unit(nominal.chain, parameter) == ParameterUnit::metre;
    const double moved = result.change[k];
    if (std::abs(moved) < kClearly * std::sqrt(result.covariance(k, k))) continue;
    const double change = std::abs(is_length ? moved : std::remainder(moved, 2 * std::numbers::pi));
    const bool is_link =
        layout_of(nominal.chain).is_of_links(parameter) && !places_positioner(nominal, parameter);
    if (is_link && change >= (is_length ? length : angle)) return LargeChange{parameter, change};
  }
  return std::nullopt;
}

std::string in_words(const Robot& nominal, const LargeChange& change) {
  const bool is_length = parameter_unit(nominal.chain, change.parameter) == ParameterUnit::metre;
  return fmt::format("these readings would change {} by {:.4g} {}",
                     parameter_name(nominal.chain, change.parameter),
                     change.size / (is_length ? kMillimetre : kDegree), is_length ? "mm" : "deg");
}

}  // namespace

std::optional<std::string> find_impossible_change(const Robot& nominal,
                                                  const CalibrationResult& result) {
  // Larger than any error of an arm, and than the uncertainty that poorly chosen poses leave.
  constexpr double kImpossibleLength = 0.1, kImpossibleAngle = 0.5;  // m, rad
  const auto change = find_large_change(nominal, result, kImpossibleLength, kImpossibleAngle);
  if (!change) return std::nullopt;
  return in_words(nominal, *change) + ", which is no error of an arm" + kCheckColumnsAndJoints;
}

std::optional<std::string> find_unlikely_change(const Robot& nominal, const PlainFit& fit) {
  // What diagnose() takes for a mistake of a nominal robot; a calibration can follow it.
  constexpr double kUnlikelyLength = 0.02, kUnlikelyAngle = 0.1;  // m, rad
  const auto change = find_large_change(nominal, fit.result, kUnlikelyLength, kUnlikelyAngle);
  if (!change) return std::nullopt;
  // Where readings determine a link poorly, as along a path, a lack of the model moves it far. A
  // wrong link shows in the errors of the robot file, too.
  constexpr double kShareSeen = 0.05;  // of a length, or of an angle by 1 m
  try {
    const Robot placed = placed_nominal(nominal, fit.readings);
    const double error = mean_reading_error(placed, fit.readings);
    if (error < kShareSeen * change->size) return std::nullopt;
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // base and tool are not shown
  }
  const std::string_view remedy =
      is_zero_offset(nominal.chain, change->parameter)
          ? ", more than a mastered arm has: is the zero of this joint in the robot file that of "
            "the controller?"
          : ", more than any arm is made wrong by: is the robot file that of this model? Compare "
            "its table with the data sheet";
  return in_words(nominal, *change) + std::string(remedy);
}

}  // namespace armtrue
