#include "calibration/pose_after_pose.h"

#include "linear_algebra/decompositions.h"

namespace armtrue {

// Poses come together, so that the unknowns follow them by products of matrices: with the rows M of
// all and their residuals r,
//     S = M P M^T + noise^2 I = L L^T,  W = L^-1 M P,  e = L^-1 (r - M m),
//     m += W^T e,  P -= W^T W.
std::vector<double> PoseAfterPose::squares_of(const std::vector<PoseError>& poses, double gross) {
  const Eigen::Index axes = poses.front().residual.size();
  const Eigen::Index rows = std::ssize(poses) * axes;
  Eigen::MatrixXd moved(rows, mean_.size());
  Eigen::VectorXd e(rows);
  for (int k = 0; k < std::ssize(poses); ++k) {
    const auto own = k * axes;
    moved.middleRows(own, axes) = poses[k].moved / poses[k].readings;
    e.segment(own, axes) = poses[k].residual / poses[k].readings;
  }
  e -= moved * mean_;
  Eigen::MatrixXd w = moved * covariance_.selfadjointView<Eigen::Lower>();
  Eigen::MatrixXd s = w * moved.transpose();
  s.diagonal().array() += noise_ * noise_;
  std::vector<double> squares;
  for (Eigen::Index own = 0; own < rows; own += axes) {
    const Eigen::Index after = rows - own - axes;
    const Eigen::LLT<Eigen::MatrixXd> l{Eigen::MatrixXd(s.block(own, own, axes, axes))};
    const Eigen::VectorXd own_e = l.matrixL().solve(e.segment(own, axes));
    squares.push_back(own_e.squaredNorm());
    if (!(squares.back() <= gross)) {  // no number is gross too
      e.segment(own, axes).setZero();
      w.middleRows(own, axes).setZero();
      continue;
    }
    const Eigen::MatrixXd own_w = l.matrixL().solve(w.middleRows(own, axes));
    const Eigen::MatrixXd below =
        l.matrixL().solve(s.block(own, own + axes, axes, after)).transpose();
    s.bottomRightCorner(after, after) -= below * below.transpose();
    e.tail(after) -= below * own_e;
    w.bottomRows(after) -= below * own_w;
    e.segment(own, axes) = own_e;
    w.middleRows(own, axes) = own_w;
  }
  mean_ += w.transpose() * e;
  covariance_.selfadjointView<Eigen::Lower>().rankUpdate(w.transpose(), -1.0);
  return squares;
}

}  // namespace armtrue
