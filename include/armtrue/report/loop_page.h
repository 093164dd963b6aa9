#pragma once

#include <optional>
#include <string>

#include "armtrue/report/report.h"
#include "armtrue/tracing/loop.h"

namespace armtrue {

/// The page of a loop: verdict, error before and after, causes by share, what to measure next,
/// distribution, axes, course and map of the errors on the held-out poses, stages. `nominal`,
/// `training` and `held_out`: the arguments of close_loop(); `to_all`: the result fitted to all
/// poses, if a product holds it. The keys are those of armtrue-loop/1.
Report loop_page(const LoopResult& result, const std::optional<FitToAll>& to_all,
                 const Robot& nominal, const Campaign& training, const Campaign& held_out,
                 const PageHead& head);

}  // namespace armtrue
