#pragma once

#include <string>
#include <vector>

#include "import/column_mapping.h"
#include "import/plain_table.h"

namespace armtrue {

/// Whether a header is a coordinate or a part of an orientation of a named body, such as Tool_x or
/// Tool.orientation.w.
bool is_of_body(const std::string& header);

/// Poses of several rigid bodies in one row, such as Tool_x, Tool_y, Tool_z, Tool_qx, ..., Base_x,
/// ...: keeps those of the body `chosen`, under names without the body. A body has three
/// coordinates and an orientation. A table without bodies, or with a point of no body while
/// `chosen` is empty, stays as it is. Throws InputError if there are several and `chosen` is empty,
/// or if there is none such.
void keep_body(PlainTable& table, const ImportNames& names, const std::string& chosen);

/// Adds to the notes of a table which of its bodies is used, and which are not.
void note_body(PlainTable& table, const std::string& body, const std::vector<std::string>& all);

}  // namespace armtrue
