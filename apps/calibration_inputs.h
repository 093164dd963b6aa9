#pragma once

#include <string>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"
#include "command_line.h"
#include "report_arguments.h"

namespace armtrue::app {

/// What calibrate is asked for.
struct CalibrationArguments {
  std::string robot, identify, identify_per_session, residuals, zone, parameters, correlations;
  double max_error_mm = 0;  ///< 0: no limit
  bool no_priors = false;
  ReportArguments page;
};

void add_calibration_options(Command& command, CalibrationArguments& arguments);

/// The robot of the file, with what the options say of its fit.
Robot robot_to_calibrate(Command& command, const CalibrationArguments& arguments);

/// The measured poses. Throws InputError for a mistake in them.
Campaign campaign_to_fit(Command& command, const CalibrationArguments& arguments,
                         const Robot& robot);

}  // namespace armtrue::app
