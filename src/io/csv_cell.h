#pragma once

#include <string>
#include <string_view>

namespace armtrue {

/// A name as a cell of a CSV table: in quotes if it holds the separator, begins with a quote or with
/// the # of a comment, or has blanks at an end, which readers take away (RFC 4180).
inline std::string csv_cell(std::string_view name, char separator = ',') {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  const bool is_quoted = !name.empty() &&
                         (name.find(separator) != std::string_view::npos || name.front() == '"' ||
                          name.front() == '#' || is_blank(name.front()) || is_blank(name.back()));
  if (!is_quoted) return std::string(name);
  std::string cell = "\"";
  for (const char c : name) cell.append(c == '"' ? 2 : 1, c);
  return cell + '"';
}

}  // namespace armtrue
