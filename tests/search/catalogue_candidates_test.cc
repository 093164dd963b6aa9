#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "armtrue/io/campaign_io.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "search/candidates.h"

namespace armtrue {
namespace {

Catalogue one_entry(const std::string& keys) {
  return parse_catalogue("format: armtrue-catalogue/1\neffects:\n  - {name: n, " + keys + "}\n",
                         "c.yaml");
}

std::vector<Candidate> candidates(const std::string& keys) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  const Campaign campaign = read_campaign(ARMTRUE_CONFIG "/campaigns/tutorial.csv").campaign;
  return catalogue_candidates(one_entry(keys), robot, campaign);
}

TEST(CatalogueCandidates, NothingGrowsThatHasNoLength) {
  std::set<std::string> growing;
  for (const Candidate& candidate :
       candidates("parameter: r, driver: time, shape: linear, most_of_length: 0.0014")) {
    growing.insert(to_string(candidate.effect.parameter));
    EXPECT_LT(candidate.furthest, 0);  // all of this arm are below zero
  }
  EXPECT_EQ(growing, (std::set<std::string>{"A1.r", "A4.r", "A6.r"}));
}

TEST(CatalogueCandidates, AGrowthBeyondItsBoundOrOfAnotherSignIsNotAllowed) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  const Campaign campaign = read_campaign(ARMTRUE_CONFIG "/campaigns/tutorial.csv").campaign;
  const std::vector<Candidate> growth = catalogue_candidates(
      one_entry("parameter: d, joints: [4], driver: time, shape: linear, most_of_length: 0.0014"),
      robot, campaign);
  ASSERT_EQ(growth.size(), 1u);
  const CandidateScan scan(growth, robot, campaign);
  const auto [first, last] = std::ranges::minmax(campaign.time_s);
  const double bound = 0.0014 * 0.055 / (last - first);  // A4.d is 55 mm long
  const auto is_allowed = [&](double value) {
    return scan.is_allowed(0, Eigen::VectorXd::Constant(1, value));
  };
  EXPECT_TRUE(is_allowed(0.99 * bound));
  EXPECT_FALSE(is_allowed(1.01 * bound));
  EXPECT_FALSE(is_allowed(-0.5 * bound));
}

TEST(CatalogueCandidates, AllLengthsGrowByOneShareOfThem) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  const Campaign campaign = read_campaign(ARMTRUE_CONFIG "/campaigns/tutorial.csv").campaign;
  const CandidateScan scan(
      candidates("parameter: arm.scale, driver: time, shape: linear, most_of_length: 0.0014"),
      robot, campaign);
  ASSERT_EQ(scan.candidates().size(), 1u);
  const auto [first, last] = std::ranges::minmax(campaign.time_s);
  const auto is_allowed = [&](double share) {
    return scan.is_allowed(0, Eigen::VectorXd::Constant(1, share / (last - first)));
  };
  EXPECT_TRUE(is_allowed(0.99 * 0.0014));
  EXPECT_FALSE(is_allowed(1.01 * 0.0014));
  EXPECT_FALSE(is_allowed(-0.5 * 0.0014));
}

// The scales of two wires follow two lengths, although driver and shape are the same.
TEST(CatalogueCandidates, EachWireFollowsItsOwnLength) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  robot.chain.anchors = {{"near", {1.5, -1, 0.5}, 0}, {"far", {6, 3, 0.2}, 0}};
  const Campaign campaign = read_campaign(ARMTRUE_CONFIG "/campaigns/tutorial.csv").campaign;
  std::vector<Candidate> scales;
  for (const Anchor& anchor : robot.chain.anchors) {
    constexpr int kZero = 3;
    Candidate& scale = scales.emplace_back();
    scale.effect = {"wire scale",
                    Parameter(Owner::anchor, anchor.name, kZero),
                    {DriverKind::range, -1, -1, ""},
                    Shape{},
                    {}};
  }
  const auto scatter_of = [&](const std::vector<Candidate>& scanned, int k) {
    return CandidateScan(scanned, robot, campaign)
        .share_of_possible(k, Eigen::VectorXd::Constant(1, 1e-3));
  };
  const double of_near = scatter_of({scales[0]}, 0), of_far = scatter_of({scales[1]}, 0);
  EXPECT_GT(std::abs(of_near - of_far), 0.01 * of_far);
  EXPECT_DOUBLE_EQ(scatter_of(scales, 0), of_near);
  EXPECT_DOUBLE_EQ(scatter_of(scales, 1), of_far);
}

// The model fits no constants of the instrument: counted from 0 degC, its scale at 25.5 degC would
// be taken from the lengths of the arm. Links have constants, and count from 0 degC.
TEST(CatalogueCandidates, WhatTheInstrumentDoesCountsFromTheMeanTemperature) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  Campaign campaign = read_campaign(ARMTRUE_CONFIG "/campaigns/tutorial.csv").campaign;
  campaign.temperature_names = {"air"};
  campaign.temperature_c.clear();
  for (int row = 0; row < campaign.rows(); ++row)
    campaign.temperature_c.push_back({2 * row < campaign.rows() ? 20.0 : 31.0});
  ASSERT_EQ(campaign.rows() % 2, 0);
  const auto begin_of = [&](const std::string& parameter) {
    const auto found = catalogue_candidates(
        one_entry("parameter: " + parameter + ", driver: temperature, shape: linear"), robot,
        campaign);
    return found.empty() ? -1 : found.front().effect.shape.at;
  };
  EXPECT_DOUBLE_EQ(begin_of("instrument.scale"), 25.5);
  EXPECT_DOUBLE_EQ(begin_of("d, joints: [4]"), 0);
}

// A family for each joint that its name tells, and none where that joint is missing.
TEST(CatalogueCandidates, FamiliesOfEachJointAreNamedByIt) {
  std::set<std::string> families;
  for (const Candidate& candidate :
       candidates("parameter: r, driver: time, shape: linear, family: \"before {n}\", "
                  "typical_mm: 1, only_together: yes")) {
    families.insert(candidate.of_family);
    EXPECT_FALSE(may_be_alone(candidate));
  }
  EXPECT_EQ(families, (std::set<std::string>{"before 2", "before 3", "before 4", "before 5",
                                             "before 6"}));
}

TEST(CatalogueCandidates, MayFollowTheNextJoint) {
  for (const Candidate& candidate :
       candidates("parameter: r, driver: joint-angle next, shape: harmonic 1")) {
    const std::string link = candidate.effect.parameter.of;
    EXPECT_EQ("A" + std::to_string(candidate.effect.driver.joint), link);
  }
}

std::set<std::string> driven(const Robot& robot, const std::string& keys) {
  const Campaign campaign = read_campaign(ARMTRUE_CONFIG "/campaigns/tutorial.csv").campaign;
  std::set<std::string> parameters;
  for (const Candidate& candidate : catalogue_candidates(one_entry(keys), robot, campaign))
    parameters.insert(to_string(candidate.effect.parameter));
  return parameters;
}

// A basis stands for the load of unknown masses, which a shape of it or a product with it has not.
TEST(CatalogueCandidates, OnlyWhatNeedsTheMassesIsLeftOutWithoutThem) {
  const Robot with = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  Robot without = with;
  without.bodies.clear();
  for (const auto& [keys, needs_masses] :
       {std::pair("driver: gravity-torque own, shape: linear", false),
        std::pair("driver: joint-angle own, shape: harmonic 2", false),
        std::pair("driver: gravity-torque own, shape: sign", true),
        std::pair("driver: time * gravity-torque own, shape: linear", true)}) {
    const std::string entry = std::string("joints: [2, 3], parameter: theta, ") + keys;
    const std::set<std::string> both{"A2.theta", "A3.theta"};
    EXPECT_EQ(driven(with, entry), both) << keys;
    EXPECT_EQ(driven(without, entry), needs_masses ? std::set<std::string>() : both) << keys;
  }
}

// About an upright axis the torque is rounding, also behind the base of an earlier calibration; on
// a wall it is not.
TEST(CatalogueCandidates, AnAxisAlongGravityGivesWayToNone) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  for (const char* driver :
       {"gravity-torque own", "tool-weight own", "time * gravity-torque own"}) {
    const std::string entry = std::string("parameter: theta, shape: linear, driver: ") + driver;
    for (const double tilt : {0.0, 4e-8, 1.5}) {
      robot.chain.base.rotation =
          Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitY()).toRotationMatrix();
      robot.gravity = robot.chain.base.rotation.transpose() * Eigen::Vector3d(0, 0, -9.81);
      const std::set<std::string> names = driven(robot, entry);
      EXPECT_EQ(names.contains("A1.theta"), tilt == 1.5) << driver << tilt;
      EXPECT_TRUE(names.contains("A2.theta") && names.contains("A3.theta")) << driver << tilt;
    }
  }
}

TEST(CatalogueCandidates, EachOfSeveralMeansTheOwnersOfItsKindAlone) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  robot.chain.targets = {{"left", {}}, {"right", {}}};
  robot.chain.anchors = {{"1", {}}, {"2", {}}};
  for (const auto& [parameter, expected] :
       {std::pair("target", std::set<std::string>{"target left.x", "target right.x"}),
        std::pair("anchor", std::set<std::string>{"anchor 1.x", "anchor 2.x"})}) {
    std::set<std::string> names;
    for (const Effect& effect : expand(
             one_entry(std::string("driver: time, shape: linear, parameter: ") + parameter + ".x")
                 .front(),
             robot))
      names.insert(to_string(effect.parameter));
    EXPECT_EQ(names, expected);
  }
}

// The parameters that may have stepped between two sessions.
std::set<std::string> steps_between_sessions(const Robot& robot, Campaign campaign) {
  campaign.time_s.clear();
  campaign.session_names = {"1", "2"};
  campaign.session.clear();
  for (int row = 0; row < campaign.rows(); ++row)
    campaign.session.push_back(campaign.pose[static_cast<size_t>(row)] % 2);
  std::set<std::string> parameters;
  for (const char* parameter : {"theta", "base", "base.x", "tool"})
    for (const Candidate& candidate : catalogue_candidates(
             one_entry(std::string("driver: time, shape: step, parameter: ") + parameter), robot,
             campaign)) {
      EXPECT_EQ(to_string(candidate.effect.driver), "session");
      parameters.insert(to_string(candidate.effect.parameter));
    }
  return parameters;
}

// Each session has its base for itself, and the zero offsets that the robot file gives it.
TEST(CatalogueCandidates, WhatEachSessionHasOfItsOwnDoesNotStepBetweenThem) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  const Campaign campaign = read_campaign(ARMTRUE_CONFIG "/campaigns/tutorial.csv").campaign;
  EXPECT_EQ(steps_between_sessions(robot, campaign),
            (std::set<std::string>{"A1.theta", "A2.theta", "A3.theta", "A4.theta", "A5.theta",
                                   "A6.theta", "tool"}));
  robot.identify_per_session = {"A2.theta", "A5.theta"};
  EXPECT_EQ(steps_between_sessions(robot, campaign),
            (std::set<std::string>{"A1.theta", "A3.theta", "A4.theta", "A6.theta", "tool"}));
}

}  // namespace
}  // namespace armtrue
