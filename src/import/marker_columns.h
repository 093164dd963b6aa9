#pragma once

#include <string>
#include <vector>

#include "import/column_mapping.h"
#include "import/plain_table.h"

namespace armtrue {

/// Whether a header is a coordinate of a marker with a number, such as M1_x or x2.
bool is_marker_coordinate(const std::string& header);

/// Several points in one row, such as M1_x, M1_y, M1_z, M2_x, M2_y, M2_z: makes of each row one row
/// for each marker, with the columns x, y, z and `target`, in which the name of the marker stands.
/// Markers are those that `chosen` names or, if it is empty, names that differ in a number alone:
/// other names, such as those of a nominal and an actual point, may be of one point. A table with
/// columns of one point, or without markers, stays as it is. Returns the names of the markers.
/// Throws InputError for a marker that `chosen` names and the table has not.
std::vector<std::string> spread_markers(PlainTable& table, const ImportNames& names,
                                        const std::vector<std::string>& chosen);

}  // namespace armtrue
