#pragma once

#include <string>

#include "armtrue/planning/planning.h"
#include "armtrue/planning/separation.h"

namespace armtrue {

/// Observability and expected errors of a plan beside those of random poses, for a terminal.
std::string plan_table(const PlanQuality& planned, const PlanQuality& random, bool with_zone);

/// The power with which a plan separates each pair of effects, for a terminal: with the given poses
/// alone, with the planned poses added, and with random poses added.
std::string power_table(const SeparationPlan& plan);

}  // namespace armtrue
