#pragma once

#include <Eigen/Core>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// If neighbouring samples differ by no more than this [m], the tool stands still, and the rest is
/// rounding.
inline constexpr double kStandstill = 1e-9;

/// A tool path sampled in time, as programmed or as an instrument recorded it. One column for each
/// sample; a quantity that was not recorded has no columns.
struct Path {
  Eigen::VectorXd time;          ///< [s], strictly increasing
  Eigen::Matrix3Xd position;     ///< of the tool tip [m]
  Eigen::Matrix3Xd orientation;  ///< KUKA angles a, b, c [rad]
  JointMatrix q;                 ///< encoder values [rad or m]
  Eigen::Matrix3Xd force;        ///< on the tool [N], in the axes of `position`

  int samples() const { return static_cast<int>(time.size()); }
  bool has_position() const { return position.cols() > 0; }
  bool has_orientation() const { return orientation.cols() > 0; }
  bool has_joints() const { return q.cols() > 0; }
  bool has_force() const { return force.cols() > 0; }
  bool has_times_of(const Path& other) const {
    return samples() == other.samples() && time == other.time;
  }
};

/// Median of the time between samples [s]: the sample period, even if samples are lost.
double median_period(const Path& path);

/// Interpolates `values`, one column for each of the times `time`, at the times `at`; both
/// increase. Linear between samples, constant before the first and after the last.
Eigen::MatrixXd interpolate(const Eigen::VectorXd& time,
                            const Eigen::Ref<const Eigen::MatrixXd>& values,
                            const Eigen::VectorXd& at);

/// Positions of the tool at other, increasing times [m]; it stands still before and after the path.
inline Eigen::Matrix3Xd position_at(const Path& path, const Eigen::VectorXd& times) {
  return interpolate(path.time, path.position, times);
}

/// Velocities of the polygon at other, increasing times [m/s]; zero before and after the path.
Eigen::Matrix3Xd velocity_at(const Path& path, const Eigen::VectorXd& times);

/// max over t of |p(t + duration) - p(t)| [m].
double longest_move(const Path& path, double duration);

/// Diagonal of the box around the positions, along the axes [m].
double extent(const Path& path);

/// Length of the polygon from its first sample to each sample [m].
Eigen::VectorXd arc_length(const Path& path);

/// Unit tangent at each sample: the direction of p_(i+1) - p_(i-1). At standstill it is that of the
/// nearest sample in motion. All zero if the tool never moves.
Eigen::Matrix3Xd tangents(const Path& path);

}  // namespace armtrue
