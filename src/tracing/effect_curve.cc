#include "armtrue/tracing/effect_curve.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "armtrue/calibration/pose_bootstrap.h"
#include "tracing/curve_points.h"

namespace armtrue {
namespace {

constexpr int kStepsPerCycle = 16;         // of frequency, within the resolution
constexpr double kMinShareOfCycle = 0.05;  // of the variance of a curve

bool is_one_quantity(const Driver& driver) {
  return !driver.is_pair() && !driver.factor &&
         (driver.kind == DriverKind::joint_angle || driver.kind == DriverKind::time ||
          driver.kind == DriverKind::temperature);
}

// What drives an effect in a row: a joint angle, the time or a temperature.
double reading_of(const Driver& driver, const Campaign& campaign, int row) {
  if (driver.kind == DriverKind::joint_angle) return campaign.q[row][driver.joint];
  if (driver.kind == DriverKind::time) return campaign.time_s[row];
  const auto& names = campaign.temperature_names;
  const auto sensor = std::find(names.begin(), names.end(), driver.where) - names.begin();
  return campaign.temperature_c[row][sensor];
}

}  // namespace

std::vector<CurvePoint> effect_curve(const CalibrationResult& fit, const Campaign& campaign,
                                     size_t effect, const Eigen::MatrixXd& bootstrap_draws) {
  const Effect& e = fit.robot.effects[effect];
  const int points = curve_points(e.shape);
  const Driver& driver = e.driver;
  if (!is_one_quantity(driver) || !find_parameter(fit.robot.chain, e.parameter)) return {};

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
  const Eigen::Index count = all.size();
  const Eigen::Map<const Eigen::VectorXd> coefficients(all.data(), count);
  const Eigen::MatrixXd draws = bootstrap_draws(Eigen::all, unknowns);
  const Eigen::Index first = fit.set.kept.size();
  const Eigen::MatrixXd covariance =
      fit.covariance.block(first, first, unknown, unknown)(unknowns, unknowns);
  const auto values_at = [&](double x) {
    Eigen::VectorXd values(count);
    Eigen::Index k = 0;
    for (const Effect* other : together) {
      evaluate(other->shape, x, values.data() + k);
      k += other->coefficients.size();
    }
    return values;
  };
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(count);
  double low = reading_of(driver, campaign, 0), high = low;
  for (int row = 0; row < campaign.rows(); ++row) {
    const double x = reading_of(driver, campaign, row);
    mean += values_at(x) / campaign.rows();
    low = std::min(low, x);
    high = std::max(high, x);
  }
  std::vector<CurvePoint> curve;
  for (int i = 0; i < points; ++i) {
    const double x = low + (high - low) * i / (points - 1);
    const Eigen::VectorXd values = values_at(x) - mean;
    const double deviation = std::sqrt(std::max(0.0, values.dot(covariance * values)));
    const auto [below, above] =
        interval_about(draws * values, deviation, static_cast<int>(campaign.pose_ids.size()));
    curve.push_back({x, values.dot(coefficients), 0.5 * (above - below)});
  }
  return curve;
}

std::optional<StrongestCycle> strongest_cycle(const std::vector<CurvePoint>& curve) {
  const Eigen::Index points = curve.size();
  if (points < 8) return std::nullopt;
  Eigen::VectorXd x(points), y(points);
  for (Eigen::Index i = 0; i < points; ++i) {
    x[i] = curve[i].driver;
    y[i] = curve[i].value;
  }
  const double resolution = 2 * std::numbers::pi / (x[points - 1] - x[0]);
  const double variance = (y.array() - y.mean()).matrix().squaredNorm();
  Eigen::MatrixXd sines(points, 4);
  sines.leftCols<2>() << Eigen::VectorXd::Ones(points), x;
  const Eigen::Vector2d line =
      Eigen::VectorXd(Eigen::MatrixXd(sines.leftCols<2>()).householderQr().solve(y));
  const double straight = (y - sines.leftCols<2>() * line).squaredNorm();
  std::optional<StrongestCycle> best;
  // Four points of a cycle show its amplitude.
  const double most = 0.25 * static_cast<double>(points) * resolution;
  for (double n = 2 * resolution; n < most; n += resolution / kStepsPerCycle) {
    sines.col(2) = (n * x).array().sin();
    sines.col(3) = (n * x).array().cos();
    const Eigen::Vector4d c = Eigen::VectorXd(sines.householderQr().solve(y));
    const double share = (straight - (y - sines * c).squaredNorm()) / variance;
    if (share > (best ? best->share : kMinShareOfCycle))
      best = {n, resolution, std::hypot(c[2], c[3]), share};
  }
  return best;
}

}  // namespace armtrue
