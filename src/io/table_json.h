#pragma once

#include <string>
#include <string_view>

namespace armtrue {

/// A CSV table that armtrue writes, as JSON: a list with an object for each row, each on a line of
/// its own, under the columns of the header. Cells of names, such as pose, are texts; of other
/// columns those that are numbers have the digits of the table; empty cells are null.
std::string table_as_json(const std::string& csv);

/// The CSV table of such a list; its lines count as those of table_as_json(). Columns are those of
/// all objects. Throws InputError with `name` if the text is no list of objects of single values,
/// if a column stands twice in an object, or if more stands behind the list.
std::string table_from_json(const std::string& json, const std::string& name);

}  // namespace armtrue
