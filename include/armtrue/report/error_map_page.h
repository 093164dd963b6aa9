#pragma once

#include <string>

#include "armtrue/compensation/error_map.h"
#include "armtrue/report/report.h"

namespace armtrue {

/// The picture of a map, as one SVG file. Of a grid: up to three slices across the side with the
/// fewest points, the error before with its arrows, and what would be left. Of a program: its
/// points with their errors from three sides, and the errors along its rows.
std::string error_map_plot(const ErrorMap& map);

/// The page of a map: its sentence, the error before and after, causes by share, the map, where a
/// part should stand, and what the errors hold for. The keys are those of armtrue-error-map/1.
Report error_map_page(const ErrorMap& map, const ErrorMapSummary& summary, const ModelStory& story,
                      const PageHead& head);

}  // namespace armtrue
