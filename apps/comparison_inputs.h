#pragma once

#include <optional>
#include <string>

#include "command_line.h"
#include "report_arguments.h"

namespace armtrue::app {

/// What compare-runs is asked for.
struct ComparisonArguments {
  std::string before, loop_before, loop, poses;
  ReportArguments page;
  std::optional<double> max_change_mm;
  bool require_unchanged = false;
  bool two_arms = false;  ///< of one type, not one arm at two times
};

void add_comparison_options(Command& command, ComparisonArguments& arguments);

}  // namespace armtrue::app
