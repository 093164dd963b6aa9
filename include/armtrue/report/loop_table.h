#pragma once

#include <string>

#include "armtrue/tracing/loop.h"

namespace armtrue {

/// The stages of a loop, the held-out errors and the shares of the effects, for a terminal.
std::string before_after_table(const LoopResult& result);

}  // namespace armtrue
