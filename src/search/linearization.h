#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "linear_algebra/decompositions.h"
#include "search/replicates.h"

namespace armtrue {

/// The part of the readings that some effects explain beside everything else in the model. Columns
/// and readings are projected off the rest of the model and stand in the coordinates of `span`.
struct BesideTheRest {
  std::vector<Eigen::MatrixXd> columns;  ///< one matrix for each effect
  Eigen::VectorXd readings;
  Eigen::MatrixXd span;      ///< equations x coordinates, orthonormal
  Eigen::VectorXd residual;  ///< equations; what no effect explains
  std::vector<int> pose;     ///< number of the pose, from 0, of each `row_size` equations
  int row_size = 1;

  int poses() const { return pose.empty() ? 0 : 1 + *std::max_element(pose.begin(), pose.end()); }
};

/// What an effect adds to its parameter, at most [m, rad]: more is a mistake, not an effect.
inline constexpr double kMaxVariation = 0.02;

/// A fit as a linear problem: readings = fitted * unknowns + residual, whitened and weighted.
struct LinearProblem {
  std::vector<int> pose;  ///< number of the pose, from 0, of each row
  int row_size = 3;       ///< equations of a row
  /// (rows * row_size) x parameters: derivatives with respect to every parameter.
  Eigen::MatrixXd jacobian;
  /// (rows * row_size) x unknowns: geometric parameters, coefficients of the effects, parameters of
  /// further sessions.
  Eigen::MatrixXd fitted;
  int geometric = 0;         ///< number of geometric columns of `fitted`
  Eigen::VectorXd readings;  ///< rows * row_size: readings minus the model
  std::vector<std::vector<double>> coefficients_of_effect;
  /// Largest amount of each coefficient that is possible; empty: not known.
  std::vector<double> most;
  double mean_psi_derivative = 1;  ///< see pose_influence.h
  Replicates replicates;           ///< of the rows; empty: each row is one reading
};

/// The linear problem at a fit, with the fitted columns as an orthonormal basis Q and the residual
/// r = (I - Q Q^T) readings.
class Linearization {
 public:
  Linearization(const CalibrationResult& fit, const Campaign& campaign);
  /// Counts all readings as independent (design effect 1).
  explicit Linearization(LinearProblem problem);

  /// Rows of the equations. A row stands for all replicates of one prediction.
  int rows() const { return static_cast<int>(pose_.size()); }
  const Replicates& replicates() const { return replicates_; }
  int row_size() const { return row_size_; }
  /// Number of the pose of each row, in the order of the ids. Rows of one pose may share an error.
  const std::vector<int>& pose() const { return pose_; }
  /// (rows * row_size) x parameters.
  const Eigen::MatrixXd& jacobian() const { return jacobian_; }
  /// Q: orthonormal basis of the fitted columns, (rows * row_size) x rank.
  const Eigen::MatrixXd& basis() const { return basis_; }
  /// r: orthogonal to the basis.
  const Eigen::VectorXd& residual() const { return residual_; }
  /// |r|^2, with the rests of the replicates.
  double residual_norm() const { return residual_norm_; }
  /// m = equations / design effect - rank(Q): the number of independent equations that the residual
  /// is worth. EBIC with all equations instead of m would count chance as evidence: in a campaign
  /// of few poses the geometry uses half of the equations or more.
  double residual_freedom() const {
    return std::max(1.0, static_cast<double>(replicates_.rest.size()) / design_effect_ -
                             static_cast<double>(basis_.cols()));
  }

  /// Standard deviation of the coefficient of one more column, fitted with all unknowns of the
  /// model; clustered by pose, as the covariance of the fit is.
  double standard_deviation(const Eigen::VectorXd& column) const;

  /// The part of the model that only some of its effects have, in coordinates of the basis.
  struct Loss {
    Eigen::MatrixXd span;      ///< rank x independent columns, orthonormal: directions that only
                               ///< they span
    Eigen::VectorXd residual;  ///< the part of the readings that they explain, in that span
  };
  Loss without(const std::vector<int>& effects) const;

  /// What the effects from `first` on explain.
  BesideTheRest effects_from(int first) const;

  /// The geometric parameters (indices into the set, from 0) that move most when an imitation (all
  /// rows, whitened) takes the place of an effect. Names at most `count`, and only those that move
  /// the readings by a tenth of the effect or more.
  std::vector<int> most_refitted(int effect, const Eigen::VectorXd& imitation, int count) const;

 private:
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> all_but(const std::vector<int>& effects) const;
  Eigen::MatrixXd only_by(const std::vector<int>& effects) const;
  void set_duals();
  Eigen::Index unseen_column(const LinearProblem& problem, const Eigen::VectorXd& length) const;

  int row_size_ = 3;
  std::vector<int> pose_;
  Replicates replicates_;
  Eigen::MatrixXd jacobian_;
  Eigen::MatrixXd basis_;
  // The fitted columns in coordinates of the basis, of unit length; zero of a column of an effect
  // that is not seen beside the others.
  Eigen::MatrixXd fitted_;
  // The pseudoinverse of their transpose. Of independent columns its column k is orthogonal to all
  // fitted columns but the k-th. Where they depend on each other, `turn_` has an orthonormal basis
  // of their rows as its own rows.
  Eigen::MatrixXd duals_, turn_;
  Eigen::VectorXd explained_;                  // Q^T readings
  std::vector<int> first_effect_column_;       // of each effect, and one past the last
  std::vector<Eigen::VectorXd> contribution_;  // of each effect, in coordinates of the basis
  Eigen::VectorXd residual_;
  double residual_norm_ = 0, design_effect_ = 1, mean_psi_derivative_ = 1;
};

}  // namespace armtrue
