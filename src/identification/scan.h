#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "armtrue/effects/robot_model.h"
#include "armtrue/identification/calibration.h"

namespace armtrue {

/// One effect that may be missing, with the price of having looked at it among others.
struct Candidate {
  Effect effect;           ///< without coefficients
  double log_choices = 0;  ///< ln of how many candidates were tried up to and including its kind
  bool only_positive = false;
  bool from_catalogue = false;
};

/// What a candidate would explain.
struct CandidateScore {
  int degrees_of_freedom = 0;  ///< independent columns left after projection; 0: not separable
  double left = 0;             ///< share of its largest column that no known parameter can imitate
  double gain = 0;             ///< fall of the sum of squares of the whitened residuals
  double score = 0;            ///< fall of EBIC; positive is better than not having it
  Eigen::VectorXd coefficients;
};

/// A fit seen from close by: the derivatives of every row with respect to every parameter, whitened
/// and weighted, what they span, and the residual that is left. Scanning candidates costs, for each
/// row, only products of small vectors that are computed once, here.
class Linearization {
 public:
  Linearization(const CalibrationResult& fit, const Campaign& campaign);

  int rows() const { return static_cast<int>(pose_.size()); }
  double residual_norm() const { return residual_norm_; }  ///< sum of squares
  double equations() const { return equations_; }
  /// Variance inflation by readings that repeat a pose: 1 if replicates are independent.
  double design_effect() const { return design_effect_; }

  /// The residual replaced by another vector of the same rows (whitened), projected.
  void set_residual(const Eigen::VectorXd& residual);
  /// Takes a whitened contribution out of the residual.
  void explain(const Eigen::VectorXd& contribution) { set_residual(residual_ - contribution); }
  /// The same fit without the columns of one effect: what that effect explains becomes residual.
  Linearization without_effect(int effect) const;
  /// Whitened contribution of one effect to the readings.
  Eigen::VectorXd contribution(int effect) const;

 private:
  friend class CandidateScan;
  friend struct CrossValidation;
  void project();

  int row_size_ = 3;
  std::vector<int> pose_;
  Eigen::MatrixXd jacobian_;              // all parameters: (rows * row_size) x parameters
  Eigen::MatrixXd model_;                 // the columns of the fit
  std::vector<int> first_effect_column_;  // per effect, and one past the last
  Eigen::VectorXd effect_coefficients_;
  Eigen::VectorXd residual_, full_residual_;
  Eigen::MatrixXd basis_;  // orthonormal, of model_
  double residual_norm_ = 0, equations_ = 0, design_effect_ = 1;
  std::vector<Eigen::MatrixXd> basis_products_;  // per parameter: rows x rank
  Eigen::MatrixXd residual_products_;            // rows x parameters
};

/// Scores candidates against a linearization.
class CandidateScan {
 public:
  CandidateScan(const std::vector<Candidate>& candidates, const Robot& robot,
                const Campaign& campaign);

  const std::vector<Candidate>& candidates() const { return candidates_; }
  std::vector<CandidateScore> score(const Linearization& fit) const;

  /// Family-wise p-value of the best score: how often the best of all candidates scores as high on
  /// residuals whose signs are flipped pose by pose. `flips` draws, by `seed`.
  double family_wise_p(const Linearization& fit, double best_score, int flips,
                       std::uint64_t seed) const;

  /// Largest standard deviation over the rows of what the candidate adds to a parameter [m, rad].
  double variation(const Linearization& fit, int candidate,
                   const Eigen::VectorXd& coefficients) const;

  /// Whitened columns of one candidate, before projection.
  Eigen::MatrixXd columns(const Linearization& fit, int candidate) const;

 private:
  struct Projection;
  Projection project(const Linearization& fit, int candidate, const Eigen::MatrixXd& values) const;
  double ebic_fall(const Linearization& fit, int candidate, int degrees_of_freedom, double gain,
                   double residual_norm) const;
  Eigen::MatrixXd values_of(int candidate) const;  // rows x values

  std::vector<Candidate> candidates_;
  std::vector<BoundEffect> bound_;
  std::vector<std::vector<int>> groups_;  // candidates whose values are the same
  Robot robot_;
  std::vector<Context> contexts_;
  std::vector<ArmFrames> frames_;
  std::vector<PoseJacobian> jacobians_;  // only if a driver needs them
};

}  // namespace armtrue
