#include "armtrue/kinematics/evaluator.h"

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>
#include <string>

#include "kinematics/chain_recursion.h"

namespace armtrue {
namespace {

using Eigen::Vector3d;

MovingFrame<double> moving(const Pose& pose) {
  return {pose.rotation.col(0), pose.rotation.col(1), pose.rotation.col(2), pose.translation};
}

Pose pose_of(const MovingFrame<double>& frame) {
  Pose pose;
  pose.rotation << frame.x, frame.y, frame.z;
  pose.translation = frame.origin;
  return pose;
}

// A loop instead of comma initialisers, which the compiler optimises badly: these columns take half
// the time of a pose.
inline void set_column(PoseJacobian& jacobian, int column, const Vector3d& moved,
                       const Vector3d& turned) {
  double* const out = jacobian.data() + PoseJacobian::RowsAtCompileTime * column;
  for (int i = 0; i < 3; ++i) {
    out[i] = moved[i];
    out[3 + i] = turned[i];
  }
}

struct JacobianColumn {
  double* entries;

  double get(int row) const { return entries[row]; }
  void set(int row, double value) { entries[row] = value; }
};

}  // namespace

ChainEvaluator::ChainEvaluator(const KinematicChain& chain)
    : base_(chain.base),
      tool_(chain.tool),
      count_(link_count(chain)),
      is_six_axis_arm_(armtrue::is_six_axis_arm(chain)) {
  if (count_ > kMaxLinks || joint_count(chain) > kMaxJoints)
    throw std::invalid_argument("the chain has " + std::to_string(count_) + " links and " +
                                std::to_string(joint_count(chain)) + " joints; at most " +
                                std::to_string(kMaxLinks) + " and " + std::to_string(kMaxJoints) +
                                " are possible");
  for (int j = 0; j < count_; ++j) {
    const Link& link = chain.links[j];
    links_[j] = {std::cos(link.alpha),
                 std::sin(link.alpha),
                 std::cos(link.beta),
                 std::sin(link.beta),
                 link.alpha,
                 link.d,
                 link.theta,
                 link.r,
                 link.beta,
                 link.sign,
                 joint_of_link(chain, j),
                 is_prismatic(link),
                 is_driven(link),
                 zero_of_link(chain, j)};
  }
  if (chain.couplings.size() > kMaxCouplings)
    throw std::invalid_argument("the joints of the chain follow others " +
                                std::to_string(chain.couplings.size()) + " times; at most " +
                                std::to_string(kMaxCouplings) + " are possible");
  for (const int k : coupling_order(chain)) {
    const Coupling& coupling = chain.couplings[k];
    links_[coupling.follower].moves = true;
    couplings_.push_back({coupling, layout_of(chain).couplings + k});
  }
}

ColumnSet ChainEvaluator::with_followers(ColumnSet columns) const {
  // A follower's own followers stand behind it in this order.
  for (const BoundCoupling& coupling : couplings_) {
    const auto zero = [&](int link) { return links_[link].zero; };
    if (columns[zero(coupling.followed)] || columns[coupling.parameter])
      columns.set(zero(coupling.follower));
  }
  return columns;
}

template <bool kWithOffsets, bool kWithJacobian, int kFixedCount>
Pose ChainEvaluator::evaluate(const JointVector& q, const ParameterOffsets* offsets,
                              PoseJacobian* jacobian) const {
  const int count = kFixedCount > 0 ? kFixedCount : count_;
  const ParameterLayout layout(count, static_cast<int>(couplings_.size()));
  Pose base = base_, tool = tool_;
  if constexpr (kWithOffsets) {
    base = moved_by(base_, offsets->segment<6>(kFirstBaseParameter));
    tool = moved_by(tool_, offsets->segment<6>(layout.tool));
  }
  MovingFrame<double> frame = moving(base);
  std::array<LinkAxes<double>, (kFixedCount > 0 ? kFixedCount : kMaxLinks)> axes;
  const auto encoder = [&](int joint) { return q[joint]; };
  const auto offset = [&](int parameter) { return (*offsets)[parameter]; };
  Motions<double> motions;
  move_along<kWithOffsets, kWithJacobian, kFixedCount>(encoder, offset, motions, frame, axes);
  const Pose a_from_measured = pose_of(frame) * tool;
  if constexpr (kWithJacobian) {
    jacobian->resize(Eigen::NoChange, layout.geometric);
    for_each_column(count, base.translation, frame, a_from_measured.translation, axes,
                    [&](int column, const Vector3d& moved, const Vector3d& turned) {
                      set_column(*jacobian, column, moved, turned);
                    });
    if constexpr (kFixedCount == 0)
      follow(motions,
             [&](int parameter) { return JacobianColumn{jacobian->col(parameter).data()}; });
  }
  return a_from_measured;
}

template <bool kWithOffsets, bool kWithJacobian>
Pose ChainEvaluator::dispatch(const JointVector& q, const ParameterOffsets* offsets,
                              PoseJacobian* jacobian) const {
  return count_ == kUsualLinks && couplings_.empty()
             ? evaluate<kWithOffsets, kWithJacobian, kUsualLinks>(q, offsets, jacobian)
             : evaluate<kWithOffsets, kWithJacobian, 0>(q, offsets, jacobian);
}

Pose ChainEvaluator::pose(const JointVector& q) const {
  return dispatch<false, false>(q, nullptr, nullptr);
}

Pose ChainEvaluator::pose(const JointVector& q, const ParameterOffsets& offsets) const {
  return dispatch<true, false>(q, &offsets, nullptr);
}

Pose ChainEvaluator::pose(const JointVector& q, PoseJacobian& jacobian) const {
  return dispatch<false, true>(q, nullptr, &jacobian);
}

Pose ChainEvaluator::pose(const JointVector& q, const ParameterOffsets& offsets,
                          PoseJacobian& jacobian) const {
  return dispatch<true, true>(q, &offsets, &jacobian);
}

LinkFrames ChainEvaluator::link_frames(const JointVector& q) const {
  LinkFrames frames(count_);
  MovingFrame<double> frame = moving(Pose{});
  Motions<double> motions;
  find_motions<false>([&](int joint) { return q[joint]; }, [](int) { return 0.0; }, motions);
  for (int j = 0; j < count_; ++j) {
    const Trigonometry& link = links_[j];
    double theta = link.theta, r = link.r;
    if (link.moves) (link.slides ? r : theta) += motions.of_link[j];
    frame.rotate_y({link.cos_beta, link.sin_beta});
    frame.rotate_x({link.cos_alpha, link.sin_alpha});
    frame.origin += link.d * frame.x + r * frame.z;
    frame.rotate_z(turn_by(theta));
    frames[j] = pose_of(frame);
  }
  return frames;
}

Eigen::Matrix<double, 6, 1> joint_column(const KinematicChain& chain, const PoseJacobian& jacobian,
                                         int joint) {
  return joint_link(chain, joint).sign * jacobian.col(zero_offset(chain, joint));
}

void move_to_point(PoseJacobian& jacobian, const Vector3d& lever) {
  const auto move = [&](auto&& columns) {
    columns.template topRows<3>() -= cross_matrix(lever) * columns.template bottomRows<3>();
  };
  constexpr int kUsual = ParameterLayout(kUsualLinks).geometric;
  if (jacobian.cols() == kUsual)
    move(Eigen::Map<Eigen::Matrix<double, 6, kUsual>>(jacobian.data()));
  else
    move(jacobian);
}

}  // namespace armtrue
