#include "path/mirror/frame_error.h"

#include <Eigen/Core>
#include <algorithm>

#include "path/mirror/corners.h"
#include "path/mirror/mean_deviation.h"

namespace armtrue {

FrameError frame_error(const Path& programmed, const PathDeviation& deviation,
                       const ClockFit& clock) {
  using Matrix6d = Eigen::Matrix<double, 6, 6>;
  const Matrix6d& covariance = clock.frame_covariance;
  if (covariance.isZero(0)) return {};
  const Eigen::Matrix3Xd tangent = side_tangents(programmed, find_corners(programmed));
  const Eigen::Matrix3Xd place = position_at(programmed, deviation.time);
  const Eigen::Matrix3Xd velocity = velocity_at(programmed, deviation.time);
  Matrix6d squares = Matrix6d::Zero();
  Eigen::Matrix<double, 6, 1> crossed = Eigen::Matrix<double, 6, 1>::Zero();
  double count = 0;
  Eigen::Index nearest = 0;
  for (Eigen::Index i = 0; i < deviation.time.size(); ++i) {
    nearest = nearest_sample(programmed, deviation.time[i], nearest);
    if (velocity.col(i).isZero(0)) continue;
    const Eigen::Vector3d along = tangent.col(nearest);
    Eigen::Matrix<double, 3, 6> across = clock.by_frame(place.col(i));
    across -= along * (along.transpose() * across).eval();
    squares += across.transpose() * across;
    crossed += across.transpose() * deviation.normal.col(i);
    count += 1;
  }
  if (count == 0) return {};
  const Matrix6d product = covariance * squares / count;
  crossed /= count;
  const double variance = 4 * crossed.dot(covariance * crossed) + 2 * (product * product).trace();
  return {product.trace(), std::sqrt(std::max(0.0, variance))};
}

}  // namespace armtrue
