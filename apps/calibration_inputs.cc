#include "calibration_inputs.h"

#include <algorithm>
#include <vector>

#include "armtrue/diagnosis/stated_deviations.h"
#include "columns.h"
#include "option_text.h"

namespace armtrue::app {
namespace {

// Directions and ways of the joints, a fifth of a million readings, go once the readings have been
// checked, if no effect of the robot follows them.
void drop_unused_motion(const Robot& robot, Campaign& campaign) {
  const auto follows = [](const Effect& effect) {
    return effect.driver.involves(DriverKind::arrival) ||
           effect.driver.involves(DriverKind::stroke);
  };
  if (std::ranges::any_of(robot.effects, [&](const Effect& effect) {
        return follows(effect) || std::ranges::any_of(effect.members, follows);
      }))
    return;
  campaign.stroke.clear();
  campaign.arrival = std::vector<Direction>();
}

}  // namespace

void add_calibration_options(Command& command, CalibrationArguments& arguments) {
  command.add_input("Measured poses");
  command.add_output(ProductKind::document);
  command.file("--robot", arguments.robot, "The nominal robot").required();
  command.identify(arguments.identify);
  command.option(
      "--identify-per-session", arguments.identify_per_session,
      "Zero offsets that each session has of its own, like its base, such as A2.theta,A5.theta "
      "after a re-mastering; replaces 'identify_per_session' of the robot file");
  command.add_new_sessions();
  command.add_output("--residuals", arguments.residuals, "Write the residual of every reading here",
                     ProductKind::table);
  add_parameter_tables(command, arguments.parameters, arguments.correlations);
  command.zone(arguments.zone,
               "Sphere x,y,z,radius in R_A in which the arm must be accurate: the farther a "
               "reading is outside, the less it counts");
  command
      .option("--max-error-mm", arguments.max_error_mm,
              "Exit with 3 if calibration: training: position_mm: max, the largest error of "
              "the readings, is larger")
      .check(above_zero());
  command.flag("--no-priors", arguments.no_priors,
               "Least squares without priors: the readings alone determine the links");
  add_report(command, arguments.page, "with errors before and after, maps and parameters");
  command.add_columns(kMeasuredPoseColumns);
}

Robot robot_to_calibrate(Command& command, const CalibrationArguments& arguments) {
  Robot robot = command.read_robot(arguments.robot).robot;
  command.warn_if_calibrated(robot, arguments.robot);
  command.forget_remainder(robot, arguments.robot);
  use_identify(arguments.identify, robot);
  if (!arguments.identify_per_session.empty())
    robot.identify_per_session = split_list(arguments.identify_per_session);
  robot.free_links = arguments.no_priors;
  return robot;
}

Campaign campaign_to_fit(Command& command, const CalibrationArguments& arguments,
                         const Robot& robot) {
  Campaign campaign = command.read_campaign(command.input, robot);
  if (!arguments.identify_per_session.empty() && campaign.session_names.size() < 2)
    command.warn("--identify-per-session " + arguments.identify_per_session +
                 " changes nothing: " + campaign.source +
                 " is one session; name sessions in a column, or give --new-session-at-s");
  warn_of_all(command, {trust_usual_deviation(robot, campaign)});
  refuse_mistakes(command, robot, campaign);
  command.sensor_error.take_off(campaign, robot.chain);
  command.warn_if_needless(robot, campaign);
  drop_unused_motion(robot, campaign);
  return campaign;
}

}  // namespace armtrue::app
