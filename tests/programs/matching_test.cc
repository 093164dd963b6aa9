#include "programs/matching.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <vector>

namespace armtrue::matching_test {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Matrix3Xd columns(const std::vector<Vector3d>& points) {
  Matrix3Xd result(3, static_cast<Index>(points.size()));
  for (size_t i = 0; i < points.size(); ++i) result.col(static_cast<Index>(i)) = points[i];
  return result;
}

void expect_places(const Matrix3Xd& polygon, const std::vector<Vector3d>& points,
                   const std::vector<double>& expected) {
  const VectorXd places = places_in_order(polygon, columns(points), 0.1);
  for (size_t i = 0; i < points.size(); ++i) {
    const double place = places[static_cast<Index>(i)];
    if (std::isnan(expected[i]))
      EXPECT_TRUE(std::isnan(place)) << i << ": " << place;
    else
      EXPECT_NEAR(place, expected[i], 1e-12) << i;
  }
}

TEST(Matching, AClosedContourBeginsAndEndsAtOnePoint) {
  const Matrix3Xd square = columns({{0, 0, 0}, {9, 0, 0}, {9, 9, 0}, {0, 9, 0}, {0, 0, 0}});
  expect_places(square, {{0, 0, 5}, {0, 0, 0}, {9, 3, 0}, {0, 9.05, 0}, {0, 0, 0}, {0, 0, 5}},
                {NAN, 0, 1 + 1. / 3, 3, 4, NAN});
}

// The approach touches where the path ends: it may not push the rest off the path.
TEST(Matching, OnePointOutOfOrderIsTheOneLeftOut) {
  const Matrix3Xd line = columns({{0, 0, 0}, {9, 0, 0}, {9, 9, 0}});
  expect_places(line, {{9, 9, 0}, {0, 0, 0}, {4.5, 0, 0}, {9, 0, 0}}, {NAN, 0, 0.5, 1});
}

TEST(Matching, ForthAndBackAndForth) {
  const Matrix3Xd line = columns({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}});
  expect_places(
      line, {{0, 0, 0}, {0.5, 0, 0}, {1, 0, 0}, {0.5, 0, 0}, {0.25, 0, 0}, {0, 0, 0}, {1, 0, 0}},
      {0, 0.5, 1, 1.5, 1.75, 2, 3});
}

TEST(Matching, RowsCloserThanTheTolerance) {
  const Matrix3Xd rows = columns({{0, 0, 0}, {9, 0, 0}, {9, 0.05, 0}, {0, 0.05, 0}});
  expect_places(rows, {{3, 0, 0}, {6, 0, 0}, {6, 0.05, 0}, {3, 0.05, 0}},
                {1. / 3, 2. / 3, 2 + 1. / 3, 2 + 2. / 3});
}

TEST(Matching, StandstillIsOnePlace) {
  expect_places(columns({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {2, 0, 0}}),
                {{1, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {1, 1, 4});
}

TEST(Matching, AtPlaceIsLinearBetweenSamples) {
  const Matrix3Xd samples = columns({{0, 0, 0}, {1, 2, 3}, {1, 2, 5}});
  EXPECT_EQ(at_place(samples, 0.5), Vector3d(0.5, 1, 1.5));
  EXPECT_EQ(at_place(samples, 2), Vector3d(1, 2, 5));
}

TEST(Matching, TheNearestPointAndHowFar) {
  const NearestPoint nearest =
      nearest_to(columns({{0, 0, 0}, {9, 0, 0}}), columns({{0, 5, 0}, {4, 0, 3}, {20, 0, 0}}));
  EXPECT_EQ(nearest.point, 1);
  EXPECT_DOUBLE_EQ(nearest.distance, 3);
}

// By brute force: every point may take any foot on any segment, or none.
double best_sum(const Matrix3Xd& polygon, const Matrix3Xd& points, double tolerance) {
  struct Choice {
    double place, sum;
  };
  std::vector<Choice> choices;
  double best = 0;
  for (Index i = 0; i < points.cols(); ++i) {
    std::vector<Choice> here;
    for (Index k = 0; k + 1 < polygon.cols(); ++k) {
      const Vector3d chord = polygon.col(k + 1) - polygon.col(k);
      const double length = chord.squaredNorm();
      const double t =
          length > 0 ? std::clamp(chord.dot(points.col(i) - polygon.col(k)) / length, 0., 1.) : 0;
      const double d = (polygon.col(k) + t * chord - points.col(i)).norm();
      if (d > tolerance) continue;
      double before = 0;
      for (const Choice& choice : choices)
        if (choice.place <= static_cast<double>(k) + t) before = std::max(before, choice.sum);
      here.push_back({static_cast<double>(k) + t, before + 1 - d * d / (tolerance * tolerance)});
    }
    for (const Choice& choice : here) {
      choices.push_back(choice);
      best = std::max(best, choice.sum);
    }
  }
  return best;
}

RC_GTEST_PROP(Matching, NoChoiceInOrderIsBetter, ()) {
  const auto points = [](int count) {
    Matrix3Xd result(3, count);
    for (double& x : result.reshaped()) x = *rc::gen::inRange(0, 4);
    return result;
  };
  const Matrix3Xd polygon = points(*rc::gen::inRange(2, 40));
  const Matrix3Xd wanted = points(*rc::gen::inRange(1, 30));
  const double tolerance = 0.6;
  const VectorXd places = places_in_order(polygon, wanted, tolerance);
  double sum = 0, last = 0;
  for (Index i = 0; i < places.size(); ++i) {
    if (std::isnan(places[i])) continue;
    RC_ASSERT(places[i] >= last);
    last = places[i];
    const double d = (at_place(polygon, last) - wanted.col(i)).norm();
    RC_ASSERT(d <= tolerance + 1e-12);
    sum += 1 - d * d / (tolerance * tolerance);
  }
  RC_ASSERT(std::abs(sum - best_sum(polygon, wanted, tolerance)) < 1e-9);
}

}  // namespace
}  // namespace armtrue::matching_test
