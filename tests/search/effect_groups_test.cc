#include "armtrue/search/effect_groups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <string>

#include "armtrue/io/robot_io.h"

namespace armtrue {
namespace {

// Sixty random poses of the arm, all at nearly one temperature.
Campaign random_poses(const Robot& robot) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angle(-2, 2), air(20, 20.02);
  Campaign campaign;
  campaign.temperature_names = {"air"};
  for (int pose = 0; pose < 60; ++pose) {
    campaign.pose.push_back(pose);
    campaign.pose_ids.push_back(std::to_string(pose));
    JointVector q(joint_count(robot.chain));
    for (double& value : q) value = angle(random);
    campaign.q.push_back(q);
    campaign.position.emplace_back(Eigen::Vector3d::Zero());
    campaign.temperature_c.push_back({air(random)});
  }
  return campaign;
}

// Usual size of the coefficient of each effect of a group, by parameter.
std::map<std::string, double> usual_sizes(const Robot& robot, const std::string& group) {
  std::map<std::string, double> sizes;
  for (const EffectGroup& each : effect_groups(robot, random_poses(robot)))
    if (each.name == group)
      for (const RandomEffect& random : each.effects)
        sizes[to_string(random.effect.parameter)] = random.root.norm();
  return sizes;
}

// The masses of the iiwa's last link lie on its axis, so that gravity does not turn it.
TEST(EffectGroups, GravityThatTurnsNoJointHasNoCoefficient) {
  const auto sizes = usual_sizes(read_robot(ARMTRUE_CONFIG "/robots/iiwa14.yaml").robot, "gravity");
  EXPECT_TRUE(sizes.contains("A6.theta"));
  EXPECT_FALSE(sizes.contains("A7.theta"));
}

// A millimetre beside the axis, the flange turns it by some 3 mN m. A compliance that such a torque
// had to show would turn the joint by degrees under a payload of 5 kg.
TEST(EffectGroups, ASmallTorqueDoesNotTellTheSizeOfACompliance) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/iiwa14.yaml").robot;
  for (Body& body : robot.bodies)
    if (robot.chain.links[body.link].name == "A7") body.centre.x() += 1e-3;
  const auto sizes = usual_sizes(robot, "gravity");
  double stiffest = sizes.at("A7.theta");
  for (const auto& [parameter, size] : sizes) stiffest = std::min(stiffest, size);
  EXPECT_NEAR(sizes.at("A7.theta"), 100 * stiffest, 0.01 * stiffest);
  const double torque = 5 * 9.81 * 0.05;  // N m
  EXPECT_LT(sizes.at("A7.theta") * torque, 2e-3);
}

// 20 mK of a sensor's noise do not tell how much a link grows in a kelvin: 30 um at most.
TEST(EffectGroups, AnEvenTemperatureDoesNotTellTheSizeOfAGrowth) {
  const auto sizes =
      usual_sizes(read_robot(ARMTRUE_CONFIG "/robots/iiwa14.yaml").robot, "temperature");
  ASSERT_TRUE(sizes.contains("A3.r"));
  for (const auto& [parameter, size] : sizes) EXPECT_LE(size, 3.1e-5) << parameter;
}

}  // namespace
}  // namespace armtrue
