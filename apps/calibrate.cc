#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/io/output.h"
#include "armtrue/io/report_io.h"
#include "armtrue/kinematics/units.h"
#include "command_line.h"

using namespace armtrue;

namespace {

// The weights of weight_by_zone() tell of each reading how far outside the zone it lies.
WeightedZone weight_readings_by_zone(const app::Command& command, Campaign& campaign,
                                     const Robot& robot, const Zone& zone) {
  Campaign weighed = campaign;
  weighed.sigma_position.assign(static_cast<size_t>(campaign.rows()), 1.0);
  weight_by_zone(weighed, robot, zone);
  const std::vector<double>& factors = weighed.sigma_position;
  const double least = *std::ranges::min_element(factors);
  const double outside = zone.radius * std::sqrt(least * least - 1);
  if (outside > zone.radius)
    command.warn(fmt::format(
        "no reading lies in the zone or near it, the nearest {:.4g} mm outside: what the robot "
        "will do there is extrapolated; measure poses in it (plan-poses --zone), or correct "
        "--zone, which is x,y,z,radius in mm in the instrument's frame",
        outside / kMillimetre));
  weight_by_zone(campaign, robot, zone);
  return {zone, static_cast<int>(std::ranges::count(factors, 1.0))};
}

int work(app::Command& command, const std::string& robot_path, const std::string& identify,
         const std::string& per_session, const std::string& residuals_path, const std::string& zone,
         double max_error_mm) {
  Robot robot = command.robot(robot_path).robot;
  if (!identify.empty()) robot.identify = app::split_list(identify);
  if (!per_session.empty()) robot.identify_per_session = app::split_list(per_session);
  Campaign campaign = command.campaign(command.input, robot);
  std::optional<WeightedZone> weighted_zone;
  if (!zone.empty())
    weighted_zone = weight_readings_by_zone(command, campaign, robot, app::zone(zone));
  command.progress("identifying");
  const CalibrationResult result = calibrate(robot, campaign);
  if (!residuals_path.empty()) {
    const std::vector<std::string> split(campaign.rows(), "training");
    write_output(residuals_path,
                 write_residuals({{campaign, evaluate(result.robot, campaign).residuals, split}}));
  }
  write_output(command.output,
               write_calibration(result, campaign, command.provenance(), weighted_zone));

  if (!result.converged) {
    command.warn(app::not_converged(result));
    return app::kNotReached;
  }
  if (const auto lost = lost_to_poses(robot, campaign, result.set); !lost.empty()) {
    std::string names;
    for (int k : lost) names += (names.empty() ? "" : ", ") + parameter_name(robot.chain, k);
    command.warn("these poses cannot show " + names +
                 ", which other poses could; measure poses that move every joint over its travel");
    return app::kNotReached;
  }
  if (max_error_mm > 0) {
    const double worst = summarize(evaluate(result.robot, campaign).position).max / kMillimetre;
    if (worst > max_error_mm) {
      command.warn(
          fmt::format("the largest error, {:.4g} mm, is above {:g} mm", worst, max_error_mm));
      return app::kNotReached;
    }
  }
  return app::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("calibrate", "Identify the parameters of a robot from measured poses.",
                       "calibrate --robot robot.yaml measured.csv > calibrated.yaml\n"
                       "  calibrate --robot robot.yaml --new-session-at-s 1234 knocked.csv");
  std::string robot, identify, per_session, residuals, zone;
  double max_error_mm = 0;
  command.add_input("Measured poses");
  command.add_output();
  command.options().add_option("--robot", robot, "The nominal robot")->required();
  command.options().add_option("--identify", identify,
                               "auto, paper-25, or a list such as A1.alpha,A2.d,base,tool.z; "
                               "replaces 'identify' of the robot file");
  command.options().add_option("--identify-per-session", per_session,
                               "Zero offsets that each session has for itself beside its base, "
                               "such as A2.theta,A5.theta after a re-mastering; replaces "
                               "'identify_per_session' of the robot file");
  command.add_new_sessions();
  command.add_output("--residuals", residuals, "Write the residual of every reading here");
  app::add_zone(
      command.options(), zone,
      "Sphere x,y,z,radius in R_A in which the arm shall be accurate: readings count less "
      "the farther outside they lie");
  command.options()
      .add_option("--max-error-mm", max_error_mm,
                  "Exit with 3 if calibration: training: position_mm: max, the largest error of "
                  "the readings, is larger")
      ->check(app::above_zero());
  return command.run(argc, argv, [&] {
    return work(command, robot, identify, per_session, residuals, zone, max_error_mm);
  });
}
