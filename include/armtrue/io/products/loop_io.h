#pragma once

#include <string>

#include "armtrue/io/document.h"
#include "armtrue/io/provenance.h"
#include "armtrue/tracing/loop.h"

namespace armtrue {

/// armtrue-loop/1. `next_poses` names the file of the next poses; "" if there is none.
Document write_loop(const LoopResult& result, const TraceOptions& options,
                    const Provenance& provenance, const std::string& next_poses);

}  // namespace armtrue
