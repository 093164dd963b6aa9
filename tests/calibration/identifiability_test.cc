#include "armtrue/calibration/identifiability.h"

#include <gmock/gmock.h>

#include <Eigen/QR>
#include <algorithm>
#include <string>
#include <tuple>

#include "armtrue/campaign/simulation.h"
#include "armtrue/effects/identify.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "kinematics/six_axes.h"

namespace armtrue::identifiability_test {
namespace {

using testing::Contains;
using testing::Not;

Robot kr360() { return read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot; }

// Table 1 as the paper has it: axes 6 and 7 coincide (d_7 = 0).
Robot table1() { return read_robot(ARMTRUE_CONFIG "/robots/kr360.yaml").robot; }

Campaign poses(const Robot& robot, bool orientation, int count = 80) {
  SimulationOptions options;
  options.poses = count;
  options.orientation = orientation;
  return simulate(robot, robot, options);
}

std::vector<std::string> links_with_beta(const Robot& robot, const std::vector<int>& beta) {
  std::vector<std::string> names;
  for (int j = 0; j < kLinks; ++j)
    for (LinkParameter which :
         {LinkParameter::alpha, LinkParameter::d, LinkParameter::theta, LinkParameter::r})
      names.push_back(parameter_name(robot.chain, link_parameter(j, which)));
  for (int j : beta)
    names.push_back(parameter_name(robot.chain, link_parameter(j - 1, LinkParameter::beta)));
  return names;
}

std::vector<std::string> names_of(const Robot& robot, const std::vector<int>& parameters) {
  std::vector<std::string> names;
  for (int k : parameters) names.push_back(parameter_name(robot.chain, k));
  return names;
}

std::vector<std::string> allowed(const Robot& robot, const std::vector<std::string>& identify) {
  Robot listed = robot;
  listed.identify = identify;
  std::vector<std::string> names =
      names_of(robot, allowed_parameters(listed, poses(robot, true, 3)));
  std::ranges::sort(names);
  return names;
}

TEST(Identifiability, PatternsStandForNamesAndMinusTakesAway) {
  const Robot robot = kr360();
  const auto all = allowed(robot, {"auto"});
  EXPECT_EQ(allowed(robot, {"*"}), all);
  EXPECT_EQ(allowed(robot, {"A?.d"}),
            allowed(robot, {"A1.d", "A2.d", "A3.d", "A4.d", "A5.d", "A6.d"}));
  EXPECT_EQ(allowed(robot, {"base*"}), allowed(robot, {"base"}));
  EXPECT_EQ(allowed(robot, {"tool.r?"}), allowed(robot, {"tool", "-tool.?"}));
  EXPECT_EQ(allowed(robot, {"auto", "-*", "A3.r"}), allowed(robot, {"A3.r"}));
  EXPECT_EQ(allowed(robot, {"A3.r", "-A3.r", "A3.r"}), allowed(robot, {"A3.r"}));
  EXPECT_EQ(allowed(robot, {"auto", "-base", "-tool"}).size(), all.size() - 12);
  EXPECT_THAT(allowed(robot, {"auto", "-A3.d"}), Not(Contains("A3.d")));
  EXPECT_EQ(allowed(robot, {"auto", "-A3.d"}).size(), all.size() - 1);
}

TEST(Identifiability, WhatWouldImitateAHeldParameterIsHeldToo) {
  Robot robot = kr360();
  const Campaign campaign = poses(robot, true);
  std::vector<int> expected = choose_identifiable(robot, campaign).kept;
  for (const char* name :
       {"A5.theta", "tool.x", "tool.y", "tool.z", "tool.rx", "tool.ry", "tool.rz"})
    ASSERT_EQ(std::erase(expected, *find_parameter(robot.chain, name)), 1u) << name;
  robot.identify = {"auto", "-A5.theta", "-tool"};
  const IdentifiableSet set = choose_identifiable(robot, campaign);
  EXPECT_EQ(set.kept, expected);  // neither A5.beta nor the last link in their place
  EXPECT_TRUE(set_up_not_shown(robot.chain, set).empty());
}

TEST(Identifiability, AWrongEntrySaysWhatIsNear) {
  const KinematicChain chain = kr360().chain;
  const auto why = [&](const std::vector<std::string>& identify) {
    return why_not_identified(chain, identify);
  };
  EXPECT_EQ(why({"auto", "-*.theta", "A3.theta", "paper-25"}), "");
  EXPECT_THAT(why({"A3.thet"}), testing::HasSubstr("did you mean A3.theta?"));
  EXPECT_THAT(why({"*.thet"}), testing::HasSubstr("did you mean A1.theta, A2.theta"));
  EXPECT_THAT(why({"-A3.d", "auto"}), testing::HasSubstr("takes away from nothing"));
  EXPECT_THAT(why({"auto", "-A33.d"}), testing::HasSubstr("did you mean A3.d?"));
  EXPECT_THAT(why({"xyz.abc"}), Not(testing::HasSubstr("did you mean")));
  EXPECT_TRUE(identifies_all({"base", "auto"}));
  EXPECT_FALSE(identifies_all({"auto", "-A3.d"}));
  EXPECT_FALSE(identifies_all({"*.d"}));
}

TEST(Identifiability, RanksOfTheSeedPaper) {
  Robot robot = kr360();
  EXPECT_EQ(choose_identifiable(robot, poses(robot, true)).kept.size(),
            30u);  // base, links and tool
  EXPECT_EQ(choose_identifiable(robot, poses(robot, false)).kept.size(), 27u);  // from points alone
  robot = table1();
  robot.identify = links_with_beta(robot, {3});
  EXPECT_EQ(choose_identifiable(robot, poses(robot, true)).kept.size(), 26u);
  robot.identify = {"paper-25"};
  EXPECT_EQ(choose_identifiable(robot, poses(robot, true)).kept.size(), 25u);
}

// A chain in a free frame with a free tool has 4 parameters for each joint that turns, 2 for each
// that slides and 6 for the last frame (Everett, Driels and Mooring 1987): a line in space has four
// coordinates, of an axis along which a link slides only the direction counts. The base is the six
// of the first joint's frame, the tool those of the last; zero offsets are among the four and two.
size_t rank_of(int turning, int sliding) {
  return static_cast<size_t>(4 * turning + 2 * sliding + 6);
}

// A link that follows has an axis as any other, and its constant stands for the zero of an encoder.
// So a palletiser of four encoders has the five axes of rank_of(5, 0), but rods keep the flange
// level, and then two directions are lost:
//     up          base.z and tool.z: the axis of the flange is parallel to axis 1 in all poses
//     to the fore the distance of axis 2 from axis 1, and of axis 4 from the bracket: between them
//     lie
//                 the arms, and behind them the bracket looks where the column does
// A coefficient is one more, where it is asked for: the turn of a link per turn of another.
TEST(Identifiability, RanksOfAPalletiser) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/irb460.yaml").robot;
  robot.chain.tool.translation = {0.05, 0.02, 0.1};
  const Campaign campaign = poses(robot, true);
  EXPECT_EQ(choose_identifiable(robot, campaign).kept.size(), rank_of(5, 0) - 2);
  const std::vector<std::string> coefficients{"A3.follows.A2", "tilt.follows.A2",
                                              "tilt.follows.A3"};
  const size_t without = choose_identifiable(robot, campaign).kept.size();
  for (const std::string& name : coefficients) robot.priors[name] = 1;
  const auto with = names_of(robot, choose_identifiable(robot, campaign).kept);
  EXPECT_EQ(with.size(), without + 3);
  for (const std::string& name : coefficients) EXPECT_THAT(with, Contains(name));
  robot.priors.clear();
  robot.identify = {"base", "tool", "tilt.follows.A3"};
  EXPECT_THAT(names_of(robot, choose_identifiable(robot, campaign).kept),
              Contains("tilt.follows.A3"));
  EXPECT_THAT(names_of(robot, choose_identifiable(robot, campaign).kept),
              Not(Contains("tilt.follows.A2")));
}

// Counted from the ground, joint 3 shows another angle of the same arm: 4 for each of six axes
// and 6.
TEST(Identifiability, CoupledEncodersDoNotChangeTheRank) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/r2000ic-165f.yaml").robot;
  robot.chain.couplings = {{2, 1, 1.0, robot.chain.links[1].theta}};
  EXPECT_EQ(choose_identifiable(robot, poses(robot, true)).kept.size(), rank_of(6, 0));
}

TEST(Identifiability, RanksOfOtherArms) {
  const auto shipped = [](const std::string& name) {
    return read_robot(ARMTRUE_CONFIG "/robots/" + name + ".yaml").robot;
  };
  const Robot seven = shipped("iiwa14"), rail = shipped("kr360-rail");
  EXPECT_EQ(choose_identifiable(seven, poses(seven, true)).kept.size(), rank_of(7, 0));
  EXPECT_EQ(choose_identifiable(rail, poses(rail, true)).kept.size(), rank_of(6, 1));
  // A SCARA: its four axes are parallel, which beta describes without a singularity.
  Robot scara;
  for (const auto& [name, joint, d, r] : {std::tuple("A1", JointKind::revolute, 0.0, 0.3),
                                          std::tuple("A2", JointKind::revolute, 0.25, 0.0),
                                          std::tuple("A3", JointKind::prismatic, 0.2, 0.0),
                                          std::tuple("A4", JointKind::revolute, 0.0, 0.0)}) {
    Link& link = scara.chain.links.emplace_back();
    link.name = name;
    link.joint = joint;
    link.d = d;
    link.r = r;
    link.min = joint == JointKind::prismatic ? -0.2 : -2.2;
    link.max = joint == JointKind::prismatic ? 0.0 : 2.2;
  }
  EXPECT_EQ(choose_identifiable(scara, poses(scara, true)).kept.size(), rank_of(3, 1));
  scara.identify = {"paper-25"};
  EXPECT_THROW(choose_identifiable(scara, poses(scara, true)), std::invalid_argument);
}

// Of long campaigns every so many rows are looked at, among them those of every target, however
// the rows alternate.
TEST(Identifiability, SeesEveryTargetOfALongCampaign) {
  for (int targets : {3, 4}) {
    Robot robot = kr360();
    for (int k = 0; k < targets; ++k)
      robot.chain.targets.push_back({"T" + std::to_string(k + 1), {0.1, 0.05 * k, 0.02 * k * k}});
    Campaign campaign = poses(robot, false, 2000 * targets);
    for (const Target& target : robot.chain.targets) campaign.target_names.push_back(target.name);
    for (int row = 0; row < campaign.rows(); ++row) {
      campaign.target.push_back(row % targets);
      campaign.pose[row] = row / targets;
      campaign.q[row] = campaign.q[row - row % targets];
    }
    const std::vector<std::string> names =
        names_of(robot, choose_identifiable(robot, campaign).kept);
    for (const std::string& target : campaign.target_names)
      for (const char* axis : {".x", ".y", ".z"})
        EXPECT_THAT(names, Contains(testing::EndsWith(target + axis)));
  }
}

// Eq. 3 as it is printed turns alpha_3 and beta_3 about the same axis y: then one of the 25 is
// lost.
TEST(Identifiability, PrintedEquationThreeHasRank24) {
  Robot robot = kr360();
  robot.identify = {"paper-25"};
  const Campaign campaign = poses(robot, true);
  const IdentifiableSet set = choose_identifiable(robot, campaign);
  const ChainEvaluator chain(robot.chain);
  Eigen::MatrixXd stacked(6 * campaign.rows(), 25);
  for (int row = 0; row < campaign.rows(); ++row) {
    PoseJacobian jacobian;
    chain.pose(campaign.q[row], jacobian);
    for (int k = 0; k < 25; ++k) {
      // alpha_3 about the axis of beta_3: Rot(y) instead of Rot(x).
      const int printed = set.kept[k] == link_parameter(2, LinkParameter::alpha)
                              ? link_parameter(2, LinkParameter::beta)
                              : set.kept[k];
      stacked.block<6, 1>(6 * row, k) = jacobian.col(printed);
    }
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(stacked);
  qr.setThreshold(1e-9);
  EXPECT_EQ(qr.rank(), 24);
}

TEST(Identifiability, AbsorbedParametersNameTheirAbsorber) {
  Robot robot = table1();
  robot.identify = links_with_beta(robot, {3});
  const IdentifiableSet set = choose_identifiable(robot, poses(robot, true));
  const auto absorber = [&](const std::string& name) -> std::string {
    for (const AbsorbedParameter& absorbed : set.absorbed)
      if (parameter_name(robot.chain, absorbed.parameter) == name)
        return parameter_name(robot.chain, absorbed.absorbed_by.front().first);
    return "nothing";
  };
  EXPECT_EQ(absorber("A3.r"), "A2.r");
  EXPECT_EQ(absorber("spindle.theta"), "A6.theta");
  EXPECT_EQ(absorber("spindle.r"), "A6.r");
}

TEST(Identifiability, ACalibratedRobotKeepsTheSetOfItsNominal) {
  const Robot nominal = kr360();
  const Robot calibrated = read_robot(ARMTRUE_CONFIG "/robots/kr360-table4.yaml").robot;
  const Campaign campaign = poses(nominal, true);
  EXPECT_EQ(names_of(nominal, choose_identifiable(nominal, campaign).kept),
            names_of(calibrated, choose_identifiable(calibrated, campaign).kept));
}

TEST(Identifiability, AJointThatNeverMovesIsMissed) {
  const Robot robot = kr360();
  Campaign campaign = poses(robot, true);
  for (auto q : campaign.q) q[4] = 0.3;
  const IdentifiableSet set = choose_identifiable(robot, campaign);
  EXPECT_LT(set.kept.size(), 30u);
  EXPECT_THAT(lost_to_poses(robot, campaign, set), Not(testing::IsEmpty()));
  EXPECT_THAT(
      lost_to_poses(robot, poses(robot, true), choose_identifiable(robot, poses(robot, true))),
      testing::IsEmpty());
}

TEST(Identifiability, AnUnknownNameIsAnError) {
  Robot robot = kr360();
  robot.identify = {"A2.d", "A9.alpha"};
  EXPECT_THROW(choose_identifiable(robot, poses(robot, true)), std::invalid_argument);
}

}  // namespace
}  // namespace armtrue::identifiability_test
