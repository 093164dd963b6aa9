#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/split.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/tracing/loop.h"
#include "tracing/hidden_campaign.h"

namespace armtrue::carried_test {
namespace {

const std::string kNominal = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";
const std::string kCatalogue = ARMTRUE_CONFIG "/effects/catalogue.yaml";

// Carried to another set-up of the same arm: base and tool are fitted anew, links and effects kept.
TEST(Carried, TheClosedRobotBeatsGeometryAlone) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 61;
  const HiddenCampaign campaign(kNominal, "compliance", 0.12, plan);
  const LoopResult result = close_loop(read_robot(kNominal).robot, campaign.training,
                                       campaign.held_out, read_catalogue(kCatalogue));
  const KinematicChain& chain = result.trace.fit.robot.chain;
  const Pose moved{rotation_exp({0.3, -0.2, 1.1}), {0.8, -2.0, 0.4}};
  Campaign elsewhere = campaign.held_out;
  for (int row = 0; row < elsewhere.rows(); ++row) {
    elsewhere.position[row] = moved * elsewhere.position[row];
    elsewhere.orientation[row] = Eigen::Quaterniond(moved.rotation) * elsewhere.orientation[row];
  }
  ASSERT_GT((chain.base.translation - moved.translation).norm(), 1);  // the old base is of no use
  const auto carried = [&](const Robot& robot) {
    return summarize(evaluate(refit_set_up(robot, elsewhere, {"base", "tool"}), elsewhere).position)
        .mean;
  };
  const double nominal = carried(read_robot(kNominal).robot);
  const double geometric = carried(result.trace.stages.front().robot);
  const double with_effect = carried(result.trace.fit.robot);
  EXPECT_LT(geometric, 0.6 * nominal);
  EXPECT_LT(with_effect, 0.9 * geometric);
  EXPECT_LT(with_effect, 1.05 * campaign.written.floor_mean_mm * kMillimetre);
}

// Measured in a part of the travel, used over all of it. The axis of joint 2 wobbles, 3 and 11.7
// times per turn, which a part of 57 degrees shows as a curve.
TEST(Carried, FromAPartOfTheTravelACurveMakesNoArmWorse) {
  const Robot nominal = read_robot(kNominal).robot;
  const Catalogue catalogue = read_catalogue(kCatalogue);
  const auto wobbles = [](const armtrue_oracle::Moment& moment, armtrue_oracle::OracleArm& arm) {
    arm.links[2].alpha += 0.5e-3 * (std::cos(3 * moment.q[1] + 1) + std::cos(11.7 * moment.q[1]));
  };
  double all_geometric = 0, all_closed = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    armtrue_oracle::Dice dice(seed);
    const std::array<double, 6> middle{0.2, -1.6, 1.7, 0.3, 1.0, -0.4};
    std::vector<std::array<double, 6>> part(50, middle);
    for (auto& q : part)
      for (double& angle : q) angle += dice.uniform(-0.5, 0.5);
    const Campaign campaign = visits(kNominal, wobbles, part, seed);
    const Campaign travel = visits(kNominal, wobbles, 60, seed);
    const Split split = split_by_pose(campaign, 0.25, seed);
    const LoopResult result = close_loop(nominal, campaign.select(split.training),
                                         campaign.select(split.held_out), catalogue);
    const auto mean_over_travel = [&](const Robot& robot) {
      return summarize(evaluate(robot, travel).position).mean;
    };
    const double geometric = mean_over_travel(result.trace.stages.front().robot);
    const double closed = mean_over_travel(result.trace.fit.robot);
    EXPECT_LT(closed, geometric) << "seed " << seed;
    all_geometric += geometric;
    all_closed += closed;
  }
  EXPECT_LT(all_closed, 0.55 * all_geometric);
}

}  // namespace
}  // namespace armtrue::carried_test
