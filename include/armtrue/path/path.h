#pragma once

#include <Eigen/Core>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// Neighbouring samples nearer than this do not move: it is rounding [m].
inline constexpr double kStandstill = 1e-9;

/// A tool path sampled in time, as programmed or as an instrument recorded it. One column per
/// sample; what was not recorded has no columns.
struct Path {
  Eigen::VectorXd time;                              ///< [s], strictly increasing
  Eigen::Matrix3Xd position;                         ///< of the tool tip [m]
  Eigen::Matrix3Xd orientation;                      ///< KUKA angles a, b, c [rad]
  Eigen::Matrix<double, kJoints, Eigen::Dynamic> q;  ///< encoder angles [rad]
  Eigen::Matrix3Xd force;                            ///< on the tool [N], axes of the positions

  Eigen::Index samples() const { return time.size(); }
  bool has_orientation() const { return orientation.cols() > 0; }
  bool has_joints() const { return q.cols() > 0; }
  bool has_force() const { return force.cols() > 0; }
};

/// Median of the time between samples [s]: the sample period, whatever is lost.
double median_period(const Path& path);

/// Values (a column per `time`, increasing) at the times `at`, increasing too: linear between
/// samples, those of the ends before and after them.
Eigen::MatrixXd interpolate(const Eigen::VectorXd& time,
                            const Eigen::Ref<const Eigen::MatrixXd>& values,
                            const Eigen::VectorXd& at);

/// Positions of the tool at other times; before and after the path it stands [m].
inline Eigen::Matrix3Xd position_at(const Path& path, const Eigen::VectorXd& times) {
  return interpolate(path.time, path.position, times);
}

/// The furthest that the tool gets from where it was so long before [m].
double longest_move(const Path& path, double duration);

/// Length of the polygon up to each sample [m]; starts at 0.
Eigen::VectorXd arc_length(const Path& path);

/// Unit tangent at each sample, by central differences; where the tool stands still, that of the
/// nearest sample that moves. All zero if nothing moves.
Eigen::Matrix3Xd tangents(const Path& path);

}  // namespace armtrue
