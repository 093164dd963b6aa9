#include "armtrue/calibration/hold_out.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>
#include <string>

#include "armtrue/calibration/identifiability.h"
#include "armtrue/io/robot_io.h"

namespace armtrue::hold_out_test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Poses over the travel, `repeats` rows each; session k has the poses k, k + sessions, ...
Campaign poses(int count, int repeats, int sessions, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> angle(-1, 1);
  Campaign campaign;
  for (int p = 0; p < count; ++p) {
    campaign.pose_ids.push_back(std::to_string(p));
    const JointVector q = JointVector::NullaryExpr(6, [&] { return angle(random); });
    for (int r = 0; r < repeats; ++r) {
      campaign.pose.push_back(p);
      campaign.q.push_back(q);
      if (sessions > 1) campaign.session.push_back(p % sessions);
    }
  }
  for (int s = 0; s < sessions; ++s) campaign.session_names.push_back(std::to_string(s));
  if (sessions == 1) campaign.session_names.clear();
  return campaign;
}

Campaign of_points(Campaign campaign) {
  campaign.position.resize(campaign.rows(), Eigen::Vector3d(1, 0, 1));
  return campaign;
}

Robot kr360() { return read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot; }

TEST(HoldOut, IsAQuarterWhereTheOthersShowAsMuch) {
  const Campaign campaign = of_points(poses(60, 2, 1, 1));
  const HeldOut held_out = hold_out(kr360(), campaign, {});
  EXPECT_EQ(held_out.split.held_out.size(), 30u);
  EXPECT_THAT(held_out.fewer, IsEmpty());
}

// Who asks for more gets it while there are two equations for each unknown: 24 poses give 72.
TEST(HoldOut, IsWhatWasAskedForWhileEquationsAreTwiceTheUnknowns) {
  const Campaign campaign = of_points(poses(60, 1, 1, 1));
  EXPECT_EQ(hold_out(kr360(), campaign, {.share = 0.6}).split.held_out.size(), 36u);
  EXPECT_EQ(hold_out(kr360(), campaign, {.share = 0.8}).split.held_out.size(), 24u);
}

// A draw-wire reads one number at a pose: 34 poses give hardly more than the unknowns of the arm,
// and each pose that is held out takes an equation away. A repeat gives none.
TEST(HoldOut, TakesNoPosesThatTheUnknownsNeed) {
  Robot robot = kr360();
  robot.chain.anchors = {{"wire", {2.5, 1.5, 0.1}}};
  for (const int repeats : {1, 3}) {
    Campaign campaign = poses(34, repeats, 1, 1);
    campaign.distance.resize(campaign.rows(), 2.0);
    campaign.anchor.resize(campaign.rows(), 0);
    campaign.anchor_names = {"wire"};
    const size_t all = choose_identifiable(robot, campaign).kept.size();
    const HeldOut held_out = hold_out(robot, campaign, {});
    const Campaign training = campaign.select(held_out.split.training);
    const int freedom = 34 - static_cast<int>(all);
    EXPECT_GT(training.poses(), 26) << repeats;
    EXPECT_GE(3 * (training.poses() - static_cast<int>(all)), freedom) << repeats;
    EXPECT_EQ(choose_identifiable(robot, training).kept.size(), all) << repeats;
    EXPECT_THAT(held_out.fewer, HasSubstr("measure more poses")) << repeats;
  }
}

// Five set-ups with five poses each: 75 equations for some 55 unknowns, 24 of which are bases.
TEST(HoldOut, LeavesEachSessionItsPlace) {
  const Campaign campaign = of_points(poses(25, 2, 5, 3));
  const Robot robot = kr360();
  const size_t all = choose_identifiable(robot, campaign).kept.size();
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const HeldOut held_out = hold_out(robot, campaign, {.seed = seed});
    EXPECT_FALSE(held_out.split.held_out.empty()) << seed;
    std::map<int, std::set<int>> left;
    for (int row : held_out.split.training) left[campaign.session[row]].insert(campaign.pose[row]);
    for (const auto& [session, own] : left) EXPECT_GE(own.size(), 3u) << seed << ' ' << session;
    const Campaign training = campaign.select(held_out.split.training);
    EXPECT_EQ(choose_identifiable(robot, training).kept.size(), all) << seed;
    EXPECT_GT(3 * training.poses(), static_cast<int>(all) + 24) << seed;
  }
}

}  // namespace
}  // namespace armtrue::hold_out_test
