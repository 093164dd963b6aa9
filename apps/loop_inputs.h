#pragma once

#include <string>

#include "armtrue/campaign/campaign.h"
#include "armtrue/campaign/split.h"
#include "command_line.h"
#include "report_arguments.h"

namespace armtrue::app {

/// What close-loop is asked for.
struct LoopArguments {
  std::string robot, identify, catalogue, test, robot_out, predictor_out, residuals, next_poses,
      parameters, correlations;
  ReportArguments page;
  double held_out = 0.25;
  int nested_folds = 0;  ///< 0: no nested validation
  bool only_catalogue = false, no_priors = false, held_out_region = false;

  /// Whether a product holds the result, fitted to all poses.
  bool wants_fit() const;
  /// Whether a product needs the poses of both parts again, after they were split.
  bool uses_all_poses() const;
};

void add_loop_options(Command& command, LoopArguments& arguments);

/// The measured poses: those that the search may use and the held-out ones.
struct MeasuredLoop {
  Campaign all;  ///< of the file that is searched; empty if nobody asks for it after the split
  Split split;   ///< of `all`; empty with --test
  Campaign training, held_out;
};

/// Throws InputError for a mistake in them, or a reading that stands in both parts.
MeasuredLoop read_measured_loop(Command& command, const LoopArguments& arguments,
                                const Robot& robot);

}  // namespace armtrue::app
