#pragma once

#include <string>

#include "armtrue/compensation/error_map.h"
#include "armtrue/compensation/prediction_conditions.h"
#include "armtrue/report/report.h"

namespace armtrue {

/// The picture of a map, as one SVG file. For a grid: up to three slices across the side with the
/// fewest points, with the error before as arrows, and the remaining error. For a program: its
/// points with their errors in three views, and the errors along its rows.
std::string error_map_plot(const ErrorMap& map);

/// The page of a map: its sentence, the error before and after, causes by share, the map, where a
/// part should stand, and the conditions for which the errors are valid. The keys are those of
/// armtrue-error-map/1.
Report error_map_page(const ErrorMap& map, const ErrorMapSummary& summary,
                      const PredictionConditions& conditions, const PageHead& head);

}  // namespace armtrue
