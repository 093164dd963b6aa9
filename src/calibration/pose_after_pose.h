#pragma once

#include <Eigen/Core>
#include <vector>

namespace armtrue {

/// Sums over the readings of a pose: derivatives by the unknowns, axes x unknowns, and residuals.
struct PoseError {
  Eigen::MatrixXd moved;
  Eigen::VectorXd residual;
  int readings = 0;
};

/// Judges the errors of poses, each given the poses before it: a Kalman filter with constant
/// unknowns (Kalman 1960). A pose with a gross error does not update the unknowns.
class PoseAfterPose {
 public:
  /// The unknowns have the covariance I, an axis of a pose the standard deviation `noise`.
  PoseAfterPose(Eigen::Index unknowns, double noise)
      : noise_(noise),
        mean_(Eigen::VectorXd::Zero(unknowns)),
        covariance_(Eigen::MatrixXd::Identity(unknowns, unknowns)) {}

  /// |e|^2 of each of the next poses, e whitened by the covariance that is expected of it; gross
  /// beyond `gross`. Some tens of poses at once are fastest.
  std::vector<double> squares_of(const std::vector<PoseError>& poses, double gross);

 private:
  double noise_;
  Eigen::VectorXd mean_;
  Eigen::MatrixXd covariance_;  // its lower triangle
};

}  // namespace armtrue
