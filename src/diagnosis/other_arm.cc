#include "armtrue/diagnosis/other_arm.h"

#include <algorithm>
#include <optional>

#include "armtrue/campaign/simulation.h"
#include "armtrue/diagnosis/diagnosis.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/observation/placement.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

// Measured at the origin of its tool, in every context.
Robot arm_alone(Robot robot) {
  robot.effects.clear();
  robot.chain.targets.clear();
  robot.chain.anchors.clear();
  return robot;
}

}  // namespace

double distance_between_arms(const Robot& robot, const Robot& other) {
  constexpr int kPoses = 100;
  if (robot.ground_link || other.ground_link) return 0;
  SimulationOptions options;
  options.poses = kPoses;
  options.orientation = false;
  const Campaign points = simulate(robot, arm_alone(other), options);
  const auto placed = place_base_and_tool(arm_alone(robot), points, kImplausibleMiss);
  return placed ? median(placed->miss) : 0;
}

std::optional<double> placed_miss(const Robot& arm, const Campaign& campaign) {
  Robot plain = arm;
  plain.effects.clear();
  const auto placed = place_base_and_tool(plain, campaign, kImplausibleMiss);
  return placed ? std::optional(median(placed->miss)) : std::nullopt;
}

bool may_be_another_arm(const Robot& robot, const Campaign& campaign) {
  constexpr double kMissOfRightArm = 3e-3;  // m: nominal files of the right arm are rarely as far
  return placed_miss(robot, campaign).value_or(0) > kMissOfRightArm;
}

FittingArm arm_that_fits(const std::vector<Robot>& arms, const Robot& robot,
                         const Campaign& campaign) {
  constexpr double kShare = 0.25;  // files of one arm differ less
  FittingArm best;
  const auto own = placed_miss(robot, campaign);
  if (!own) return best;
  best.miss = std::min(kImplausibleMiss, kShare * *own);
  for (int k = 0; k < std::ssize(arms); ++k) {
    if (encoder_columns(arms[k].chain) != encoder_columns(robot.chain)) continue;
    Robot arm = arms[k];
    arm.chain.targets = robot.chain.targets;
    const auto miss = placed_miss(arm, campaign);
    if (miss && *miss < best.miss) best = {k, *miss};
  }
  return best;
}

}  // namespace armtrue
