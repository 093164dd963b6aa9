#pragma once

#include <string>
#include <vector>

#include "armtrue/tracing/loop.h"

namespace armtrue {

/// One HTML page of what close_loop found, complete in itself: verdict, the held-out error stage by
/// stage and its distribution before and after, and every effect with its curve. `descriptions`
/// holds one sentence for each effect. Plots come from gnuplot; throws std::runtime_error if it
/// cannot be run.
std::string loop_report(const LoopResult& result, const std::vector<std::string>& descriptions,
                        const std::string& title);

}  // namespace armtrue
