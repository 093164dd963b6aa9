#include "path/mirror/straightening.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "path/mirror/trend.h"

namespace armtrue {
namespace {

// Where a sample lies between two others, from 0 to 1.
double share_between(Eigen::Index first, Eigen::Index i, Eigen::Index last) {
  return static_cast<double>(i - first) / static_cast<double>(last - first);
}

// The largest distance of the values from the straight line between two samples, and its sample.
std::pair<double, Eigen::Index> farthest(const Eigen::Matrix3Xd& values, Eigen::Index first,
                                         Eigen::Index last) {
  std::pair<double, Eigen::Index> most{0, first};
  for (Eigen::Index i = first + 1; i < last; ++i) {
    const double share = share_between(first, i, last);
    const double off =
        (values.col(i) - (1 - share) * values.col(first) - share * values.col(last)).norm();
    if (off > most.first) most = {off, i};
  }
  return most;
}

// Adds the samples through which a polygon must pass to stay within `tolerance` of the others
// (Ramer 1972, Douglas and Peucker 1973).
void add_corners(const Eigen::Matrix3Xd& values, Eigen::Index begin, Eigen::Index end,
                 double tolerance, std::vector<Eigen::Index>& corners) {
  std::vector<std::pair<Eigen::Index, Eigen::Index>> open{{begin, end}};
  corners.push_back(begin);
  corners.push_back(end);
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    const auto [off, at] = farthest(values, first, last);
    if (off <= tolerance) continue;
    corners.push_back(at);
    open.emplace_back(first, at);
    open.emplace_back(at, last);
  }
}

// The points without those within `tolerance` of the line between their neighbours: many turning
// points of the three components are one.
std::vector<Eigen::Index> needed(const Eigen::Matrix3Xd& values,
                                 const std::vector<Eigen::Index>& points, double tolerance) {
  std::vector<Eigen::Index> kept{points.front()};
  for (size_t k = 1; k + 1 < points.size(); ++k)
    if (farthest(values, kept.back(), points[k + 1]).first > tolerance) kept.push_back(points[k]);
  kept.push_back(points.back());
  return kept;
}

// Adds the turning points of one component with a prominence above `prominence`.
void add_turning_points(const Eigen::RowVectorXd& values, Eigen::Index begin, double prominence,
                        std::vector<Eigen::Index>& points) {
  Eigen::Index low = 0, high = 0;  // of the stretch since the last turning point
  int direction = 0;
  for (Eigen::Index i = 1; i < values.size(); ++i) {
    if (values[i] > values[high]) high = i;
    if (values[i] < values[low]) low = i;
    if (direction >= 0 && values[high] - values[i] > prominence) {
      if (direction > 0 || high > 0) points.push_back(begin + high);
      direction = -1;
      low = i;
    } else if (direction <= 0 && values[i] - values[low] > prominence) {
      if (direction < 0 || low > 0) points.push_back(begin + low);
      direction = 1;
      high = i;
    }
    if (direction > 0) low = i;
    if (direction < 0) high = i;
  }
}

// Replaces `polygon` from the first to the last point by the polygon with vertices at the points
// that is the least-squares fit to the samples. Hat functions make the normal equations
// tridiagonal.
void fit_polygon(const Eigen::Matrix3Xd& samples, const std::vector<Eigen::Index>& points,
                 Eigen::Matrix3Xd& polygon) {
  const Eigen::Index count = points.size();
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(count), beside = Eigen::VectorXd::Zero(count);
  Eigen::Matrix3Xd right = Eigen::Matrix3Xd::Zero(3, count);
  const auto share_of = [&](Eigen::Index k, Eigen::Index i) {  // of the next point
    return share_between(points[k], i, points[k + 1]);
  };
  const auto for_each = [&](const auto& visit) {
    Eigen::Index k = 0;
    for (Eigen::Index i = points.front(); i <= points.back(); ++i) {
      while (k + 2 < count && points[k + 1] < i) ++k;
      visit(k, i, share_of(k, i));
    }
  };
  for_each([&](Eigen::Index k, Eigen::Index i, double share) {
    diagonal[k] += (1 - share) * (1 - share);
    diagonal[k + 1] += share * share;
    beside[k] += share * (1 - share);
    right.col(k) += (1 - share) * samples.col(i);
    right.col(k + 1) += share * samples.col(i);
  });
  for (Eigen::Index k = 1; k < count; ++k) {  // Thomas algorithm
    const double factor = beside[k - 1] / diagonal[k - 1];
    diagonal[k] -= factor * beside[k - 1];
    right.col(k) -= factor * right.col(k - 1);
  }
  for (Eigen::Index k = count - 1; k >= 0; --k) {
    if (k + 1 < count) right.col(k) -= beside[k] * right.col(k + 1);
    right.col(k) /= diagonal[k];
  }
  for_each([&](Eigen::Index k, Eigen::Index i, double share) {
    polygon.col(i) = (1 - share) * right.col(k) + share * right.col(k + 1);
  });
}

}  // namespace

std::vector<Eigen::Index> straighten(PathDeviation& deviation, CorrectionPoints how,
                                     double uncertainty) {
  // 95 %: of the difference of two extremes, one component; of a sample minus the mean of two
  // others, two components, P(chi^2_2 > 5.99) = 0.05.
  const double prominence = 1.96 * std::sqrt(2.0) * uncertainty;
  const double tolerance = std::sqrt(5.99 * 1.5) * uncertainty;
  std::vector<Eigen::Index> points;
  for (const auto& [begin, end] : pieces(deviation.breaks, deviation.normal.cols())) {
    std::vector<Eigen::Index> turning{begin, end - 1}, own;
    if (how == CorrectionPoints::turning)
      for (int axis = 0; axis < 3; ++axis)
        add_turning_points(deviation.trend.row(axis).segment(begin, end - begin), begin, prominence,
                           turning);
    std::sort(turning.begin(), turning.end());
    for (size_t k = 1; k < turning.size(); ++k)
      add_corners(deviation.trend, turning[k - 1], turning[k], tolerance, own);
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end()), own.end());
    own = needed(deviation.trend, own, tolerance);
    points.insert(points.end(), own.begin(), own.end());
    if (how == CorrectionPoints::turning) fit_polygon(deviation.normal, own, deviation.trend);
  }
  return points;
}

}  // namespace armtrue
