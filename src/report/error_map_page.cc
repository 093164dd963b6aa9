#include "armtrue/report/error_map_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "report/error_map_pictures.h"
#include "report/prediction_parts.h"

namespace armtrue {
namespace {

void add_map_verdict(Page& page, const ErrorMap& map, const ErrorMapSummary& summary) {
  const bool is_whole = static_cast<size_t>(summary.predicted) == map.points.size();
  page.verdict(is_whole ? Tone::good : Tone::attention,
               is_whole ? "every point can be reached" : "some points cannot be reached",
               keyed(error_map_sentence(map, summary), "sentence"));
  const bool is_known = summary.after.has_value();
  page.tiles({{"Before", keyed_mm(summary.before.mean, "before_mm/mean") + " mm",
               "mean of " + keyed(std::to_string(summary.predicted), "predicted") + " points"},
              {"After",
               (is_known ? keyed_mm(summary.after->mean, "after_mm/mean")
                         : keyed_mm(summary.left_by_constants.mean, "constants_only_mm/mean")) +
                   " mm",
               is_known ? "left with constants and effects" : "left with the constants alone"},
              {"Floor", is_known ? keyed_mm(summary.deviation->mean, "std_mm/mean") + " mm" : "?",
               is_known ? "uncertainty of the model" : "the robot file states no uncertainty"}});
}

void add_causes(Page& page, const ErrorMapSummary& summary) {
  page.section("Causes, by their share");
  page.add("<div class=\"effects\">\n");
  for (size_t k = 0; k < summary.causes.size(); ++k) {
    const CauseSummary& cause = summary.causes[k];
    const std::string key = fmt::format("causes/{}/", k);
    page.add("<div class=\"effect\"><h3>" + keyed(cause.cause, key + "cause") + "</h3>\n" +
             share_bar(cause.share) +
             paragraph(keyed_share(cause.share, key + "share") + " of the squared error; mean " +
                       keyed_mm(cause.mean, key + "mean_mm") + " mm, largest " +
                       keyed_mm(cause.max, key + "max_mm") + " mm") +
             "</div>\n");
  }
  page.add("</div>\n");
}

std::string map_errors_table(const ErrorMapSummary& summary) {
  std::vector<TableRow> rows{
      error_cells("as it is, mm", summary.before, kMillimetre, "before_mm"),
      error_cells("as it is, mrad", summary.turn, kMilliradian, "before_mrad"),
      error_cells("left with the constants alone, mm", summary.left_by_constants, kMillimetre,
                  "constants_only_mm")};
  if (summary.after)
    rows.push_back(error_cells("left with constants and effects, mm", *summary.after, kMillimetre,
                               "after_mm"));
  if (summary.deviation)
    rows.push_back(
        error_cells("uncertainty of the model, mm", *summary.deviation, kMillimetre, "std_mm"));
  return table({"error", "mean", "RMS", "95 %", "max"}, rows);
}

void add_placements(Page& page, const ErrorMapSummary& summary) {
  if (!summary.best_before) return;
  page.section("Where the part should stand");
  std::vector<TableRow> rows;
  const auto row = [&](const std::string& name, const std::optional<Placement>& placement,
                       const std::string& key) {
    if (!placement) return;
    TableRow cells{name, keyed_mm(placement->mean, "placements/" + key + "/mean_mm")};
    int end = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (double value : {placement->low[axis], placement->high[axis]})
        cells.push_back(keyed(decimal_text(value / kMillimetre, 6),
                              fmt::format("placements/{}/box_mm/{}", key, end++)));
    rows.push_back(cells);
  };
  row("best, as it is", summary.best_before, "best_before");
  row("worst, as it is", summary.worst_before, "worst_before");
  row("best, with constants and effects", summary.best_after, "best_after");
  row("worst, with constants and effects", summary.worst_after, "worst_after");
  page.add(
      table({"place", "mean error, mm", "x from, mm", "to", "y from", "to", "z from", "to"}, rows));
}

void add_map_next(Page& page, const ErrorMap& map) {
  page.section("What to measure next");
  std::vector<std::string> items;
  const auto add = [&](CommandNote note, const std::string& text) {
    if (const int count = count_of(map, note); count > 0)
      items.push_back(keyed(std::to_string(count), "notes/" + to_string(note)) + " points " + text);
  };
  add(CommandNote::outside_readings, "lie outside what was measured: measure poses near them");
  add(CommandNote::singular, "are near a singular posture: bend the wrist more there");
  add(CommandNote::limit, "lie beyond the travel of a joint");
  add(CommandNote::unreachable, "are not reached on this branch: another --start may reach them");
  if (items.empty()) items.push_back("nothing: every point was covered by the readings");
  page.list(items);
}

}  // namespace

std::string error_map_plot(const ErrorMap& map) { return stand_alone(error_map_pictures(map)); }

Report error_map_page(const ErrorMap& map, const ErrorMapSummary& summary,
                      const PredictionConditions& conditions, const PageHead& head) {
  Page page(head, conditions.robot, "Map of errors");
  add_map_verdict(page, map, summary);
  add_causes(page, summary);
  page.section("The map");
  page.pictures(error_map_pictures(map));
  page.add(paragraph(
      "Along one direction, (" + keyed(decimal_text(summary.axis.x(), 2), "direction/axis/x") +
      ", " + keyed(decimal_text(summary.axis.y(), 2), "direction/axis/y") + ", " +
      keyed(decimal_text(summary.axis.z(), 2), "direction/axis/z") + "), lies " +
      keyed_share(summary.axis_share, "direction/share") + " of the squared error."));
  add_placements(page, summary);
  add_map_next(page, map);
  add_conditions(page, conditions);
  page.folded_section("Details");
  page.add(folded("Errors in numbers", map_errors_table(summary)));
  return page.finish();
}

}  // namespace armtrue
