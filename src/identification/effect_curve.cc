#include "armtrue/identification/effect_curve.h"

#include <algorithm>
#include <cmath>

#include "armtrue/identification/pose_bootstrap.h"

namespace armtrue {

std::vector<CurvePoint> effect_curve(const CalibrationResult& fit, const Campaign& campaign,
                                     size_t effect, const Eigen::MatrixXd& departures) {
  const Effect& e = fit.robot.effects[effect];
  const int points = e.shape.kind == ShapeKind::harmonic
                         ? static_cast<int>(std::clamp(8 * e.shape.harmonic, 41.0, 801.0))
                         : 41;
  const Driver& driver = e.driver;
  if (driver.is_pair() || driver.factor || !find_parameter(fit.robot.chain, e.parameter)) return {};
  const auto reading = [&](int row) -> double {
    if (driver.kind == DriverKind::joint_angle) return campaign.q[row][driver.joint];
    if (driver.kind == DriverKind::time) return campaign.time_s[row];
    const auto& names = campaign.temperature_names;
    const auto sensor = std::find(names.begin(), names.end(), driver.where) - names.begin();
    return campaign.temperature_c[row][static_cast<size_t>(sensor)];
  };
  if (driver.kind != DriverKind::joint_angle && driver.kind != DriverKind::time &&
      driver.kind != DriverKind::temperature)
    return {};

  std::vector<const Effect*> together;
  std::vector<Eigen::Index> unknowns;
  std::vector<double> all;
  Eigen::Index unknown = 0;
  for (const Effect& other : fit.robot.effects) {
    const bool belongs = other.parameter == e.parameter && other.driver == driver;
    if (belongs) together.push_back(&other);
    for (const Coefficient& coefficient : other.coefficients) {
      if (belongs) {
        unknowns.push_back(unknown);
        all.push_back(coefficient.value);
      }
      ++unknown;
    }
  }
  const auto count = static_cast<Eigen::Index>(all.size());
  const Eigen::Map<const Eigen::VectorXd> coefficients(all.data(), count);
  const Eigen::MatrixXd draws = departures(Eigen::all, unknowns);
  const auto first = static_cast<Eigen::Index>(fit.set.kept.size());
  const Eigen::MatrixXd covariance =
      fit.covariance.block(first, first, unknown, unknown)(unknowns, unknowns);
  const int poses = static_cast<int>(campaign.pose_ids.size());
  const auto values_at = [&](double x) {
    Eigen::VectorXd values(count);
    Eigen::Index k = 0;
    for (const Effect* other : together) {
      evaluate(other->shape, x, values.data() + k);
      k += static_cast<Eigen::Index>(other->coefficients.size());
    }
    return values;
  };
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(count);
  double low = reading(0), high = low;
  for (int row = 0; row < campaign.rows(); ++row) {
    const double x = reading(row);
    mean += values_at(x) / campaign.rows();
    low = std::min(low, x);
    high = std::max(high, x);
  }
  std::vector<CurvePoint> curve;
  for (int i = 0; i < points; ++i) {
    const double x = low + (high - low) * i / (points - 1);
    const Eigen::VectorXd values = values_at(x) - mean;
    const double deviation = std::sqrt(std::max(0.0, values.dot(covariance * values)));
    const auto [below, above] = interval_about(draws * values, deviation, poses);
    curve.push_back({x, values.dot(coefficients), 0.5 * (above - below)});
  }
  return curve;
}

}  // namespace armtrue
