#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/planning/planning.h"
#include "command_line.h"
#include "reading_inputs.h"

namespace armtrue::app {

/// What plan-poses is asked for.
struct PlanArguments {
  std::string robot, identify, given, separate, zone;
  int count = 0;
  std::vector<double> box_mm;
  std::optional<double> floor_mm;
  ReadingArguments readings;
};

void add_plan_options(Command& command, PlanArguments& arguments);

PlanOptions plan_options(const Command& command, const PlanArguments& arguments);

/// --given; empty without it. Throws InputError for a mistake in it.
Campaign poses_to_complement(Command& command, const PlanArguments& arguments, const Robot& robot);

/// Warns where the robot file has contacts or cameras and the plan is for points. Throws InputError
/// for touches without contacts.
void warn_of_other_readings(Command& command, const PlanArguments& arguments, const Robot& robot,
                            const Campaign& given);

}  // namespace armtrue::app
