#include "statistics/variance_components.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr int kMaxSteps = 100;
constexpr double kTolerance = 0.05;  // rise of the log likelihood by a step
constexpr double kMostOfStep = 1.5;  // of ln tau
constexpr double kLeastTau = 1e-4;   // of what is usual: such a group adds nothing

// Squared norms of the columns of the inverse of a lower triangle. A column is zero above its
// diagonal, so some columns at a time are solved in what lies below them: a third of the work of a
// whole inverse.
Eigen::VectorXd squares_of_inverse(const Eigen::MatrixXd& lower) {
  constexpr Eigen::Index kColumnsAtOnce = 128;
  const Eigen::Index p = lower.rows();
  Eigen::VectorXd squares(p);
  for (Eigen::Index first = 0; first < p; first += kColumnsAtOnce) {
    const Eigen::Index below = p - first, own = std::min(kColumnsAtOnce, below);
    Eigen::MatrixXd columns = Eigen::MatrixXd::Identity(below, own);
    lower.bottomRightCorner(below, below).triangularView<Eigen::Lower>().solveInPlace(columns);
    squares.segment(first, own) = columns.colwise().squaredNorm().transpose();
  }
  return squares;
}

// The restricted log likelihood L of theta = (ln tau of each group, ln s), and with the priors of tau.
struct Likelihood {
  double alone = 0, value = 0;  // L, L + ln prior
  Eigen::VectorXd mean;        // of u
  double determined = 0;       // of the numbers u, by the readings
  Eigen::VectorXd gradient;    // by theta
  Eigen::MatrixXd curvature;   // average information and the precision of the priors, by theta
  Eigen::VectorXd fixed_point; // theta at which the gradient vanishes with the determined numbers held
};

// ln tau at which squares / tau^2 - determined - precision ln tau = 0, by Newton's method.
double log_tau_at(double squares, double determined, double precision, double log_tau) {
  for (int k = 0; k < 50; ++k) {
    const double pull = squares * std::exp(-2 * log_tau);
    const double newton =
        (pull - determined - precision * log_tau) / (2 * pull + precision);
    log_tau += std::clamp(newton, -1.0, 1.0);
    if (std::abs(newton) < 1e-6) break;
  }
  return log_tau;
}

// With D the diagonal of tau, M = s^2 I + D Z'^T Z' D:
//     u = D M^-1 D Z'^T r',   e = r' - Z' u,
//     2 L = -n ln s^2 - ln det (M / s^2) - r'^T e / s^2,  2 ln prior = -sum (ln tau / spread)^2.
// Average information (Gilmour, Thompson, Cullis 1995): A_gh = w_g^T P w_h / 2 with
//     w_g = 2 Z'_g u_g for ln tau_g, w_s = 2 e for ln s, P = (I - Z' D M^-1 D Z'^T) / s^2.
Likelihood likelihood(const MixedModelSums& sums, const std::vector<VarianceGroup>& groups,
                      const Eigen::VectorXd& theta) {
  const Eigen::Index p = sums.zr.size(), count = std::ssize(groups);
  const double variance = std::exp(2 * theta[count]);
  Eigen::VectorXd tau(p);
  for (Eigen::Index g = 0; g < count; ++g)
    tau.segment(groups[g].first, groups[g].count).setConstant(std::exp(theta[g]));
  Eigen::MatrixXd m = tau.asDiagonal() * sums.zz * tau.asDiagonal();
  m.diagonal().array() += variance;
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(m);
  const auto lower = factor.matrixL();
  Likelihood at;
  Eigen::VectorXd half = tau.cwiseProduct(sums.zr);
  lower.solveInPlace(half);
  at.mean = tau.cwiseProduct(factor.matrixU().solve(half));
  const double log_determinant = 2 * m.diagonal().array().log().sum() -
                                 static_cast<double>(p) * std::log(variance);
  const double left = sums.rr - half.squaredNorm();
  at.alone = -0.5 * (sums.freedom * std::log(variance) + log_determinant + left / variance);
  at.value = at.alone;

  const Eigen::VectorXd undetermined = variance * squares_of_inverse(m);

  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(p, count + 1);  // Z'^T w
  for (Eigen::Index g = 0; g < count; ++g) {
    const auto [first, own, spread] = groups[g];
    products.col(g).noalias() = 2 * sums.zz.middleCols(first, own) * at.mean.segment(first, own);
  }
  products.col(count) = 2 * sums.zr - products.leftCols(count).rowwise().sum();
  const double rest = sums.rr - at.mean.dot(sums.zr) - 0.5 * at.mean.dot(products.col(count));
  Eigen::MatrixXd& a = at.curvature;
  a.resize(count + 1, count + 1);
  for (Eigen::Index g = 0; g < count; ++g)
    a.row(g) = 2 * at.mean.segment(groups[g].first, groups[g].count).transpose() *
               products.middleRows(groups[g].first, groups[g].count);
  a.row(count).head(count) = a.col(count).head(count).transpose();
  a(count, count) = 4 * rest;
  const Eigen::MatrixXd beside = lower.solve(tau.asDiagonal() * products);
  a = (a - beside.transpose() * beside) / (2 * variance);

  at.gradient.resize(count + 1);
  at.fixed_point.resize(count + 1);
  for (Eigen::Index g = 0; g < count; ++g) {
    const auto [first, own, spread] = groups[g];
    const double of_group = static_cast<double>(own) - undetermined.segment(first, own).sum();
    const double squares = at.mean.segment(first, own).squaredNorm();
    const double precision = 1 / (spread * spread);
    at.determined += of_group;
    at.value -= 0.5 * precision * theta[g] * theta[g];
    at.gradient[g] = squares * std::exp(-2 * theta[g]) - of_group - precision * theta[g];
    at.fixed_point[g] = log_tau_at(squares, of_group, precision, theta[g]);
    a(g, g) += precision;
  }
  const double freedom = std::max(1.0, sums.freedom - at.determined);
  at.gradient[count] = rest / variance - freedom;
  at.fixed_point[count] = 0.5 * std::log(std::max(rest, 1e-12 * sums.rr) / freedom);
  return at;
}

}  // namespace

VarianceComponents restricted_likelihood(const MixedModelSums& sums,
                                         const std::vector<VarianceGroup>& groups,
                                         const Eigen::VectorXd& start) {
  const Eigen::Index count = std::ssize(groups);
  const double noise_alone = std::sqrt(sums.rr / sums.freedom);
  Eigen::VectorXd theta(count + 1);
  theta << (start.size() > 0 ? start : Eigen::VectorXd::Ones(count)).array().log().matrix(),
      std::log(0.7 * noise_alone);
  Likelihood best;
  best.value = -std::numeric_limits<double>::infinity();
  Eigen::VectorXd best_theta, safe;  // `safe`: from the best to its fixed point
  for (int step = 0; step < kMaxSteps; ++step) {
    Likelihood at = likelihood(sums, groups, theta);
    const double rise = at.value - best.value;
    if (rise < 0) {  // Newton's step went too far
      if (theta == safe) break;
      theta = safe;
      continue;
    }
    best = std::move(at);
    best_theta = theta;
    if (rise < kTolerance) break;
    const auto bounded = [&](const Eigen::VectorXd& to) {
      Eigen::VectorXd next = theta + (to - theta).cwiseMax(-kMostOfStep).cwiseMin(kMostOfStep);
      next.head(count) = next.head(count).cwiseMax(std::log(kLeastTau));
      return next;
    };
    safe = bounded(best.fixed_point);
    const Eigen::VectorXd newton = best.curvature.ldlt().solve(best.gradient);
    theta = newton.cwiseAbs().maxCoeff() < kMostOfStep ? bounded(theta + newton) : safe;
  }
  VarianceComponents result;
  result.tau = best_theta.head(count).array().exp();
  result.noise = std::exp(best_theta[count]);
  result.mean = best.mean;
  result.determined = best.determined;
  const double alone =
      -0.5 * (sums.freedom * std::log(noise_alone * noise_alone) + sums.freedom);
  result.gain = 2 * (best.alone - alone);
  return result;
}

}  // namespace armtrue
