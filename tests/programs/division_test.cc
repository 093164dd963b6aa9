#include "programs/division.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>

namespace armtrue::division_test {
namespace {

using Eigen::Vector3d;
using testing::ElementsAre;

std::vector<Knot> knots(int count, const std::function<Vector3d(double)>& displacement) {
  std::vector<Knot> result;
  for (int i = 0; i <= count; ++i) {
    const double t = static_cast<double>(i) / count;
    result.push_back({t, displacement(t)});
  }
  return result;
}

TEST(Division, AStraightMoveIsDividedWhereItsDisplacementBends) {
  const auto bent =
      knots(100, [](double t) { return Vector3d(0, std::min(t, 0.3), std::max(0.0, t - 0.8)); });
  EXPECT_THAT(divide_line(bent, 1e-6), ElementsAre(0, 30, 80, 100));
  EXPECT_THAT(divide_line(knots(100, [](double t) { return Vector3d(t, 1 - t, 2); }), 1e-12),
              ElementsAre(0, 100));
}

RC_GTEST_PROP(Division, NoKnotIsFartherOffThanTheTolerance, ()) {
  std::vector<Knot> noisy{{0, Vector3d::Zero()}};
  for (int count = *rc::gen::inRange(1, 300); count > 0; --count)
    noisy.push_back({noisy.back().t + *rc::gen::inRange(1, 9),
                     Vector3d(0, *rc::gen::inRange(-9, 9), *rc::gen::inRange(-9, 9))});
  for (Knot& knot : noisy) knot.t /= noisy.back().t;
  noisy.back().t = 1;
  const double tolerance = *rc::gen::inRange(0, 10);
  const std::vector<size_t> at = divide_line(noisy, tolerance);
  RC_ASSERT(at.front() == 0 && at.back() == noisy.size() - 1);
  std::vector<Knot> kept;
  for (const size_t k : at) kept.push_back(noisy[k]);
  for (const Knot& knot : noisy)
    RC_ASSERT((displacement_at(kept, knot.t) - knot.displacement).norm() <= tolerance + 1e-9);
}

TEST(Division, AnArcGoesThroughItsPoints) {
  const Vector3d a(1, 0, 3), m(std::sqrt(0.5), -std::sqrt(0.5), 3), b(0, 1, 3);
  const auto arc = arc_through(a, m, b);
  ASSERT_TRUE(arc);
  EXPECT_NEAR(arc->angle, 1.5 * M_PI, 1e-12);
  EXPECT_LT((arc->at(0) - a).norm(), 1e-12);
  EXPECT_LT((arc->at(1. / 6) - m).norm(), 1e-12);
  EXPECT_LT((arc->at(1) - b).norm(), 1e-12);
  EXPECT_NEAR(arc->foot(Vector3d(0, -7, 4)), 1. / 3, 1e-12);
  EXPECT_NEAR(arc->distance(Vector3d(0, -5, 6)), 5, 1e-12);
  EXPECT_FALSE(arc_through(a, (a + b) / 2, b));
  EXPECT_FALSE(arc_through(a, a, b));
  EXPECT_FALSE(arc_through(a, m, a));
}

// Moving and turning an arc leaves it an arc; anything else has to be divided, the more so the
// finer the tolerance.
TEST(Division, AnArcIsDividedOnlyWhereACircleDoesNotFollow) {
  const auto arc = arc_through({1, 0, 0}, {0, 1, 0}, {-1, 0, 0});
  const auto moved =
      knots(200, [&](double t) { return Vector3d(0.1, 0.2, 0.01 * arc->at(t).y()); });
  EXPECT_EQ(divide_arc(*arc, 0.5, moved, 1e-4).size(), 2u);
  const auto waved = knots(200, [](double t) { return Vector3d(0, 0, 0.01 * std::sin(9 * t)); });
  const size_t coarse = divide_arc(*arc, 0.5, waved, 1e-3).size();
  const size_t fine = divide_arc(*arc, 0.5, waved, 1e-5).size();
  EXPECT_GT(coarse, 2u);
  EXPECT_GT(fine, coarse);
  EXPECT_LT(fine, 60u);
}

// The controller draws the arc through its own auxiliary point, wherever that lies: here at 0.3,
// beside the only knot that is displaced.
TEST(Division, AWholeArcGoesThroughItsAuxiliaryPoint) {
  const auto arc = arc_through({1, 0, 0}, {0, 1, 0}, {-1, 0, 0});
  auto peak = knots(100, [](double) { return Vector3d::Zero(); });
  peak[50].displacement = Vector3d(0, 0.01, 0);
  EXPECT_THAT(divide_arc(*arc, 0.3, peak, 1e-3, 0.4), ElementsAre(0, 50, 100));
}

// A half circle of no knots between its ends is no line.
TEST(Division, AnArcBetweenTwoKnotsIsNotStraight) {
  const auto arc = arc_through({1, 0, 0}, {0, 1, 0}, {-1, 0, 0});
  const auto few = knots(2, [](double) { return Vector3d::Zero(); });
  EXPECT_FALSE(is_straight(*arc, few, 0, 1, 0.2));  // sagitta of a quarter: 1 - cos 45 deg = 0.29
  EXPECT_TRUE(is_straight(*arc, few, 0, 1, 0.3));
}

// A displacement that would divide off one knot after the other takes no quadratic time.
TEST(Division, AMillionKnotsAreNoMatter) {
  const auto steep = knots(1'000'000, [](double t) { return Vector3d(0, std::exp2(-1e6 * t), 0); });
  EXPECT_LT(divide_line(steep, 1e-9).size(), 100u);
  const auto saw =
      knots(300'000, [](double t) { return Vector3d(0, std::fmod(std::round(t * 3e5), 2), 0); });
  EXPECT_GT(divide_line(saw, 1e-9).size(), 200'000u);
}

}  // namespace
}  // namespace armtrue::division_test
