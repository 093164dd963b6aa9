#include "armtrue/kinematics/evaluator.h"

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>
#include <string>

namespace armtrue {
namespace {

using Eigen::Vector3d;

// Six joints and a spindle are the usual arm: its loops are unrolled.
constexpr int kUsualLinks = 7;

// Frame that is propagated along the chain. The axes are three vectors because each elementary
// rotation changes only two of them.
struct MovingFrame {
  Vector3d x, y, z, origin;

  explicit MovingFrame(const Pose& pose)
      : x(pose.rotation.col(0)),
        y(pose.rotation.col(1)),
        z(pose.rotation.col(2)),
        origin(pose.translation) {}

  Pose pose() const {
    Pose result;
    result.rotation << x, y, z;
    result.translation = origin;
    return result;
  }
  void rotate_y(double cosine, double sine) {
    const Vector3d old_x = x;
    x = cosine * old_x - sine * z;
    z = sine * old_x + cosine * z;
  }
  void rotate_x(double cosine, double sine) {
    const Vector3d old_y = y;
    y = cosine * old_y + sine * z;
    z = cosine * z - sine * old_y;
  }
  void rotate_z(double cosine, double sine) {
    const Vector3d old_x = x;
    x = cosine * old_x + sine * y;
    y = cosine * y - sine * old_x;
  }
};

// Rotation axes of one link and a point on each, for the derivatives of its parameters.
struct LinkAxes {
  Vector3d y, x, x_origin, z, z_origin;
};

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

inline void set_rotation_column(PoseJacobian& jacobian, int column, const Vector3d& axis,
                                const Vector3d& lever) {
  set_column(jacobian, column, axis.cross(lever), axis);
}

inline void set_translation_column(PoseJacobian& jacobian, int column, const Vector3d& axis) {
  set_column(jacobian, column, axis, Vector3d::Zero());
}

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
                 is_prismatic(link)};
  }
}

template <bool kWithOffsets, bool kWithJacobian, int kFixedCount>
Pose ChainEvaluator::evaluate(const JointVector& q, const ParameterOffsets* offsets,
                              PoseJacobian* jacobian) const {
  const int count = kFixedCount > 0 ? kFixedCount : count_;
  const ParameterLayout layout(count);
  MovingFrame frame(base_);
  if constexpr (kWithOffsets) {
    const auto twist = offsets->segment<6>(kBaseParameters);
    if (!twist.isZero(0.0))
      frame = MovingFrame(
          {rotation_exp(twist.tail<3>()) * base_.rotation, base_.translation + twist.head<3>()});
  }
  const Vector3d base_origin = frame.origin;

  std::array<LinkAxes, (kFixedCount > 0 ? kFixedCount : kMaxLinks)> axes;
  for (int j = 0; j < count; ++j) {
    const Trigonometry& link = links_[j];
    double cos_alpha = link.cos_alpha, sin_alpha = link.sin_alpha;
    double cos_beta = link.cos_beta, sin_beta = link.sin_beta;
    double d = link.d, theta = link.theta, r = link.r;
    if (link.joint >= 0) (link.slides ? r : theta) += link.sign * q[link.joint];
    if constexpr (kWithOffsets) {
      const double* offset = offsets->data() + link_parameter(j, LinkParameter::alpha);
      if (offset[0] != 0) {
        cos_alpha = std::cos(link.alpha + offset[0]);
        sin_alpha = std::sin(link.alpha + offset[0]);
      }
      d += offset[1];
      theta += offset[2];
      r += offset[3];
      if (offset[4] != 0) {
        cos_beta = std::cos(link.beta + offset[4]);
        sin_beta = std::sin(link.beta + offset[4]);
      }
    }
    if constexpr (kWithJacobian) axes[j].y = frame.y;
    frame.rotate_y(cos_beta, sin_beta);
    if constexpr (kWithJacobian) {
      axes[j].x = frame.x;
      axes[j].x_origin = frame.origin;
    }
    frame.rotate_x(cos_alpha, sin_alpha);
    frame.origin += d * frame.x + r * frame.z;
    if constexpr (kWithJacobian) {
      axes[j].z = frame.z;
      axes[j].z_origin = frame.origin;
    }
    frame.rotate_z(std::cos(theta), std::sin(theta));
  }

  const Pose a_from_last = frame.pose();
  Pose tool = tool_;
  if constexpr (kWithOffsets) {
    const auto twist = offsets->segment<6>(layout.tool);
    if (!twist.isZero(0.0))
      tool = {rotation_exp(twist.tail<3>()) * tool_.rotation, tool_.translation + twist.head<3>()};
  }
  const Pose a_from_measured = a_from_last * tool;

  if constexpr (kWithJacobian) {
    PoseJacobian& columns = *jacobian;
    columns.resize(Eigen::NoChange, layout.geometric);
    const Vector3d& end = a_from_measured.translation;
    for (int i = 0; i < 3; ++i) {
      set_translation_column(columns, kBaseParameters + i, Vector3d::Unit(i));
      set_rotation_column(columns, kBaseParameters + 3 + i, Vector3d::Unit(i), end - base_origin);
      set_translation_column(columns, layout.tool + i, a_from_last.rotation.col(i));
      set_rotation_column(columns, layout.tool + 3 + i, a_from_last.rotation.col(i),
                          Vector3d::Zero());
    }
    for (int j = 0; j < count; ++j) {
      const LinkAxes& link = axes[j];
      const int first = link_parameter(j, LinkParameter::alpha);
      set_rotation_column(columns, first + 0, link.x, end - link.x_origin);
      set_translation_column(columns, first + 1, link.x);
      set_rotation_column(columns, first + 2, link.z, end - link.z_origin);
      set_translation_column(columns, first + 3, link.z);
      set_rotation_column(columns, first + 4, link.y, end - link.x_origin);
    }
  }
  return a_from_measured;
}

template <bool kWithOffsets, bool kWithJacobian>
Pose ChainEvaluator::dispatch(const JointVector& q, const ParameterOffsets* offsets,
                              PoseJacobian* jacobian) const {
  return count_ == kUsualLinks
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
  MovingFrame frame{Pose{}};
  for (int j = 0; j < count_; ++j) {
    const Trigonometry& link = links_[j];
    double theta = link.theta, r = link.r;
    if (link.joint >= 0) (link.slides ? r : theta) += link.sign * q[link.joint];
    frame.rotate_y(link.cos_beta, link.sin_beta);
    frame.rotate_x(link.cos_alpha, link.sin_alpha);
    frame.origin += link.d * frame.x + r * frame.z;
    frame.rotate_z(std::cos(theta), std::sin(theta));
    frames[j] = frame.pose();
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
