#include "calibration/prior.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/parameters.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr double kMaxEffect = 0.005;  // m, rad: of a parameter, by one effect
constexpr double kTypicalCurve = 5e-4, kMinCurve = 1e-6;
constexpr size_t kMinOfCurve = 3;  // coefficients

}  // namespace

std::vector<Prior> priors_of(const Robot& robot, const SessionModels& models) {
  std::vector<Prior> priors;
  for (int k = 0; k < models.geometric_count(); ++k) {
    const auto found = robot.priors.find(parameter_name(robot.chain, models.geometric()[k]));
    if (found != robot.priors.end()) priors.push_back({k, found->second});
  }
  int k = models.geometric_count(), curves = 0;
  for (int e = 0; e < models.fitted_effects(); ++e) {
    const Effect& effect = robot.effects[e];
    const bool is_curve =
        effect.shape.kind == ShapeKind::series && effect.coefficients.size() >= kMinOfCurve;
    double squares = 0;
    for (const Coefficient& c : effect.coefficients) squares += c.value * c.value;
    const double as_before = std::sqrt(squares / static_cast<double>(effect.coefficients.size()));
    const double curve = squares > 0 ? std::max(kMinCurve, as_before) : kTypicalCurve;
    for (const Coefficient& c : effect.coefficients) {
      const double value = models.mean_square_value(k - models.geometric_count());
      if (is_curve)
        priors.push_back({k, curve, c.value, curves});
      else if (value > 0)
        priors.push_back({k, kMaxEffect / std::sqrt(value), c.value});
      ++k;
    }
    curves += is_curve;
  }
  return priors;
}

void add_priors(const std::vector<Prior>& priors, Eigen::MatrixXd& information) {
  for (const Prior& prior : priors)
    information(prior.unknown, prior.unknown) += 1.0 / (prior.deviation * prior.deviation);
}

CurveUpdate update_curves(const Eigen::MatrixXd& factor, const Eigen::VectorXd& x,
                          std::vector<Prior>& priors) {
  CurveUpdate update;
  int curves = 0;
  for (const Prior& prior : priors) curves = std::max(curves, prior.curve + 1);
  if (curves == 0) return update;
  const Eigen::Index p = x.size();
  const Eigen::MatrixXd triangle = factor.topLeftCorner(p, p);
  Eigen::MatrixXd information = triangle.transpose() * triangle;
  add_priors(priors, information);
  const Eigen::VectorXd unit = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  const Eigen::MatrixXd inverse = scaled.ldlt().solve(Eigen::MatrixXd::Identity(p, p));
  for (int curve = 0; curve < curves; ++curve) {
    double determined = 0, squares = 0, old = 0;
    for (const Prior& prior : priors) {
      if (prior.curve != curve) continue;
      const double variance =
          inverse(prior.unknown, prior.unknown) * unit[prior.unknown] * unit[prior.unknown];
      old = prior.deviation;
      const double by_readings = std::clamp(1.0 - variance / (old * old), 0.0, 1.0);
      determined += by_readings;
      update.undetermined += 1.0 - by_readings;
      squares += (prior.start + x[prior.unknown]) * (prior.start + x[prior.unknown]);
    }
    const double deviation =
        std::clamp(std::sqrt(squares / std::max(determined, 0.5)), kMinCurve, kMaxEffect);
    update.settled = update.settled && std::abs(deviation - old) < 0.1 * old;
    for (Prior& prior : priors)
      if (prior.curve == curve) prior.deviation = deviation;
  }
  return update;
}

}  // namespace armtrue
