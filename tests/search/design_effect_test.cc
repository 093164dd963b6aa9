// How many independent equations the readings of images are worth: all corners of an image share
// the error of the model at its pose, a motion of the camera, which has six numbers. KDL simulates
// the arm, OpenCV's equations the camera.

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/observation/observation.h"
#include "armtrue/statistics/random.h"
#include "imaging.h"
#include "search/linearization.h"
#include "support/temporary_file.h"

namespace armtrue::design_effect_test {
namespace {

constexpr int kImages = 30, kNumbersOfPose = 6;
const std::string kArm = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";

Robot robot_with_camera() {
  std::ostringstream text;
  text << std::ifstream(kArm).rdbuf()
       << "cameras: {eye: {on: arm, fx_px: 1200, fy_px: 1205, cx_px: 660, cy_px: 470}}\n"
          "boards: {plate: {on: cell, columns: 7, rows: 5, pitch_mm: 30}}\n";
  return parse_robot(text.str(), "robot.yaml");
}

std::string images() {
  armtrue_oracle::Eye eye;
  eye.place = KDL::Frame(KDL::Rotation::RPY(0.1, -0.2, 0.3), {0.05, -0.03, 0.08});
  armtrue_oracle::Grid grid;
  grid.place = KDL::Frame(KDL::Rotation::RPY(3.0, 0.1, 0.4), {1.9, 0.2, 0.8});
  armtrue_oracle::Dice dice(5);
  return armtrue_oracle::images_csv(armtrue_oracle::read_arm(kArm), {}, eye, grid,
                                    {.poses = kImages, .noise_px = 0.2}, dice);
}

// The equations that the readings are worth, where every pose stands beside its joint angles by
// normal errors [rad], and how many there are.
struct Worth {
  double independent, all;
};
Worth worth(double error_of_pose) {
  const Robot robot = robot_with_camera();
  Campaign campaign = read_campaign(TemporaryFile(images()).path).campaign;
  bind_touches(campaign, robot.chain);
  Random random(3);
  std::vector<JointVector> errors(kImages, JointVector::Zero(6));
  for (JointVector& error : errors)
    for (double& angle : error) angle = random.normal() * error_of_pose;
  for (int row = 0; row < campaign.rows(); ++row) campaign.q[row] += errors[campaign.pose[row]];
  const Linearization fit(calibrate(robot, campaign), campaign);
  return {fit.residual_freedom() + static_cast<double>(fit.basis().cols()),
          static_cast<double>(campaign.rows() * campaign.reading_size().all())};
}

TEST(DesignEffect, NoiseOfCornersIsIndependent) {
  const Worth found = worth(0);
  EXPECT_GT(found.independent, 0.9 * found.all);
}

TEST(DesignEffect, AnErrorOfThePoseIsWorthSixNumbersOfAnImage) {
  constexpr double kNumbers = kImages * kNumbersOfPose;
  const Worth found = worth(1e-3);
  EXPECT_NEAR(found.independent, kNumbers, 0.1 * kNumbers);
  EXPECT_GT(found.all, 10 * kNumbers);
}

}  // namespace
}  // namespace armtrue::design_effect_test
