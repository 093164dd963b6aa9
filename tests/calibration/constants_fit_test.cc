#include "armtrue/calibration/constants_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "support/oracle.h"

namespace armtrue {
namespace {

using armtrue_oracle::OracleArm;
using armtrue_oracle::OracleLink;

constexpr const char* kSagging = ARMTRUE_CONFIG "/robots/kr360-undeclared.yaml";
constexpr double kSag = 2.2e-7;  // of A3 by gravity, as the file states [rad/(N m)]
constexpr int kPoses = 40;

// The oracle shares no code with the fit: KDL frames, weights summed in world axes.
struct Cell {
  OracleArm constants = armtrue_oracle::read_arm(kSagging);
  std::vector<std::array<double, 6>> visits;
  std::vector<KDL::Frame> reached;

  Cell() {
    armtrue_oracle::Dice dice(3);
    for (int i = 0; i < kPoses; ++i) {
      std::array<double, 6>& q = visits.emplace_back();
      for (size_t j = 0; j < q.size(); ++j)
        q[j] = dice.uniform(constants.links[j].min, constants.links[j].max);
      OracleArm sagging = constants;
      sagging.links[2].theta += kSag * armtrue_oracle::moment_of(constants, q).torque[2];
      reached.push_back(armtrue_oracle::forward(sagging, q));
    }
  }

  // Of points and, with the weight of the header, of turns [m^2].
  double squares(const OracleArm& arm) const {
    double sum = 0;
    for (size_t i = 0; i < visits.size(); ++i) {
      const KDL::Twist missing = KDL::diff(armtrue_oracle::forward(arm, visits[i]), reached[i]);
      sum += KDL::dot(missing.vel, missing.vel) +
             kLengthOfTurn * kLengthOfTurn * KDL::dot(missing.rot, missing.rot);
    }
    return sum;
  }

  double mean_distance(const OracleArm& arm) const {
    double sum = 0;
    for (size_t i = 0; i < visits.size(); ++i)
      sum += (armtrue_oracle::forward(arm, visits[i]).p - reached[i].p).Norm();
    return sum / kPoses;
  }

  std::vector<JointVector> joints() const {
    std::vector<JointVector> all;
    for (const std::array<double, 6>& q : visits)
      all.push_back(Eigen::Map<const Eigen::Matrix<double, 6, 1>>(q.data()));
    return all;
  }
};

std::array<double*, 5> numbers(OracleLink& link) {
  return {&link.alpha, &link.d, &link.theta, &link.r, &link.beta};
}

OracleArm with_links_of(OracleArm arm, const KinematicChain& chain) {
  for (size_t j = 0; j < arm.links.size(); ++j) {
    const Link& link = chain.links[j];
    OracleLink& own = arm.links[j];
    own.alpha = link.alpha;
    own.d = link.d;
    own.theta = link.theta;
    own.r = link.r;
    own.beta = link.beta;
  }
  return arm;
}

// Tries each number of each link up and down, and halves the steps where none helps.
double searched_squares(const Cell& cell) {
  OracleArm best = cell.constants;
  double least = cell.squares(best);
  for (double step = 1e-3; step > 1e-6;) {
    bool improved = false;
    for (OracleLink& link : best.links)
      for (double* number : numbers(link))
        for (double sign : {1.0, -1.0}) {
          const double kept = *number;
          *number += sign * step;
          const double squares = cell.squares(best);
          improved = improved || squares < least;
          if (squares < least)
            least = squares;
          else
            *number = kept;
        }
    if (!improved) step /= 2;
  }
  return least;
}

ConstantsFit fit_of(const Cell& cell) {
  const Robot robot = read_robot(kSagging).robot;
  return fit_constants(robot, robot.chain, link_parameters(robot.chain),
                       visits_at(robot, cell.joints(), {}));
}

TEST(ConstantsFit, NoSearchFindsConstantsThatComeNearer) {
  const Cell cell;
  const OracleArm fitted = with_links_of(cell.constants, fit_of(cell).chain);
  const double squares = cell.squares(fitted);
  EXPECT_LT(squares, 0.6 * cell.squares(cell.constants));
  EXPECT_LT(squares, 1.0001 * searched_squares(cell));
  armtrue_oracle::Dice dice(4);
  for (int k = 0; k < 300; ++k) {
    OracleArm moved = fitted;
    for (OracleLink& link : moved.links)
      for (double* number : numbers(link)) *number += 1e-5 * dice.normal();
    EXPECT_GT(cell.squares(moved), squares * (1 - 1e-6));
  }
}

TEST(ConstantsFit, SaysTheErrorsOfBothConstants) {
  const Cell cell;
  const ConstantsFit fit = fit_of(cell);
  EXPECT_NEAR(fit.before.mean, cell.mean_distance(cell.constants), 1e-9);
  EXPECT_NEAR(fit.after.mean, cell.mean_distance(with_links_of(cell.constants, fit.chain)), 1e-9);
}

TEST(ConstantsFit, WithoutEffectsChangesNothing) {
  Robot robot = read_robot(kSagging).robot;
  robot.effects.clear();
  const ConstantsFit fit =
      fit_constants(robot, robot.chain, link_parameters(robot.chain), visits_of_travel(robot, {}));
  EXPECT_EQ(fit.after.max, 0);
  EXPECT_EQ(fit.chain.links[2].theta, robot.chain.links[2].theta);
}

TEST(ConstantsFit, SaysWhichEffectsConstantsCannotHold) {
  Robot robot = read_robot(kSagging).robot;
  EXPECT_TRUE(not_in_constants(robot).empty());
  const auto add = [&](const char* name, const char* parameter, const char* driver) {
    robot.effects.push_back({name, parameter, *parse_driver(driver), Shape{}, {{"c", 1e-6}}});
  };
  add("radial offset", "instrument.range", "position");
  EXPECT_EQ(not_in_constants(robot),
            std::vector<std::string>{"effects of the instrument or the measured tool are not in "
                                     "the constants: radial offset"});
  add("compliance", "A2.theta", "motor-torque 2");
  const std::vector<std::string> both = not_in_constants(robot);
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[1],
            "effects of measured motor torques, which are not known at other poses, are not in the "
            "constants: compliance");
  EXPECT_EQ(arm_of_constants(robot).effects.size(), read_robot(kSagging).robot.effects.size());
}

TEST(ConstantsFit, FindsZeroOffsetsOfAnotherModelAndMovesNothingElse) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  Robot arm = robot;
  const std::array<double, 6> zeros{1e-4, -2e-3, 7e-4, 0, 3e-4, -5e-4};
  for (size_t j = 0; j < zeros.size(); ++j) arm.chain.links[j].theta += zeros[j];
  const ConstantsFit fit =
      fit_constants(arm, robot.chain, zero_offsets(robot.chain), visits_of_travel(arm, {}));
  EXPECT_GT(fit.before.mean, 1e-3);
  EXPECT_LT(fit.after.max, 1e-10);
  for (size_t j = 0; j < zeros.size(); ++j) {
    EXPECT_NEAR(fit.chain.links[j].theta - robot.chain.links[j].theta, zeros[j], 1e-12);
    EXPECT_EQ(fit.chain.links[j].alpha, robot.chain.links[j].alpha);
    EXPECT_EQ(fit.chain.links[j].r, robot.chain.links[j].r);
  }
}

// An arm that comes from either side as often has its constants in the middle.
TEST(ConstantsFit, ABacklashDoesNotMoveTheConstantsOfTheTravel) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  Effect backlash{"backlash", "A2.theta", {DriverKind::arrival, 1}, sign_shape(), {{"c", 1e-4}}};
  robot.effects = {backlash};
  const ConstantsFit fit =
      fit_constants(robot, robot.chain, link_parameters(robot.chain), visits_of_travel(robot, {}));
  EXPECT_GT(fit.after.mean, 0.9 * fit.before.mean);
  EXPECT_LT(std::abs(fit.chain.links[1].theta - robot.chain.links[1].theta), 1e-5);
}

// Joint 4 goes up by 10 and 15 deg, and then 5 back: a stroke counts from the last reversal.
TEST(ConstantsVisits, HaveTheMotionOfTheirOrder) {
  const Robot robot = read_robot(kSagging).robot;
  std::vector<JointVector> q(4, JointVector::Zero(6));
  q[1][3] = 10 * kDegree;
  q[2][3] = 25 * kDegree;
  q[3][3] = 20 * kDegree;
  const ConstantsVisits visits = visits_at(robot, q, {});
  ASSERT_EQ(visits.contexts.size(), 4u);
  const std::array strokes{0.0, 10.0, 25.0, -5.0};
  for (size_t k = 1; k < 4; ++k) {
    EXPECT_NEAR(visits.contexts[k].stroke[3] / kDegree, strokes[k], 1e-9) << k;
    EXPECT_EQ(visits.contexts[k].arrival[3], k == 3 ? -1 : 1) << k;
  }
}

}  // namespace
}  // namespace armtrue
