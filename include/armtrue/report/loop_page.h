#pragma once

#include <string>

#include "armtrue/report/report.h"
#include "armtrue/tracing/loop.h"

namespace armtrue {

/// The page of a loop: verdict, error before and after, causes by share, what to measure next,
/// distribution, axes, course and map of the errors on the held-out poses, stages. `nominal`,
/// `training` and `held_out`: the arguments of close_loop(); `next_poses` names a file, or is
/// empty. The keys are those of armtrue-loop/1.
Report loop_page(const LoopResult& result, const Robot& nominal, const Campaign& training,
                 const Campaign& held_out, const std::string& next_poses, const PageHead& head);

}  // namespace armtrue
