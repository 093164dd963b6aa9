#pragma once

#include <vector>

#include "armtrue/kinematics/parameters.h"
#include "armtrue/tracing/loop.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {

/// Adds the points of a curve: driver and value, in these units.
void add_driver_and_value(const std::vector<CurvePoint>& curve, const DisplayUnit& driver,
                          const DisplayUnit& value, YAML::Node& node);
/// Adds half of their 95 % intervals.
void add_half_width(const std::vector<CurvePoint>& curve, const DisplayUnit& value,
                    YAML::Node& node);

/// An entry of `effects` in a ranking or loop document. `gain` may be null, `curve` may be empty.
YAML::Node traced_node(const TracedEffect& traced, const HeldOutGain* gain,
                       const std::vector<CurvePoint>& curve, const Robot& robot);

/// The list `not_separable` of a ranking or loop document.
YAML::Node not_separable_node(const std::vector<RankedCandidate>& candidates);

}  // namespace armtrue
