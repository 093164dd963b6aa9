// The library in four steps, as another project uses it: read a robot, calibrate it, close the
// loop, correct a point.
//
//     examples ROBOT CAMPAIGN CATALOGUE      such as share/armtrue/robots/kr360-spindle.yaml
//                                            share/armtrue/campaigns/tutorial.csv
//                                            share/armtrue/effects/catalogue.yaml
#include <cstdio>
#include <exception>
#include <numbers>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/split.h"
#include "armtrue/compensation/compensation.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/tracing/loop.h"

namespace {

constexpr double kMillimetres = 1e3;
constexpr double kRadians = std::numbers::pi / 180;

// Where the last frame of the arm stands in the axes of its foot; metres and radians, as
// everywhere.
armtrue::Pose pose_at_zero(const armtrue::Robot& robot) {
  const armtrue::ChainEvaluator chain(robot.chain);
  return chain.pose(armtrue::JointVector::Zero(6));
}

// The joint angles at which the calibrated arm reaches the pose that the controller's model has at
// `q`.
armtrue::CorrectedTarget corrected(const armtrue::Robot& calibrated,
                                   const armtrue::Robot& controller,
                                   const armtrue::JointVector& q) {
  armtrue::Program program;
  program.visits.pose_ids = {"P1"};
  program.visits.pose = {0};
  program.visits.line = {0};  // of no file
  program.visits.q.push_back(q);
  return armtrue::compensate(calibrated, controller, program, {}).front();
}

int walk(const std::string& robot_file, const std::string& campaign_file,
         const std::string& catalogue_file) {
  const armtrue::Robot nominal = armtrue::read_robot(robot_file).robot;
  std::printf("read: flange %.3f mm from the foot\n",
              kMillimetres * pose_at_zero(nominal).translation.norm());

  const armtrue::Campaign campaign = armtrue::read_campaign(campaign_file, nominal.chain).campaign;
  const armtrue::CalibrationResult calibration = armtrue::calibrate(nominal, campaign);
  std::printf("calibrate: %zu unknowns\n", calibration.names.size());

  // The held-out poses take no part in any fit.
  const armtrue::Split split = armtrue::split_by_pose(campaign, 0.25, 1);
  const armtrue::LoopResult loop =
      armtrue::close_loop(nominal, campaign.select(split.training), campaign.select(split.held_out),
                          armtrue::read_catalogue(catalogue_file));
  for (const armtrue::TracedEffect& traced : loop.trace.effects)
    std::printf("close the loop: %s\n", armtrue::describe(traced.effect).c_str());
  std::printf("close the loop: held-out error %.3f mm, floor %.3f mm\n", kMillimetres * loop.after,
              kMillimetres * loop.floor);

  armtrue::JointVector q(6);
  q << 10, -60, 80, 5, 40, -10;
  const armtrue::CorrectedTarget target =
      corrected(armtrue::result_of(loop).robot, nominal, q * kRadians);
  std::printf("correct a point: %.3f mm before, %.3f mm after\n",
              kMillimetres * target.before.position, kMillimetres * target.after.position);
  return target.is_corrected && loop.after < 2 * loop.floor ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  try {
    return walk(argv[1], argv[2], argv[3]);
  } catch (const std::exception& error) {  // names file, line and remedy
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
