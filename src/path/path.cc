#include "armtrue/path/path.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "armtrue/statistics/summary.h"

namespace armtrue {

double median_period(const Path& path) {
  std::vector<double> periods;
  for (Eigen::Index i = 1; i < path.samples(); ++i)
    periods.push_back(path.time[i] - path.time[i - 1]);
  return periods.empty() ? 0 : median(std::move(periods));
}

double longest_move(const Path& path, double duration) {
  double longest = 0;
  // The distance of two places on a polygon is greatest where one of them is a vertex.
  for (const double shift : {0.0, -duration}) {
    const Eigen::VectorXd begin = path.time.array() + shift;
    const Eigen::VectorXd end = begin.array() + duration;
    longest = std::max(
        longest, (position_at(path, end) - position_at(path, begin)).colwise().norm().maxCoeff());
  }
  return longest;
}

Eigen::MatrixXd interpolate(const Eigen::VectorXd& time,
                            const Eigen::Ref<const Eigen::MatrixXd>& values,
                            const Eigen::VectorXd& at) {
  Eigen::MatrixXd result(values.rows(), at.size());
  const Eigen::Index last = time.size() - 1;
  Eigen::Index k = 0;
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    // The next sample is near: double the step until it is past, then bisect.
    Eigen::Index step = 1;
    while (k + step < last && time[k + step] < at[i]) step *= 2;
    if (step > 1)
      k = std::lower_bound(time.begin() + k + step / 2, time.begin() + std::min(k + step, last),
                           at[i]) -
          time.begin() - 1;
    const double share = std::clamp((at[i] - time[k]) / (time[k + 1] - time[k]), 0.0, 1.0);
    result.col(i) = (1 - share) * values.col(k) + share * values.col(k + 1);
  }
  return result;
}

Eigen::Matrix3Xd velocity_at(const Path& path, const Eigen::VectorXd& times) {
  const Eigen::Index n = path.samples();
  Eigen::Matrix3Xd velocity = Eigen::Matrix3Xd::Zero(3, times.size());
  Eigen::Index k = 0;
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    if (times[i] < path.time[0] || times[i] > path.time[n - 1]) continue;
    while (k + 2 < n && path.time[k + 1] < times[i]) ++k;
    velocity.col(i) =
        (path.position.col(k + 1) - path.position.col(k)) / (path.time[k + 1] - path.time[k]);
  }
  return velocity;
}

double extent(const Path& path) {
  return (path.position.rowwise().maxCoeff() - path.position.rowwise().minCoeff()).norm();
}

Eigen::VectorXd arc_length(const Path& path) {
  Eigen::VectorXd length = Eigen::VectorXd::Zero(path.samples());
  for (Eigen::Index i = 1; i < path.samples(); ++i)
    length[i] = length[i - 1] + (path.position.col(i) - path.position.col(i - 1)).norm();
  return length;
}

Eigen::Matrix3Xd tangents(const Path& path) {
  const Eigen::Index n = path.samples();
  Eigen::Matrix3Xd tangent = Eigen::Matrix3Xd::Zero(3, n);
  Eigen::VectorXd from_last = Eigen::VectorXd::Constant(n, -1);  // samples since the last motion
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d chord = path.position.col(std::min(i + 1, n - 1)) -
                                  path.position.col(std::max<Eigen::Index>(i - 1, 0));
    if (chord.norm() > kStandstill) {
      tangent.col(i) = chord.normalized();
      from_last[i] = 0;
    } else if (i > 0 && from_last[i - 1] >= 0) {
      tangent.col(i) = tangent.col(i - 1);
      from_last[i] = from_last[i - 1] + 1;
    }
  }
  // Backwards: a sample at standstill takes the tangent of the next motion if that is nearer.
  double to_next = -1;
  for (Eigen::Index i = n - 1; i >= 0; --i) {
    if (from_last[i] == 0)
      to_next = 0;
    else if (to_next >= 0 && (++to_next < from_last[i] || from_last[i] < 0))
      tangent.col(i) = tangent.col(i + 1);
  }
  return tangent;
}

}  // namespace armtrue
