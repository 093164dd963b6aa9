#include "import/body_columns.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string_view>

#include "import/column_names.h"

namespace armtrue {
namespace {

constexpr std::string_view kPosition = "xyz";
constexpr std::array<std::string_view, 19> kOrientation{
    "qw",  "qx",  "qy",  "qz", "r11", "r12", "r13",  "r21",   "r22", "r23",
    "r31", "r32", "r33", "rx", "ry",  "rz",  "roll", "pitch", "yaw"};

struct OfBody {
  std::string body, header;  // without the body
  bool is_position = false;
};

// Splits Tool_x, Tool.position.x or Tool qw after the shortest body name that leaves a known
// quantity.
std::optional<OfBody> of_body(const std::string& header) {
  constexpr std::string_view kSigns = "_ .-:/";
  const std::string stem = column_name(header).stem;
  for (size_t at = stem.find_first_of(kSigns); at != stem.npos;
       at = stem.find_first_of(kSigns, at + 1)) {
    const std::string before = stem.substr(0, at), after = stem.substr(at + 1);
    const auto known = known_quantity(after);
    if (before.empty() || !known) continue;
    if (known->name.size() == 1 && kPosition.find(known->name) != kPosition.npos)
      return OfBody{before, after, true};
    if (std::ranges::find(kOrientation, known->name) != kOrientation.end())
      return OfBody{before, after, false};
  }
  return std::nullopt;
}

// The bodies with a point and an orientation, in the order of the header.
std::vector<std::string> bodies_in(const PlainTable& table, const ImportNames& names) {
  struct Count {
    size_t position = 0, orientation = 0;
  };
  std::vector<std::string> order;
  std::map<std::string, Count> counts;
  for (const PlainColumn& column : table.columns) {
    if (names.is_ignored(column.name) || names.quantity_of(column.name) ||
        known_quantity(column.name))
      continue;
    const auto found = of_body(column.name);
    if (!found) continue;
    const auto [entry, is_new] = counts.try_emplace(found->body);
    if (is_new) order.push_back(found->body);
    ++(found->is_position ? entry->second.position : entry->second.orientation);
  }
  std::erase_if(order, [&](const std::string& body) {
    return counts[body].position != kPosition.size() || counts[body].orientation == 0;
  });
  return order;
}

bool has_point_of_no_body(const PlainTable& table, const ImportNames& names) {
  return names.maps(table, "x") ||
         std::ranges::any_of(table.columns, [&](const PlainColumn& column) {
           const auto known = known_quantity(column.name);
           return !names.is_ignored(column.name) && known && known->name == "x";
         });
}

}  // namespace

bool is_of_body(const std::string& header) { return of_body(header).has_value(); }

void keep_body(PlainTable& table, const ImportNames& names, const std::string& chosen) {
  if (chosen.empty() && has_point_of_no_body(table, names)) return;
  const std::vector<std::string> bodies = bodies_in(table, names);
  if (chosen.empty() && bodies.size() < 2) return;
  if (chosen.empty())
    table.fail_header(
        fmt::format("poses of several bodies stand in a row, {}; name the one that is on the "
                    "robot: --body NAME",
                    fmt::join(bodies, ", ")));
  if (std::ranges::find(bodies, chosen) == bodies.end())
    table.fail_header(fmt::format(
        "has no body '{}' of --body with a point and an orientation; {}", chosen,
        bodies.empty() ? "its columns are such as " + chosen + "_x and " + chosen + "_qw"
                       : fmt::format("it has {}", fmt::join(bodies, ", "))));
  std::vector<size_t> kept;
  std::vector<PlainColumn> columns;
  for (size_t k = 0; k < table.columns.size(); ++k) {
    const PlainColumn& column = table.columns[k];
    const auto found = of_body(column.name);
    const bool is_body = found && std::ranges::find(bodies, found->body) != bodies.end();
    if (is_body && found->body != chosen) continue;
    kept.push_back(k);
    columns.push_back(column);
    if (!is_body) continue;
    const std::string unit = column_name(column.name).unit;
    columns.back() = {found->header, unit.empty() ? column.unit_row : unit};
  }
  for (PlainRow& row : table.rows) {
    std::vector<std::string> cells;
    for (const size_t k : kept) cells.push_back(std::move(row.cells[k]));
    row.cells = std::move(cells);
  }
  table.columns = std::move(columns);
  note_body(table, chosen, bodies);
}

void note_body(PlainTable& table, const std::string& body, const std::vector<std::string>& all) {
  std::vector<std::string> others;
  for (const std::string& name : all)
    if (name != body) others.push_back(name);
  table.notes.push_back("body '" + body + "'");
  if (!others.empty()) table.notes.push_back(fmt::format("not used: {}", fmt::join(others, ", ")));
}

}  // namespace armtrue
