#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {

/// What some effects explain beside all else in the model: of each the columns, and the readings,
/// projected off the rest of what is fitted, in coordinates of all that they span together.
struct BesideTheRest {
  std::vector<Eigen::MatrixXd> columns;
  Eigen::VectorXd readings;
  Eigen::MatrixXd span;      ///< orthonormal: the coordinates as equations
  Eigen::VectorXd residual;  ///< of the equations: what none of them explains
  std::vector<int> pose;     ///< number of the pose, from 0, of each `row_size` equations
  int row_size = 1;

  int poses() const { return pose.empty() ? 0 : 1 + *std::max_element(pose.begin(), pose.end()); }
};

/// A fit seen from close by: the derivatives of every reading with respect to every parameter,
/// whitened and weighted, what the fitted ones span, and the residual that is left.
class Linearization {
 public:
  Linearization(const CalibrationResult& fit, const Campaign& campaign);

  int rows() const { return static_cast<int>(pose_.size()); }
  int row_size() const { return row_size_; }
  /// Number of the pose of each row, by its id; rows of one pose need not be independent.
  const std::vector<int>& pose() const { return pose_; }
  /// (rows * row_size) x kTargetParameters.
  const Eigen::MatrixXd& jacobian() const { return jacobian_; }
  /// Orthonormal basis of the fitted columns, (rows * row_size) x rank.
  const Eigen::MatrixXd& basis() const { return basis_; }
  /// Orthogonal to the basis.
  const Eigen::VectorXd& residual() const { return residual_; }
  double residual_norm() const { return residual_norm_; }  ///< sum of squares
  /// How many independent equations the readings are worth beyond those that the fit takes up. The
  /// residual lies in so many dimensions: evidence counted over all equations would be too strong
  /// by what the geometry has absorbed, half of it and more in a campaign of few poses.
  double residual_freedom() const {
    return std::max(1.0, static_cast<double>(residual_.size()) / design_effect_ -
                             static_cast<double>(basis_.cols()));
  }

  /// Standard deviation of the coefficient of one more column, its value unknown as that of all in
  /// the model: clustered by pose, as the covariance of the fit is.
  double standard_deviation(const Eigen::VectorXd& column) const;

  /// What the model loses with some of its effects, in coordinates of the basis.
  struct Loss {
    Eigen::MatrixXd span;      ///< rank x independent columns, orthonormal: what only they span
    Eigen::VectorXd residual;  ///< what they explain of the readings, in that span
  };
  Loss without(const std::vector<int>& effects) const;

  /// What the effects from `first` on explain.
  BesideTheRest effects_from(int first) const;

  /// The fitted geometric parameters (as in the set, from 0) that move most, by a tenth of the
  /// effect or more, when what imitates it (in all rows, whitened) takes its place.
  std::vector<int> most_refitted(int effect, const Eigen::VectorXd& imitation, int count) const;

 private:
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> all_but(const std::vector<int>& effects) const;
  // What is orthogonal to the columns of a decomposition, in coordinates of the basis.
  Eigen::MatrixXd complement(const Eigen::ColPivHouseholderQR<Eigen::MatrixXd>& qr) const;

  int row_size_ = 3;
  std::vector<int> pose_;
  Eigen::MatrixXd jacobian_;
  Eigen::MatrixXd basis_;
  Eigen::MatrixXd fitted_;     // the fitted columns in coordinates of the basis, of unit length
  Eigen::VectorXd explained_;  // the readings in coordinates of the basis, but for the constants
  std::vector<int> first_effect_column_;       // per effect, and one past the last
  std::vector<Eigen::VectorXd> contribution_;  // of each effect, in coordinates of the basis
  Eigen::VectorXd residual_;
  double residual_norm_ = 0, design_effect_ = 1, mean_psi_derivative_ = 1;
};

}  // namespace armtrue
