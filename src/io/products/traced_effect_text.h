#pragma once

#include <vector>

#include "armtrue/tracing/loop.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {

/// An entry of `effects` in a ranking or loop document. `gain` may be null, `curve` may be empty.
YAML::Node traced_node(const TracedEffect& traced, const HeldOutGain* gain,
                       const std::vector<CurvePoint>& curve, const Robot& robot);

/// The list `not_separable` of a ranking or loop document.
YAML::Node not_separable_node(const std::vector<RankedCandidate>& candidates);

}  // namespace armtrue
