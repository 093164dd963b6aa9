#pragma once

#include <string>

#include "armtrue/path/mirror/findings.h"

namespace armtrue {

/// Clocks, deviation, forecast, accuracy and force law of a mirror correction, for a terminal.
std::string mirror_table(const MirrorFindings& findings);

}  // namespace armtrue
