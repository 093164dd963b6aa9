// Names of targets that are exchanged in a part of the readings, and arms whose gravity is not that
// of the robot file: KDL simulates the readings.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "armtrue/diagnosis/diagnosis.h"
#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/robot_io.h"
#include "oracle.h"
#include "support/temporary_file.h"
#include "touching.h"

namespace armtrue::exchanged_targets_test {
namespace {

using armtrue_oracle::Dice;
using armtrue_oracle::OracleArm;
using armtrue_oracle::random_joints;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const std::string kArm = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";
constexpr double kDeg = 3.14159265358979323846 / 180;

std::string joints_in_words(const std::array<double, 6>& q) {
  std::string text;
  for (const double angle : q) text += fmt::format(",{:.12g}", angle / kDeg);
  return text;
}

std::string point_in_words(const KDL::Vector& point, Dice& dice) {
  std::string text;
  for (int i = 0; i < 3; ++i) text += fmt::format(",{:.6f}", 1e3 * point[i] + 0.05 * dice.normal());
  return text;
}

const std::vector<KDL::Vector> kTargets{{0.1, 0, 0}, {-0.05, 0.08, 0.01}, {-0.05, -0.08, 0.03}};

// Three targets at each of 40 poses; `named`: what a target is called at a pose.
Campaign of_three_targets(unsigned seed, const std::function<size_t(int pose, size_t)>& named) {
  Dice dice(seed);
  const OracleArm arm =
      armtrue_oracle::with_errors(armtrue_oracle::read_arm(kArm), 3e-4, 3e-4, -1, dice);
  std::string text = "pose,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,target,x_mm,y_mm,z_mm\n";
  for (int pose = 0; pose < 40; ++pose) {
    const auto q = random_joints(arm, dice);
    for (size_t target = 0; target < 3; ++target)
      text += fmt::format("{}{},t{}{}\n", pose + 1, joints_in_words(q), named(pose, target),
                          point_in_words(armtrue_oracle::forward(arm, q) * kTargets[target], dice));
  }
  return read_campaign(TemporaryFile(text).path).campaign;
}

Robot robot_of_targets() {
  Robot robot = read_robot(kArm).robot;
  for (size_t k = 0; k < kTargets.size(); ++k)
    robot.chain.targets.push_back(
        {fmt::format("t{}", k), {kTargets[k].x(), kTargets[k].y(), kTargets[k].z()}});
  return robot;
}

size_t exchanged(size_t target) { return target == 2 ? 2 : 1 - target; }

TEST(ExchangedTargets, AreNamedFromTheLineOn) {
  const Campaign half = of_three_targets(
      1, [](int pose, size_t target) { return pose < 20 ? target : exchanged(target); });
  EXPECT_THAT(diagnose(robot_of_targets(), half),
              ElementsAre(HasSubstr("the targets 't0' and 't1' look exchanged in 40 of 80 "
                                    "readings, from line 62 on")));
  const Campaign third = of_three_targets(
      2, [](int pose, size_t target) { return pose < 27 ? target : exchanged(target); });
  EXPECT_THAT(diagnose(robot_of_targets(), third),
              ElementsAre(HasSubstr("look exchanged in 26 of 80 readings, from line 83 on")));
}

TEST(ExchangedTargets, AreNamedInSomePoses) {
  const Campaign some = of_three_targets(
      3, [](int pose, size_t target) { return pose % 4 == 1 ? exchanged(target) : target; });
  EXPECT_THAT(diagnose(robot_of_targets(), some),
              ElementsAre(HasSubstr("look exchanged in 20 of 80 readings, the first in line 5")));
}

TEST(ExchangedTargets, RightNamesAreNotSuspected) {
  for (unsigned seed = 1; seed <= 10; ++seed)
    EXPECT_THAT(diagnose(robot_of_targets(),
                         of_three_targets(seed, [](int, size_t target) { return target; })),
                IsEmpty())
        << seed;
}

// Points of an arm whose joints 2 and 3 give way under this gravity.
Campaign of_sagging_arm(unsigned seed, const KDL::Vector& gravity, double compliance,
                        double cycle = 0, double wobble = 0) {
  Dice dice(seed);
  OracleArm arm = armtrue_oracle::with_errors(armtrue_oracle::read_arm(kArm), 2e-4, 2e-4, -1, dice);
  arm.gravity = gravity;
  std::string text = "pose,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,x_mm,y_mm,z_mm\n";
  for (int pose = 0; pose < 60; ++pose) {
    const auto q = random_joints(arm, dice);
    const armtrue_oracle::Moment moment = armtrue_oracle::moment_of(arm, q);
    OracleArm there = arm;
    there.links[1].theta += compliance * moment.torque[1];
    there.links[2].theta += compliance * moment.torque[2];
    there.links[0].theta += cycle * std::sin(q[0] + 0.3);
    there.links[4].alpha += wobble * std::cos(q[3] + 0.5);
    text += fmt::format(
        "{}{}{}\n", pose + 1, joints_in_words(q),
        point_in_words(armtrue_oracle::forward(there, q) * KDL::Vector(0.1, 0.05, 0.2), dice));
  }
  return read_campaign(TemporaryFile(text).path).campaign;
}

TEST(GravityDirection, AnArmOnAWallIsNamed) {
  Robot robot = read_robot(kArm).robot;
  for (const unsigned seed : {1, 2, 3}) {
    const Campaign wall = of_sagging_arm(seed, {9.81, 0, 0}, 2e-7);
    EXPECT_THAT(find_suspicions(robot, wall).warnings,
                ElementsAre(HasSubstr("the sags of the joints fit gravity along (1.00,")))
        << seed;
    robot.gravity = {9.81, 0, 0};
    EXPECT_THAT(find_suspicions(robot, wall).warnings, IsEmpty()) << seed;
    robot.gravity = {0, 0, -9.81};
  }
}

TEST(GravityDirection, WithoutMassesItIsNamedToo) {
  Robot robot = read_robot(kArm).robot;
  robot.bodies.clear();
  const KDL::Vector tilted(9.81 * std::sin(50 * kDeg), 0, -9.81 * std::cos(50 * kDeg));
  EXPECT_THAT(find_suspicions(robot, of_sagging_arm(4, tilted, 2e-7)).warnings,
              Contains(HasSubstr("the sags of the joints fit gravity along")));
}

TEST(GravityDirection, RightArmsAreNotSuspected) {
  const Robot robot = read_robot(kArm).robot;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    EXPECT_THAT(find_suspicions(robot, of_sagging_arm(seed, {0, 0, -9.81}, 2e-7)).warnings,
                Not(Contains(HasSubstr("fit gravity along"))))
        << seed;
    EXPECT_THAT(find_suspicions(robot, of_sagging_arm(seed, {0, 0, -9.81}, 0, 4e-4)).warnings,
                Not(Contains(HasSubstr("fit gravity along"))))
        << seed;
    EXPECT_THAT(find_suspicions(robot, of_sagging_arm(seed, {0, 0, -9.81}, 0, 0, 1e-3)).warnings,
                Not(Contains(HasSubstr("fit gravity along"))))
        << seed;
  }
}

}  // namespace
}  // namespace armtrue::exchanged_targets_test
