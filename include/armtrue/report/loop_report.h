#pragma once

#include <string>

#include "armtrue/tracing/loop.h"

namespace armtrue {

/// One HTML page on a loop, complete in itself: the verdict, the held-out error of each stage, its
/// distribution before and after, and each effect with its sentence and its curve. Throws
/// std::runtime_error if gnuplot, which draws the plots, cannot be run.
std::string loop_report(const LoopResult& result, const std::string& title);

}  // namespace armtrue
