// The way of the TCP between two points: its orientation on lines and arcs.

#include "armtrue/programs/way.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace armtrue {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kAngle = 90 * kDegree;

// A quarter of a circle of 100 mm about z, on which the tool tilts about x.
Way quarter(ArcTurning turning) {
  Way way;
  way.start = {AngleAxisd(0.3, Vector3d::UnitY()).toRotationMatrix(), {0.1, 0, 0}};
  way.end = {AngleAxisd(0.8, Vector3d::UnitX()) * way.start.rotation, {0, 0.1, 0}};
  way.arc = Arc{Vector3d::Zero(), Vector3d::UnitX(), Vector3d::UnitY(), 0.1, kAngle};
  way.turning = turning;
  return way;
}

Eigen::Matrix3d between(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to, double t) {
  return Quaterniond(from).slerp(t, Quaterniond(to)).toRotationMatrix();
}

TEST(Way, OnAnArcTheToolTurnsInTheFrameOrWithThePath) {
  for (const double t : {0.0, 0.25, 0.7, 1.0}) {
    const Way in_frame = quarter(ArcTurning::in_frame), with_path = quarter(ArcTurning::with_path);
    const Eigen::Matrix3d& start = in_frame.start.rotation;
    const Eigen::Matrix3d& end = in_frame.end.rotation;
    const Vector3d place(0.1 * std::cos(t * kAngle), 0.1 * std::sin(t * kAngle), 0);
    EXPECT_LT((in_frame.at(t).translation - place).norm(), 1e-15);
    EXPECT_LT((with_path.at(t).translation - place).norm(), 1e-15);
    EXPECT_LT((in_frame.at(t).rotation - between(start, end, t)).norm(), 1e-12);
    const auto turned = [](double share) {
      return AngleAxisd(share * kAngle, Vector3d::UnitZ()).toRotationMatrix();
    };
    const Eigen::Matrix3d expected = turned(t) * between(start, turned(1).transpose() * end, t);
    EXPECT_LT((with_path.at(t).rotation - expected).norm(), 1e-12);
  }
}

TEST(Way, OnALineTheToolTurnsAboutOneAxis) {
  Way way = quarter(ArcTurning::with_path);
  way.arc.reset();
  EXPECT_LT((way.at(0.3).translation - Vector3d(0.07, 0.03, 0)).norm(), 1e-15);
  EXPECT_LT((way.at(0.3).rotation - between(way.start.rotation, way.end.rotation, 0.3)).norm(),
            1e-12);
  EXPECT_NEAR(way.length(), 0.1 * std::sqrt(2.0), 1e-15);
}

// 0.4 of the way to the nearer neighbour, at most 10 mm, and outside of the radii of both.
TEST(Way, APointIsPassedWithinTheWaysToItsNeighbours) {
  EXPECT_NEAR(passing_radius(0.02, 0.015, 0, 0), 0.4 * 0.015, 1e-15);
  EXPECT_NEAR(passing_radius(1, 1, 0, 0), 0.01, 1e-15);
  EXPECT_NEAR(passing_radius(0.02, 0.02, 0.017, 0), 0.003, 1e-15);
  EXPECT_NEAR(passing_radius(0.02, 0.02, 0, 0.018), 0.002, 1e-15);
}

}  // namespace
}  // namespace armtrue
