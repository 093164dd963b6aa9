#include <gtest/gtest.h>

#include "armtrue/compensation/error_map.h"

namespace armtrue::map_summary_test {
namespace {

// A line of points along x from LOW to HIGH, with errors of these sizes along -x.
ErrorMap line(double low, double high, const std::vector<double>& errors) {
  ErrorMap map;
  map.grid = Grid{{low, 0, 0}, {high, 0, 0}, {static_cast<int>(errors.size()), 1, 1}};
  for (const double error : errors) {
    MapPoint& point = map.points.emplace_back();
    point.is_predicted = true;
    point.error = {-error, 0.1 * error, 0};
  }
  return map;
}

// Of the two directions of the axis that in which its largest component is positive.
TEST(MapSummary, TheAxisOfTheErrorPointsForward) {
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(1, -0.1, 0), Eigen::Vector3d(0.1, 1, 0.3), Eigen::Vector3d(-0.5, 0.8, 0.2),
        Eigen::Vector3d(0.3, -0.4, 0.9), Eigen::Vector3d(0.9, 0.3, 0.2),
        Eigen::Vector3d(-0.1, -0.2, 1)}) {
    ErrorMap map = line(0, 1, {1e-3, 2e-3, 1e-3});
    for (MapPoint& point : map.points) point.error = point.error.norm() * axis;
    const ErrorMapSummary summary = summarize(map);
    EXPECT_LT((summary.axis - axis.normalized()).norm(), 1e-9);
    EXPECT_NEAR(summary.axis_share, 1, 1e-12);
  }
}

// Points at 0.3, 0.4 .. 0.9 m: a part of 0.2 m reaches from one to the second next, though
// 0.2 / 0.1 is less than 2 by rounding.
TEST(MapSummary, APartThatEndsOnAPointCoversIt) {
  const ErrorMapSummary summary = summarize(
      line(0.3, 0.9, {5e-3, 1e-3, 1e-3, 4e-3, 1e-3, 1e-3, 1e-3}), Eigen::Vector3d(0.2, 0, 0));
  ASSERT_TRUE(summary.best_before);
  EXPECT_NEAR(summary.best_before->low.x(), 0.7, 1e-12);
  EXPECT_NEAR(summary.best_before->high.x(), 0.9, 1e-12);
  EXPECT_NEAR(summary.worst_before->low.x(), 0.3, 1e-12);
}

}  // namespace
}  // namespace armtrue::map_summary_test
