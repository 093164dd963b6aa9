#pragma once

#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/search/trace.h"

namespace armtrue {

/// Rows of held-out readings between the last training reading before a found step in time and the
/// first one after it. No training reading says on which side of the step they were taken, so what
/// the model predicts there is arbitrary. Ascending.
std::vector<int> rows_at_steps(const TraceResult& trace, const Campaign& training,
                               const Campaign& held_out);

}  // namespace armtrue
