#include "linear_algebra/bordered_spectrum.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr int kBisections = 60;
constexpr double kStep = 1;     // of u: error exp(-2 pi^2) of the trapezoidal rule
constexpr double kBeyond = 40;  // of u, beyond the spectrum: the rest is exp(-20) of the integral

class Bordered {
 public:
  Bordered(const Eigen::MatrixXd& symmetric, const std::vector<std::vector<Eigen::Index>>& blocks) {
    std::vector<bool> is_own(symmetric.cols(), false);
    Eigen::Index own = 0;
    for (const auto& block : blocks)
      for (const Eigen::Index k : block) {
        is_own[k] = true;
        ++own;
      }
    std::vector<Eigen::Index> border;
    for (Eigen::Index k = 0; k < symmetric.cols(); ++k)
      if (!is_own[k]) border.push_back(k);
    corner_ = symmetric(border, border);
    diagonal_.resize(own);
    edge_.resize(own, std::ssize(border));
    Eigen::Index first = 0;
    for (const auto& block : blocks) {
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(symmetric(block, block).eval());
      const Eigen::Index count = std::ssize(block);
      diagonal_.segment(first, count) = eigen.eigenvalues();
      edge_.middleRows(first, count) = eigen.eigenvectors().transpose() * symmetric(block, border);
      first += count;
    }
  }

  // Whether sign * (A - s I) is positive definite.
  bool is_definite(double sign, double s) const {
    if (diagonal_.size() > 0 && !((sign * (diagonal_.array() - s)).minCoeff() > 0)) return false;
    return Eigen::LLT<Eigen::MatrixXd>(sign * complement(-s)).info() == Eigen::Success;
  }

  double most() const { return diagonal_.sum() + corner_.trace(); }

  double log_determinant() const {
    const Eigen::LLT<Eigen::MatrixXd> llt(complement(0));
    return diagonal_.array().log().sum() + 2 * llt.matrixLLT().diagonal().array().log().sum();
  }

  // tr (A + t I)^-1
  double trace_of_inverse(double t) const {
    const Eigen::ArrayXd inverse = (diagonal_.array() + t).inverse();
    Eigen::MatrixXd turned = inverse.matrix().asDiagonal() * edge_;
    Eigen::MatrixXd second = turned.transpose() * turned;
    second.diagonal().array() += 1;
    return inverse.sum() + Eigen::LLT<Eigen::MatrixXd>(complement(t)).solve(second).trace();
  }

  Eigen::Index size() const { return diagonal_.size() + corner_.cols(); }

 private:
  // C + t I - B^T (D + t I)^-1 B
  Eigen::MatrixXd complement(double t) const {
    Eigen::MatrixXd left = corner_;
    left.diagonal().array() += t;
    const Eigen::MatrixXd scaled = (diagonal_.array() + t).inverse().matrix().asDiagonal() * edge_;
    left.noalias() -= edge_.transpose() * scaled;
    return left;
  }

  Eigen::VectorXd diagonal_;  // of D, diagonalised
  Eigen::MatrixXd edge_, corner_;
};

// Where `holds` ends between a value at which it does and one at which it does not.
template <typename Holds>
double end_of(double holding, double failing, const Holds& holds) {
  for (int k = 0; k < kBisections; ++k) {
    const double middle = std::sqrt(holding * failing);
    (holds(middle) ? holding : failing) = middle;
  }
  return holding;
}

}  // namespace

std::optional<Spectrum> bordered_spectrum(const Eigen::MatrixXd& symmetric,
                                          const std::vector<std::vector<Eigen::Index>>& blocks,
                                          double least_share) {
  const Bordered matrix(symmetric, blocks);
  const double most = matrix.most();
  if (!(most > 0)) return std::nullopt;
  Spectrum spectrum;
  const auto size = static_cast<double>(matrix.size());
  const auto is_above = [&](double s) { return matrix.is_definite(-1, s); };
  if (!is_above(2 * most)) return std::nullopt;
  // No eigenvalue is larger than their sum, and the largest is at least their mean.
  spectrum.largest = end_of(2 * most, most / (2 * size), is_above);
  const auto is_below = [&](double s) { return matrix.is_definite(1, s); };
  if (!is_below(least_share * spectrum.largest)) return std::nullopt;
  spectrum.smallest = end_of(least_share * spectrum.largest, 2 * spectrum.largest, is_below);
  spectrum.mean_log = matrix.log_determinant() / size;
  for (double u = std::log(spectrum.smallest) - kBeyond; u < std::log(spectrum.largest) + kBeyond;
       u += kStep)
    spectrum.sum_of_inverse_roots +=
        kStep / std::numbers::pi * std::exp(0.5 * u) * matrix.trace_of_inverse(std::exp(u));
  return spectrum;
}

}  // namespace armtrue
