#include "import/marker_columns.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <optional>

#include "armtrue/text/edit_distance.h"

namespace armtrue {
namespace {

constexpr std::string_view kSigns = "_ .-:/";

struct MarkerColumn {
  std::string marker;
  size_t axis;
};

std::optional<size_t> axis_of(std::string_view text) {
  const auto known = known_quantity(text);
  if (!known || known->kind != UnitKind::length || known->name.size() != 1) return std::nullopt;
  return std::string_view("xyz").find(known->name);
}

bool is_digit(unsigned char c) { return std::isdigit(c) != 0; }

// Marker and axis of M1_x, M1.pos_x, x_M1, M1x or x1.
std::optional<MarkerColumn> marker_of(const std::string& header) {
  const std::string stem = column_name(header).stem;
  for (size_t at = stem.find_first_of(kSigns); at != stem.npos;
       at = stem.find_first_of(kSigns, at + 1)) {
    const std::string before = stem.substr(0, at), after = stem.substr(at + 1);
    if (before.empty() || after.empty()) continue;
    if (const auto axis = axis_of(after)) return MarkerColumn{before, *axis};
    if (const auto axis = axis_of(before)) return MarkerColumn{after, *axis};
  }
  if (stem.size() < 2) return std::nullopt;
  const std::string first = stem.substr(0, 1), last = stem.substr(stem.size() - 1);
  if (const auto axis = axis_of(last); axis && is_digit(stem[stem.size() - 2]))
    return MarkerColumn{stem.substr(0, stem.size() - 1), *axis};
  if (const auto axis = axis_of(first); axis && std::ranges::all_of(stem.substr(1), is_digit))
    return MarkerColumn{stem.substr(1), *axis};
  return std::nullopt;
}

// The columns of the axes of each marker that has all three, in the order of the header.
using Markers = std::vector<std::pair<std::string, std::array<size_t, 3>>>;

Markers whole_markers(const PlainTable& table, const ImportNames& names) {
  std::vector<std::string> order;
  std::map<std::string, std::map<size_t, size_t>> columns;
  for (size_t k = 0; k < table.columns.size(); ++k) {
    const std::string& header = table.columns[k].name;
    if (names.is_ignored(header) || names.quantity_of(header) || known_quantity(header)) continue;
    const auto found = marker_of(header);
    if (!found) continue;
    if (!columns.contains(found->marker)) order.push_back(found->marker);
    columns[found->marker].emplace(found->axis, k);
  }
  Markers markers;
  for (const std::string& name : order)
    if (const auto& axes = columns[name]; axes.size() == 3)
      markers.push_back({name, {axes.at(0), axes.at(1), axes.at(2)}});
  return markers;
}

std::string without_digits(std::string name) {
  std::erase_if(name, is_digit);
  return lower_case(name);
}

bool differ_in_numbers(const Markers& markers) {
  return std::ranges::all_of(markers, [&](const auto& marker) {
    return without_digits(marker.first) == without_digits(markers.front().first) &&
           std::ranges::any_of(marker.first, is_digit);
  });
}

bool has_one_point(const PlainTable& table, const ImportNames& names) {
  if (names.maps(table, "x")) return true;
  return std::ranges::any_of(table.columns, [&](const PlainColumn& column) {
    return !names.is_ignored(column.name) && axis_of(column.name).has_value();
  });
}

void keep_chosen(const PlainTable& table, const std::vector<std::string>& chosen,
                 Markers& markers) {
  Markers kept;
  for (const std::string& name : chosen) {
    const auto found = std::ranges::find(markers, name, &Markers::value_type::first);
    if (found == markers.end()) {
      std::vector<std::string> there;
      for (const auto& [marker, axes] : markers) there.push_back(marker);
      table.fail_header(fmt::format("no columns of x, y and z are known of the marker '{}'{}", name,
                                    there.empty()
                                        ? "; its columns are such as " + name + "_x"
                                        : fmt::format("; there are {}", fmt::join(there, ", "))));
    }
    kept.push_back(*found);
  }
  markers = kept;
}

}  // namespace

bool is_marker_coordinate(const std::string& header) {
  const auto found = marker_of(header);
  return found && std::ranges::any_of(found->marker, is_digit);
}

std::vector<std::string> spread_markers(PlainTable& table, const ImportNames& names,
                                        const std::vector<std::string>& chosen) {
  if (has_one_point(table, names)) {
    if (!chosen.empty())
      table.fail_header(
          "--marker is given, but one point stands in each row, with x, y and z; leave "
          "its columns out with --ignore, or leave out --marker");
    return {};
  }
  Markers markers = whole_markers(table, names);
  if (!chosen.empty()) keep_chosen(table, chosen, markers);
  // A single point with a name, such as TCP, may be the controller's: the user must name its
  // columns.
  if (markers.size() < 2 && chosen.empty()) return {};
  std::vector<std::string> found;
  for (const auto& [name, axes] : markers) found.push_back(name);
  if (chosen.empty() && !differ_in_numbers(markers))
    table.fail_header(
        fmt::format("several points stand in a row: {}; if they are reflectors on the "
                    "tool, say --marker {}, else name the measured one alone: --marker NAME",
                    fmt::join(found, ", "), fmt::join(found, " --marker ")));
  std::vector<size_t> others;
  for (size_t k = 0; k < table.columns.size(); ++k)
    if (std::ranges::none_of(markers, [&](const auto& marker) {
          return std::ranges::find(marker.second, k) != marker.second.end();
        }))
      others.push_back(k);
  PlainTable spread = table;
  spread.columns.clear();
  spread.rows.clear();
  for (const size_t k : others) spread.columns.push_back(table.columns[k]);
  for (size_t axis = 0; axis < 3; ++axis) {
    // The unit of the first marker is that of all.
    const auto unit_of = [&](size_t k) {
      const std::string& in_header = column_name(table.columns[k].name).unit;
      return in_header.empty() ? table.columns[k].unit_row : in_header;
    };
    const std::string unit = unit_of(markers.front().second[axis]);
    for (const auto& [name, axes] : markers)
      if (unit_of(axes[axis]) != unit)
        table.fail_header("the column '" + table.columns[axes[axis]].name +
                          "' has another unit than '" +
                          table.columns[markers.front().second[axis]].name +
                          "'; write the points of all markers in one unit");
    spread.columns.push_back({std::string(1, "xyz"[axis]), unit});
  }
  // One marker alone needs no column `target`.
  spread.has_markers = markers.size() > 1;
  if (spread.has_markers) spread.columns.push_back({"target", ""});
  for (const PlainRow& row : table.rows)
    for (const auto& [name, axes] : markers) {
      PlainRow& one = spread.rows.emplace_back(PlainRow{row.line, {}});
      for (const size_t k : others) one.cells.push_back(row.cells[k]);
      for (const size_t k : axes) one.cells.push_back(row.cells[k]);
      if (spread.has_markers) one.cells.push_back(name);
    }
  if (spread.has_markers)
    spread.notes.push_back(fmt::format("{} markers in each row, each a target: {}", markers.size(),
                                       fmt::join(found, ", ")));
  table = std::move(spread);
  return found;
}

}  // namespace armtrue
