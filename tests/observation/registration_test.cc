// Where a calibration starts from: the base on readings of which some are wrong, base and tool
// together.

#include "armtrue/observation/registration.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "armtrue/kinematics/evaluator.h"
#include "armtrue/observation/contacts.h"
#include "armtrue/observation/placement.h"
#include "armtrue/statistics/random.h"

namespace armtrue::registration_test {
namespace {

const Pose kBase{rotation_exp({0.3, -0.8, 2.0}), {2.5, -1.2, 0.4}};

Robot arm() {
  Robot robot;
  robot.chain.links = six_axis_links();
  const double d[] = {0, 0.35, 1.1, 0.15, 0, 0}, r[] = {0.7, 0, 0, 1.2, 0, 0.2};
  const double alpha[] = {0, -0.5, 0, -0.5, 0.5, -0.5};
  for (int k = 0; k < 6; ++k) {
    robot.chain.links[k].d = d[k];
    robot.chain.links[k].r = r[k];
    robot.chain.links[k].alpha = alpha[k] * std::numbers::pi;
  }
  robot.chain.tool.translation = {0.05, -0.02, 0.1};
  return robot;
}

// Poses all over the joint space, without what was read there.
Campaign visits(int poses) {
  Random random(3);
  Campaign campaign;
  for (int pose = 0; pose < poses; ++pose) {
    campaign.pose.push_back(pose);
    campaign.pose_ids.push_back(std::to_string(pose));
    JointVector q(6);
    for (double& angle : q) angle = random.uniform(-2, 2);
    campaign.q.push_back(q);
  }
  return campaign;
}

// The points of the arm at this base; of every third reading another place.
void read_points(const Robot& robot, Campaign& campaign) {
  KinematicChain chain = robot.chain;
  chain.base = kBase;
  const ChainEvaluator evaluator(chain);
  for (int row = 0; row < campaign.rows(); ++row) {
    const Eigen::Vector3d wrong =
        row % 3 == 0 ? Eigen::Vector3d(0.5, 0, 0) : Eigen::Vector3d::Zero();
    campaign.position.push_back(evaluator.pose(campaign.q[row]).translation + wrong);
  }
}

void expect_near(const Pose& pose, const Pose& expected, double tolerance) {
  EXPECT_LT((pose.translation - expected.translation).norm(), tolerance);
  EXPECT_LT(rotation_log(expected.rotation.transpose() * pose.rotation).norm(), tolerance);
}

TEST(RegisteredBase, IsThatOfTheSoundReadingsWhereAThirdIsWrong) {
  Campaign campaign = visits(30);
  read_points(arm(), campaign);
  expect_near(registered_base(arm(), campaign), kBase, 1e-9);
}

// l = |a - p| + zero, with p from the base and the arm's own points.
Campaign wires(const Robot& robot, int poses) {
  Campaign campaign = visits(poses);
  KinematicChain chain = robot.chain;
  chain.base = kBase;
  const ChainEvaluator evaluator(chain);
  const Campaign single = campaign;
  campaign = {};
  for (int a = 0; a < std::ssize(robot.chain.anchors); ++a) {
    const Anchor& anchor = robot.chain.anchors[a];
    campaign.anchor_names.push_back(anchor.name);
    for (int row = 0; row < single.rows(); ++row) {
      campaign.pose.push_back(single.pose[row]);
      campaign.q.push_back(single.q[row]);
      campaign.anchor.push_back(a);
      const Eigen::Vector3d point = evaluator.pose(single.q[row]).translation;
      campaign.distance.push_back((anchor.position - point).norm() + anchor.zero);
    }
  }
  campaign.pose_ids = single.pose_ids;
  return campaign;
}

TEST(RegisteredBase, FollowsFromWiresWhoseReadingsBeginAtAZero) {
  Robot robot = arm();
  robot.chain.anchors = {
      {"1", {2.5, 1.5, 0.1}, 0.2}, {"2", {2.5, -1.5, 0.3}, -0.1}, {"3", {-0.5, 2.8, 1.5}, 0.3}};
  expect_near(registered_base(robot, wires(robot, 12)), kBase, 1e-8);
}

// Half of four points shows no rotation, half of six distances not where a wire begins.
TEST(RegisteredBase, FollowsFromFewReadings) {
  KinematicChain chain = arm().chain;
  chain.base = kBase;
  Campaign points = visits(4);
  for (const auto& q : points.q)
    points.position.push_back(ChainEvaluator(chain).pose(q).translation);
  expect_near(registered_base(arm(), points), kBase, 1e-9);

  Robot robot = arm();
  robot.chain.anchors = {
      {"1", {2.5, 1.5, 0.1}, 0.2}, {"2", {2.5, -1.5, 0.3}, -0.1}, {"3", {-0.5, 2.8, 1.5}, 0.3}};
  expect_near(registered_base(robot, wires(robot, 6)), kBase, 1e-7);
}

// Touched through one shim, a plane shows no side: its normal stays on that of its z axis.
TEST(Contacts, PlaneOfOneGaugeKeepsItsSide) {
  Robot robot = arm();
  robot.chain.contacts.emplace_back().name = "table";
  robot.chain.contacts[0].kind = ContactKind::plane;
  robot.chain.contacts[0].is_placed = false;
  for (int poses = 4; poses < 24; ++poses) {
    Campaign campaign = visits(poses);
    campaign.contact_names = {"table"};
    campaign.touch.assign(poses, {.contact = 0});
    campaign.distance.assign(poses, 3e-3);
    const Robot placed = with_contacts_fitted(robot, campaign, FitContacts::unplaced);
    EXPECT_GT(placed.chain.contacts[0].place.rotation(2, 2), 0) << poses;
  }
}

// Two anchors leave the turn about their line open: the distances are met all the same.
TEST(RegisteredBase, OfTwoWiresMeetsTheirDistances) {
  Robot robot = arm();
  robot.chain.anchors = {{"1", {2.5, 1.5, 0.1}, 0.2}, {"2", {2.5, -1.5, 0.3}, -0.1}};
  const Campaign campaign = wires(robot, 12);
  KinematicChain chain = robot.chain;
  chain.base = registered_base(robot, campaign);
  const ChainEvaluator evaluator(chain);
  for (int row = 0; row < campaign.rows(); ++row) {
    const Anchor& anchor = robot.chain.anchors[campaign.anchor[row]];
    const Eigen::Vector3d point = evaluator.pose(campaign.q[row]).translation;
    EXPECT_NEAR((anchor.position - point).norm() + anchor.zero, campaign.distance[row], 1e-8);
  }
}

TEST(Placement, FindsBaseAndToolWhereAThirdOfTheReadingsIsWrong) {
  Campaign campaign = visits(40);
  read_points(arm(), campaign);
  Robot wrong_tool = arm();
  wrong_tool.chain.tool.translation = {-0.2, 0.3, 0.5};
  const auto placement = place_base_and_tool(wrong_tool, campaign, 1e-3);
  ASSERT_TRUE(placement);
  expect_near(placement->base, kBase, 1e-6);
  EXPECT_LT((placement->targets.col(0) - arm().chain.tool.translation).norm(), 1e-6);
  for (int row = 0; row < campaign.rows(); ++row)
    EXPECT_NEAR(placement->miss[row], row % 3 == 0 ? 0.5 : 0, 1e-6);
}

// 6 + 3 unknowns and 9 equations to spare: 6 points are enough, 5 are not.
TEST(Placement, NeedsNineEquationsMoreThanUnknowns) {
  for (const int poses : {5, 6}) {
    Campaign campaign = visits(poses);
    read_points(arm(), campaign);
    EXPECT_EQ(place_base_and_tool(arm(), campaign, 1).has_value(), poses == 6);
  }
}

TEST(Placement, TurnsOfACubeAreThe24Rotations) {
  std::set<std::vector<int>> seen;
  for (const Eigen::Matrix3d& turn : turns_of_a_cube()) {
    EXPECT_EQ(turn.determinant(), 1);
    EXPECT_EQ(turn * turn.transpose(), Eigen::Matrix3d::Identity());
    std::vector<int> entries;
    for (const double entry : turn.reshaped()) entries.push_back(entry < 0 ? -1 : entry > 0);
    seen.insert(entries);
  }
  EXPECT_EQ(seen.size(), 24);
}

// Most lie about one rotation, evenly; the others all turn one way from it.
TEST(Placement, CommonTurnIsTheMiddleOfMost) {
  const Eigen::Matrix3d middle = rotation_exp({1, 2, -0.5});
  std::vector<Eigen::Matrix3d> turns;
  for (const double angle : {0.9, 1.0, 1.1, 1.2})
    turns.push_back(middle * rotation_exp({angle, 0, 0}));
  for (int axis = 0; axis < 3; ++axis)
    for (const double angle : {-0.02, 0.02})
      turns.push_back(middle * rotation_exp(angle * Eigen::Vector3d::Unit(axis)));
  const auto [found, angle] = common_turn(turns);
  EXPECT_LT(rotation_log(middle.transpose() * found).norm(), 1e-3);
  EXPECT_NEAR(angle, 0.02, 1e-3);
}

// A gauge below a ceiling shows more the lower the tool stands: the normal of the ceiling points
// down, whatever axis its file gives it.
TEST(Contacts, ThePlaneOfAGaugeFacesTheSideWhereItShowsMore) {
  constexpr double kCeiling = 2.5;
  Robot robot = arm();
  robot.chain.base = {Eigen::Matrix3d::Identity(), {0, 0, 0}};
  Contact ceiling;
  ceiling.name = "ceiling";
  ceiling.kind = ContactKind::plane;
  robot.chain.contacts = {ceiling};
  const ChainEvaluator evaluator(robot.chain);
  Campaign campaign = visits(12);
  campaign.contact_names = {"ceiling"};
  for (int row = 0; row < 12; ++row) {
    JointVector q(6);
    q << 0.5 * row, -1.2 + 2e-3 * (row % 3), 0.7, 0.9, 0.4, -0.3;  // about the vertical, nearly
    campaign.q[row] = q;
    campaign.distance.push_back(kCeiling - evaluator.pose(q).translation.z());
    campaign.touch.push_back({0, -1});
  }
  const Contact& found = with_contacts_fitted(robot, campaign, FitContacts::all).chain.contacts[0];
  EXPECT_LT((found.place.rotation.col(2) + Eigen::Vector3d::UnitZ()).norm(), 0.02);
  EXPECT_NEAR(found.place.translation.z(), kCeiling, 0.02);
}

}  // namespace
}  // namespace armtrue::registration_test
