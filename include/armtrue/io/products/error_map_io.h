#pragma once

#include <string>
#include <vector>

#include "armtrue/compensation/error_map.h"
#include "armtrue/compensation/prediction_conditions.h"
#include "armtrue/io/document.h"
#include "armtrue/io/provenance.h"
#include "armtrue/kinematics/joint_names.h"

namespace armtrue {

/// One row for each point: its position, joint angles, the predicted error before and after, the
/// parts of the causes, notes. Lengths and angles have six decimals.
std::string write_error_map(const ErrorMap& map,
                            const std::vector<JointName>& joints = six_axis_names());

/// An armtrue-error-map/1 document.
Document write_error_map_summary(const ErrorMap& map, const ErrorMapSummary& summary,
                                 const PredictionConditions& conditions,
                                 const Provenance& provenance);

/// The summary for a terminal: a sentence, errors by cause, the main direction, the best and worst
/// place of a part.
std::string error_map_table(const ErrorMap& map, const ErrorMapSummary& summary);

}  // namespace armtrue
