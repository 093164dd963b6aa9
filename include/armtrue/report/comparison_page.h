#pragma once

#include <string>
#include <vector>

#include "armtrue/diagnosis/run_comparison.h"
#include "armtrue/report/report.h"

namespace armtrue {

/// The page of a comparison of two runs: what changed, the changes of the parameters with their
/// intervals about zero, effects, curves without a name, error and verdict of both. `robot`: its
/// name. The keys are those of armtrue-comparison/1.
Report comparison_page(const RunComparison& found, const std::string& robot, const PageHead& head);

/// Notes and changes, for a terminal.
std::string comparison_table(const RunComparison& found, const std::vector<std::string>& notes);

}  // namespace armtrue
