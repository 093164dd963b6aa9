#include "armtrue/diagnosis/other_arm.h"

#include "armtrue/observation/placement.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/diagnosis/diagnosis.h"
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

}  // namespace armtrue
