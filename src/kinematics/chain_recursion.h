#pragma once

#include <array>
#include <cmath>
#include <type_traits>

#include "armtrue/kinematics/evaluator.h"
#include "kinematics/lanes.h"

namespace armtrue {

// The pass along a chain and the columns of its Jacobian, written once for every kind of number:
// double of one pose (evaluator.cc), Lanes of several poses at once (pose_batch.cc). Where encoder
// values and offsets come from and where columns go is the caller's.

// Six joints and a spindle are the usual arm: its loops are unrolled.
inline constexpr int kUsualLinks = 7;

/// A vector of each of several poses.
struct LaneVector {
  Lanes x, y, z;

  friend LaneVector operator+(const LaneVector& a, const LaneVector& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend LaneVector operator-(const LaneVector& a, const LaneVector& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend LaneVector operator*(const Lanes& factor, const LaneVector& a) {
    return {factor * a.x, factor * a.y, factor * a.z};
  }
  LaneVector& operator+=(const LaneVector& other) { return *this = *this + other; }
  LaneVector cross(const LaneVector& b) const {
    return {y * b.z - z * b.y, z * b.x - x * b.z, x * b.y - y * b.x};
  }
};

template <typename Number>
using VectorOf = std::conditional_t<std::is_same_v<Number, Lanes>, LaneVector, Eigen::Vector3d>;

/// Frame that is propagated along the chain. The axes are three vectors because each elementary
/// rotation changes only two of them.
template <typename Number>
struct MovingFrame {
  VectorOf<Number> x, y, z, origin;

  void rotate_y(const Turn<Number>& turn) {
    const VectorOf<Number> old_x = x;
    x = turn.cosine * old_x - turn.sine * z;
    z = turn.sine * old_x + turn.cosine * z;
  }
  void rotate_x(const Turn<Number>& turn) {
    const VectorOf<Number> old_y = y;
    y = turn.cosine * old_y + turn.sine * z;
    z = turn.cosine * z - turn.sine * old_y;
  }
  void rotate_z(const Turn<Number>& turn) {
    const VectorOf<Number> old_x = x;
    x = turn.cosine * old_x + turn.sine * y;
    y = turn.cosine * y - turn.sine * old_x;
  }
};

/// Rotation axes of one link and a point on each, for the derivatives of its parameters.
template <typename Number>
struct LinkAxes {
  VectorOf<Number> y, x, x_origin, z, z_origin;
};

/// The pose with offsets of its six parameters, see parameters.h.
inline Pose moved_by(const Pose& pose, const Eigen::Matrix<double, 6, 1>& twist) {
  if (twist.isZero(0.0)) return pose;
  return {rotation_exp(twist.tail<3>()) * pose.rotation, pose.translation + twist.head<3>()};
}

/// The turn by angle + offset, where `turn` is that by the angle.
inline Turn<double> turn_moved(const Turn<double>& turn, double angle, double offset) {
  return offset != 0 ? turn_by(angle + offset) : turn;
}
inline Turn<Lanes> turn_moved(const Turn<Lanes>& turn, double angle, const Lanes& offset) {
  const auto moves = offset.values() != Lanes(0.0).values();
  if ((moves[0] | moves[1] | moves[2] | moves[3]) == 0) return turn;
  // A pose must not depend on those beside it: where nothing moves the constant stays.
  const Turn<Lanes> moved = turn_by(angle + offset);
  return {Lanes(moves ? moved.cosine.values() : turn.cosine.values()),
          Lanes(moves ? moved.sine.values() : turn.sine.values())};
}

/// Moves `frame` from R_0 to the frame of the last of `count` links. `motion(link)`, what the joint
/// of a link that moves adds to its constant, and `offset(parameter)` give Numbers. Writes the axes
/// of the links if kWithJacobian.
template <bool kWithOffsets, bool kWithJacobian, typename Number, typename Links, typename Motion,
          typename Offset, typename Axes>
inline void pass_along(const Links& links, int count, const Motion& motion, const Offset& offset,
                       MovingFrame<Number>& frame, Axes& axes) {
  for (int j = 0; j < count; ++j) {
    const auto& link = links[j];
    Turn<Number> about_x{link.cos_alpha, link.sin_alpha}, about_y{link.cos_beta, link.sin_beta};
    Number d = link.d, theta = link.theta, r = link.r;
    if (link.moves) (link.slides ? r : theta) += motion(j);
    if constexpr (kWithOffsets) {
      const int first = link_parameter(j, LinkParameter::alpha);
      about_x = turn_moved(about_x, link.alpha, offset(first));
      d += offset(first + 1);
      theta += offset(first + 2);
      r += offset(first + 3);
      about_y = turn_moved(about_y, link.beta, offset(first + 4));
    }
    if constexpr (kWithJacobian) axes[j].y = frame.y;
    frame.rotate_y(about_y);
    if constexpr (kWithJacobian) {
      axes[j].x = frame.x;
      axes[j].x_origin = frame.origin;
    }
    frame.rotate_x(about_x);
    frame.origin += d * frame.x + r * frame.z;
    if constexpr (kWithJacobian) {
      axes[j].z = frame.z;
      axes[j].z_origin = frame.origin;
    }
    frame.rotate_z(turn_by(theta));
  }
}

/// Hands the columns of the Jacobian to `set(column, moved, turned)`: the derivatives of the
/// translation and of the rotation vector. `last`: the frame of the last link; `end`: the origin of
/// the measured frame.
template <typename Number, typename Axes, typename Set>
inline void for_each_column(int count, const VectorOf<Number>& base_origin,
                            const MovingFrame<Number>& last, const VectorOf<Number>& end,
                            const Axes& axes, const Set& set) {
  const ParameterLayout layout(count);
  const VectorOf<Number> zero{0.0, 0.0, 0.0};
  const auto translation = [&](int column, const VectorOf<Number>& axis) {
    set(column, axis, zero);
  };
  const auto rotation = [&](int column, const VectorOf<Number>& axis,
                            const VectorOf<Number>& lever) {
    set(column, axis.cross(lever), axis);
  };
  const VectorOf<Number> unit[] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  const VectorOf<Number>* const of_tool[] = {&last.x, &last.y, &last.z};
  const VectorOf<Number> from_base = end - base_origin;
  for (int i = 0; i < 3; ++i) {
    translation(kFirstBaseParameter + i, unit[i]);
    rotation(kFirstBaseParameter + 3 + i, unit[i], from_base);
    translation(layout.tool + i, *of_tool[i]);
    rotation(layout.tool + 3 + i, *of_tool[i], zero);
  }
  for (int j = 0; j < count; ++j) {
    const auto& link = axes[j];
    const int first = link_parameter(j, LinkParameter::alpha);
    const VectorOf<Number> from_x = end - link.x_origin;
    rotation(first + 0, link.x, from_x);
    translation(first + 1, link.x);
    rotation(first + 2, link.z, end - link.z_origin);
    translation(first + 3, link.z);
    rotation(first + 4, link.y, from_x);
  }
}

template <bool kWithOffsets, typename Number, typename Encoder, typename Offset>
void ChainEvaluator::find_motions(const Encoder& encoder, const Offset& offset,
                                  Motions<Number>& motions) const {
  for (int j = 0; j < count_; ++j) {
    const Trigonometry& link = links_[j];
    motions.of_link[j] = link.joint >= 0 ? link.sign * encoder(link.joint) : Number(0.0);
  }
  for (size_t k = 0; k < couplings_.size(); ++k) {
    const BoundCoupling& coupling = couplings_[k];
    const Trigonometry& followed = links_[coupling.followed];
    Number value = motions.of_link[coupling.followed] +
                   Number((followed.slides ? followed.r : followed.theta) - coupling.from);
    Number coefficient = coupling.coefficient;
    if constexpr (kWithOffsets) {
      value += offset(followed.zero);
      coefficient += offset(coupling.parameter);
    }
    const double sign = links_[coupling.follower].sign;
    motions.of_followed[k] = sign * followed.sign * value;
    motions.factor[k] = sign * followed.sign * coefficient;
    motions.of_link[coupling.follower] += motions.factor[k] * value;
  }
}

template <bool kWithOffsets, bool kWithJacobian, int kFixedCount, typename Number, typename Encoder,
          typename Offset, typename Frame, typename Axes>
inline void ChainEvaluator::move_along(const Encoder& encoder, const Offset& offset,
                                       Motions<Number>& motions, Frame& frame, Axes& axes) const {
  const int count = kFixedCount > 0 ? kFixedCount : count_;
  if constexpr (kFixedCount > 0) {
    const auto motion = [&](int j) { return links_[j].sign * encoder(links_[j].joint); };
    pass_along<kWithOffsets, kWithJacobian>(links_, count, motion, offset, frame, axes);
  } else {
    find_motions<kWithOffsets>(encoder, offset, motions);
    const auto motion = [&](int j) { return motions.of_link[j]; };
    pass_along<kWithOffsets, kWithJacobian>(links_, count, motion, offset, frame, axes);
  }
}

template <typename Number, typename Column>
void ChainEvaluator::follow(const Motions<Number>& motions, const Column& column) const {
  for (size_t k = couplings_.size(); k-- > 0;) {
    const BoundCoupling& coupling = couplings_[k];
    const auto of_follower = column(links_[coupling.follower].zero);
    auto of_followed = column(links_[coupling.followed].zero);
    auto of_coefficient = column(coupling.parameter);
    for (int row = 0; row < 6; ++row) {
      const Number moved = of_follower.get(row);
      of_followed.set(row, of_followed.get(row) + motions.factor[k] * moved);
      of_coefficient.set(row, motions.of_followed[k] * moved);
    }
  }
}

}  // namespace armtrue
