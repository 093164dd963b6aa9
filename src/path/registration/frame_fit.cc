#include "path/registration/frame_fit.h"

#include <Eigen/Core>
#include <algorithm>

#include "linear_algebra/decompositions.h"

namespace armtrue {

// The deviation along the path counts by this: clock, lag and friction make it, too. It decides
// what the path across does not show, such as a turn about the axis of a circle.
constexpr double kAlong = 0.3;
constexpr double kSoft = 1e-6;  // m/N, of an arm

namespace {

// Takes off what a compliance C explains of deviation and frame, d = -C f: a steady force bends the
// arm as if the frame were displaced. C is 0 +- kSoft beside a deviation of the size of d.
void leave_out_compliance(const Eigen::Matrix3Xd& force, FrameEquations& equations) {
  Eigen::MatrixXd by_force(equations.deviation.size(), 9);
  for (Eigen::Index i = 0; i < force.cols(); ++i)
    for (int k = 0; k < 3; ++k)
      by_force.block<3, 3>(3 * i, 3 * k) = force(k, i) * equations.weight.middleRows<3>(3 * i);
  const double deviation = equations.deviation.squaredNorm() / static_cast<double>(force.cols());
  Eigen::MatrixXd gram = by_force.transpose() * by_force;
  gram.diagonal().array() += std::max(1e-12, deviation) / (kSoft * kSoft);
  const Eigen::LDLT<Eigen::MatrixXd> solver(gram);
  equations.deviation -=
      by_force * solver.solve(Eigen::VectorXd(by_force.transpose() * equations.deviation));
  equations.by_frame -=
      by_force * solver.solve(Eigen::MatrixXd(by_force.transpose() * equations.by_frame));
}

}  // namespace

FrameEquations frame_equations(const Path& programmed, const Path& measured, const ClockFit& fit) {
  const Path own = registered(measured, fit);
  const Eigen::Matrix3Xd wanted = position_at(programmed, own.time);
  const Eigen::Matrix3Xd velocity = velocity_at(programmed, own.time);
  FrameEquations equations{Eigen::VectorXd::Zero(3 * own.samples()),
                           Eigen::MatrixX3d::Zero(3 * own.samples(), 3),
                           Eigen::Matrix<double, Eigen::Dynamic, 6>::Zero(3 * own.samples(), 6)};
  for (Eigen::Index i = 0; i < own.samples(); ++i) {
    if (velocity.col(i).isZero(0)) continue;
    const Eigen::Vector3d along = velocity.col(i).normalized();
    const Eigen::Matrix3d weight =
        Eigen::Matrix3d::Identity() - (1 - kAlong) * along * along.transpose();
    equations.deviation.segment<3>(3 * i) = weight * (own.position.col(i) - wanted.col(i));
    equations.weight.middleRows<3>(3 * i) = weight;
    equations.by_frame.middleRows<3>(3 * i) = weight * fit.by_frame(wanted.col(i));
  }
  if (own.has_force()) leave_out_compliance(own.force, equations);
  return equations;
}

Eigen::Matrix<double, 6, 6> FrameEquations::information() const {
  constexpr double kUnseen = 1e-3;
  Eigen::Matrix<double, 6, 6> result = by_frame.transpose() * by_frame;
  for (const int first : {0, 3})  // displacements, turns
    result.diagonal().segment<3>(first).array() +=
        kUnseen * kUnseen * result.diagonal().segment<3>(first).mean();
  return result;
}

Pose fit_frame(const Path& programmed, const std::vector<Path>& passes,
               const std::vector<ClockFit>& clocks, const Pose& start) {
  constexpr int kRounds = 3;  // a turn is not quite linear
  Pose frame = start;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    const Eigen::Vector3d pivot = clocks.front().frame_pivot;
    for (size_t p = 0; p < passes.size(); ++p) {
      ClockFit fit = clocks[p];
      fit.program_from_instrument = frame;
      fit.frame_pivot = pivot;
      const FrameEquations equations = frame_equations(programmed, passes[p], fit);
      information += equations.information();
      right -= equations.by_frame.transpose() * equations.deviation;
    }
    const Eigen::Matrix<double, 6, 1> motion =
        Eigen::LDLT<Eigen::Matrix<double, 6, 6>>(information).solve(right);
    const Eigen::Matrix3d turn = rotation_exp(motion.tail<3>());
    frame = Pose{turn, pivot + motion.head<3>() - turn * pivot} * frame;
  }
  return frame;
}

}  // namespace armtrue
