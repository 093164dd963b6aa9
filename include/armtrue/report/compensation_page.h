#pragma once

#include <optional>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/compensation/move_division.h"
#include "armtrue/compensation/prediction_conditions.h"
#include "armtrue/report/report.h"

namespace armtrue {

/// The page of a compensation: predicted error before and after, along the rows and as a map of the
/// corrections, notes, the worst three targets, and the conditions for which the commands are
/// valid; of divided moves the error between their points, and the corrections of the inserted
/// ones. The keys are those of armtrue-compensation/1.
Report compensation_page(const std::vector<CorrectedTarget>& targets, const Program& program,
                         const std::optional<BetweenPoints>& between,
                         const PredictionConditions& conditions, const PageHead& head);

}  // namespace armtrue
