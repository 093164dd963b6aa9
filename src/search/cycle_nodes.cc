#include "search/cycle_nodes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace armtrue {
namespace {

constexpr double kOversampling = 1.5;
constexpr double kS = CycleNodes::kHalfWidth;
// b: W falls up to this frequency [rad per node], the lowest that nodes take for one in |u| <= h.
constexpr double kB = std::numbers::pi * (2 - 1 / kOversampling);

// w(t), |t| <= s.
double window(double t) {
  return std::cyl_bessel_i(0.0, kB * std::sqrt(std::max(0.0, kS * kS - t * t)));
}

double transformed(double frequency) {
  const double root = std::sqrt(kB * kB - frequency * frequency);
  return 2 * std::sinh(kS * root) / root;
}

}  // namespace

CycleNodes::CycleNodes(const Eigen::VectorXd& x, double least, double most)
    : middle_((x.minCoeff() + x.maxCoeff()) / 2) {
  u_ = x.array() - middle_;
  step_ = std::numbers::pi / (kOversampling * u_.abs().maxCoeff());
  scale_ = (step_ * u_).unaryExpr(&transformed).inverse();
  first_ = static_cast<int>(std::floor(least / step_)) - kHalfWidth + 1;
  count_ = static_cast<int>(std::floor(most / step_)) + kHalfWidth - first_ + 1;
}

// e_j of some nodes at every x, x.size() x 2 some: their real parts, then the imaginary ones.
Eigen::MatrixXd CycleNodes::values(int first, int some) const {
  Eigen::MatrixXd values(u_.size(), 2 * some);
  const Eigen::ArrayXd by = step_ * u_, sine = by.sin(), cosine = by.cos();
  values.col(0) = scale_ * ((first_ + first) * by).cos();
  values.col(some) = scale_ * ((first_ + first) * by).sin();
  for (int k = 1; k < some; ++k) {
    const auto real = values.col(k - 1).array(), imaginary = values.col(some + k - 1).array();
    values.col(k) = real * cosine - imaginary * sine;
    values.col(some + k) = real * sine + imaginary * cosine;
  }
  return values;
}

CycleNodes::Near CycleNodes::near(double n) const {
  const double place = n / step_;  // between two nodes
  const int first = static_cast<int>(std::floor(place)) - kHalfWidth + 1;
  Near near{first - first_, {}, std::sin(n * middle_), std::cos(n * middle_)};
  for (int k = 0; k < 2 * kHalfWidth; ++k) near.weights[k] = window(place - (first + k));
  return near;
}

}  // namespace armtrue
