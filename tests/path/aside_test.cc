#include "armtrue/path/registration/aside.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace armtrue::aside_test {
namespace {

Path through(const std::vector<Eigen::Vector3d>& points) {
  Path path;
  path.time = Eigen::VectorXd::LinSpaced(std::ssize(points), 0, std::ssize(points) - 1.0);
  path.position.resize(3, std::ssize(points));
  for (size_t i = 0; i < points.size(); ++i)
    path.position.col(static_cast<Eigen::Index>(i)) = points[i];
  return path;
}

// Counter-clockwise from the lower left corner, open there, with places all along.
Path rectangle(double low, double right, double top) {
  std::vector<Eigen::Vector3d> points;
  const std::vector<Eigen::Vector3d> corners{
      {low, low, 0}, {right, low, 0}, {right, top, 0}, {low, top, 0}, {low, low, 0}};
  for (size_t k = 0; k + 1 < corners.size(); ++k)
    for (int i = 0; i < 50; ++i)
      points.push_back(corners[k] + i / 50.0 * (corners[k + 1] - corners[k]));
  return through(points);
}

TEST(Aside, IsTheDistanceToTheSideOfTravel) {
  const Path program = rectangle(0, 0.2, 0.12);
  const auto inside = find_aside(program, rectangle(3e-3, 0.197, 0.117));
  ASSERT_TRUE(inside);
  EXPECT_NEAR(inside->left, 3e-3, 1e-9);
  EXPECT_NEAR(inside->shorter, 3e-3 * 1.5 * std::numbers::pi, 1e-9);  // three corners
  EXPECT_NEAR(inside->from.z(), 1, 1e-9);
  const auto outside = find_aside(program, rectangle(-3e-3, 0.203, 0.123));
  ASSERT_TRUE(outside);
  EXPECT_NEAR(outside->left, -3e-3, 1e-4);  // farther off at corners
  EXPECT_TRUE(inside->explains(15e-3));
  EXPECT_FALSE(inside->explains(60e-3));
  EXPECT_FALSE(inside->explains(-15e-3));
}

TEST(Aside, IsNoShiftAndNoDeviationThatVaries) {
  const Path program = rectangle(0, 0.2, 0.12);
  Path moved = program;
  moved.position.row(0).array() += 2e-3;
  moved.position.row(1).array() += 2e-3;
  EXPECT_FALSE(find_aside(program, moved));
  Path wavy = rectangle(1e-3, 0.199, 0.119);
  for (Eigen::Index i = 0; i < wavy.samples(); ++i)
    wavy.position.col(i) += 1e-3 * Eigen::Vector3d(std::cos(0.2 * i), std::sin(0.3 * i), 0);
  EXPECT_FALSE(find_aside(program, wavy));
  const Path line = through({{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}});
  EXPECT_FALSE(find_aside(line, through({{0, 2e-3, 0}, {0.1, 2e-3, 0}, {0.2, 2e-3, 0}})));
}

}  // namespace
}  // namespace armtrue::aside_test
