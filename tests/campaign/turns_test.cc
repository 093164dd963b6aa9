#include "armtrue/campaign/turns.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

KinematicChain arm(int joints, double least_deg = NAN, double largest_deg = NAN) {
  KinematicChain chain;
  for (int j = 0; j < joints; ++j) {
    Link& link = chain.links.emplace_back();
    link.name = "L" + std::to_string(j);
    if (!std::isnan(least_deg)) link.min = least_deg * kDegree;
    if (!std::isnan(largest_deg)) link.max = largest_deg * kDegree;
  }
  return chain;
}

// Angles of all joints, uniform from `least` to `largest` [deg].
JointRows angles(int rows, int joints, double least, double largest, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> angle(least * kDegree, largest * kDegree);
  JointRows q(static_cast<size_t>(rows), JointVector(joints));
  for (auto values : q)
    for (double& value : values) value = angle(engine);
  return q;
}

JointRows within_one_turn(JointRows q) {
  for (auto values : q)
    for (double& value : values)
      if (value < 0) value += kTurn;
  return q;
}

double difference(const JointRows& a, const JointRows& b) {
  double most = 0;
  for (size_t k = 0; k < a.size(); ++k) most = std::max(most, (a[k] - b[k]).cwiseAbs().maxCoeff());
  return most;
}

// Whether the travel is stated or not, few rows or many.
TEST(Turns, AnglesFrom0To360ComeIntoTheTravel) {
  for (const KinematicChain& chain : {arm(7), arm(7, -175, 175), arm(7, -185, 185)})
    for (const int rows : {12, 60, 400})
      for (unsigned seed = 1; seed <= 20; ++seed) {
        const JointRows truth = angles(rows, 7, -165, 165, seed);
        JointRows q = within_one_turn(truth);
        const std::vector<MovedByTurns> moved = move_into_travel(q, {}, chain);
        EXPECT_LT(difference(q, truth), 1e-12) << rows << " " << seed;
        ASSERT_EQ(moved.size(), 7u);
        const MovedByTurns& first = moved.front();
        EXPECT_NEAR(first.as_given - kTurn, truth[static_cast<size_t>(first.first)][0], 1e-12);
      }
}

// The turns are counted, the angles lie close together, or an arm stands a little beyond what its
// file states.
TEST(Turns, AnglesThatMeanWhatTheySayStay) {
  for (const auto& [chain, least, largest] :
       {std::tuple(arm(6, -350, 350), -340.0, 340.0), std::tuple(arm(6, -350, 350), 10.0, 345.0),
        std::tuple(arm(6), -345.0, 345.0), std::tuple(arm(6), 100.0, 260.0),
        std::tuple(arm(6), -179.0, 179.0), std::tuple(arm(6, -185, 185), -195.0, 195.0),
        std::tuple(arm(6, 0, 350), 5.0, 345.0), std::tuple(arm(6, -185, 185), 3500.0, 3700.0)})
    for (const int rows : {20, 200}) {
      const JointRows given = angles(rows, 6, least, largest, 3);
      JointRows q = given;
      EXPECT_TRUE(move_into_travel(q, {}, chain).empty()) << least << " " << largest;
      EXPECT_EQ(difference(q, given), 0);
    }
}

TEST(Turns, AtTheEndOfATurnThePosesStayWhole) {
  const std::vector<int> pose{0, 1, 0, 1, 1};
  const std::vector<double> given{179.9995, 0.0008, -179.9997, 359.9976, -0.001};
  JointRows q;
  for (double angle : given) q.push_back(JointVector::Constant(1, angle * kDegree));
  JointRows alike = q;
  EXPECT_EQ(move_into_travel(q, pose, arm(1)).size(), 1u);
  const std::vector<double> right{179.9995, 0.0008, 180.0003, -0.0024, -0.001};
  for (size_t k = 0; k < q.size(); ++k) EXPECT_NEAR(q[k][0], right[k] * kDegree, 1e-12) << k;
  // A turn more is another place where the travel is longer than a turn.
  EXPECT_TRUE(move_into_travel(alike, pose, arm(1, -350, 370)).empty());
  EXPECT_FALSE(is_within_one_turn(arm(1, -350, 350).links.front()));
  EXPECT_TRUE(is_within_one_turn(arm(1).links.front()));
}

TEST(Turns, ASlideHasNone) {
  KinematicChain chain = arm(1, -1, 1);
  chain.links.front().joint = JointKind::prismatic;
  JointRows q{JointVector::Constant(1, 6.2), JointVector::Constant(1, -0.1)};
  EXPECT_TRUE(move_into_travel(q, {0, 0}, chain).empty());
  EXPECT_FALSE(is_within_one_turn(chain.links.front()));
}

}  // namespace
}  // namespace armtrue
