#include "armtrue/report/error_map_page.h"

#include <fmt/format.h>

#include "armtrue/text/number_text.h"
#include "report/error_map_pictures.h"
#include "report/prediction_parts.h"

namespace armtrue {
namespace {

void add_map_verdict(Page& page, const ErrorMap& map, const ErrorMapSummary& summary) {
  const bool is_whole = summary.predicted == std::ssize(map.points);
  page.verdict(is_whole ? Tone::good : Tone::attention,
               is_whole ? "every point can be reached" : "some points cannot be reached",
               page.value("sentence"));
  const bool is_known = summary.after.has_value();
  page.tiles({{"Before", page.value("before_mm/mean") + " mm",
               "mean of " + page.value("predicted") + " points"},
              {"After", page.value(is_known ? "after_mm/mean" : "constants_only_mm/mean") + " mm",
               is_known ? "left with constants and effects" : "left with the constants alone"},
              {"Uncertainty", is_known ? page.value("std_mm/mean") + " mm" : "?",
               is_known ? "uncertainty of the model" : "the robot file states no uncertainty"}});
}

void add_causes(Page& page, const ErrorMapSummary& summary) {
  page.section("Causes, by their share");
  page.add("<div class=\"effects\">\n");
  for (size_t k = 0; k < summary.causes.size(); ++k) {
    const double share = summary.causes[k].share;
    const std::string key = fmt::format("causes/{}/", k);
    page.add("<div class=\"effect\"><h3>" + page.value(key + "cause") + "</h3>\n" +
             share_bar(share) +
             paragraph(keyed_share(share, key + "share") + " of the squared error; mean " +
                       page.value(key + "mean_mm") + " mm, largest " + page.value(key + "max_mm") +
                       " mm") +
             "</div>\n");
  }
  page.add("</div>\n");
}

std::string map_errors_table(const Page& page, const ErrorMapSummary& summary) {
  std::vector<TableRow> rows{
      page.error_row("as it is, mm", "before_mm"), page.error_row("as it is, mrad", "before_mrad"),
      page.error_row("left with the constants alone, mm", "constants_only_mm")};
  if (summary.after)
    rows.push_back(page.error_row("left with constants and effects, mm", "after_mm"));
  if (summary.deviation) rows.push_back(page.error_row("uncertainty of the model, mm", "std_mm"));
  return table({"error", "mean", "RMS", "95 %", "max"}, rows);
}

void add_placements(Page& page, const ErrorMapSummary& summary) {
  if (!summary.best_before) return;
  page.section("Where the part should stand");
  std::vector<TableRow> rows;
  const auto row = [&](const std::string& name, const std::string& key) {
    TableRow cells{name, page.value("placements/" + key + "/mean_mm")};
    for (const std::string& end : page.values("placements/" + key + "/box_mm"))
      cells.push_back(end);
    if (cells.size() > 2) rows.push_back(cells);
  };
  row("best, as it is", "best_before");
  row("worst, as it is", "worst_before");
  row("best, with constants and effects", "best_after");
  row("worst, with constants and effects", "worst_after");
  page.add(
      table({"place", "mean error, mm", "x from, mm", "to", "y from", "to", "z from", "to"}, rows));
}

void add_map_next(Page& page, const ErrorMap& map) {
  page.section("What to measure next");
  std::vector<std::string> items;
  const auto add = [&](CommandNote note, const std::string& text) {
    if (count_of(map, note) > 0)
      items.push_back(page.value("notes/" + to_string(note)) + " points " + text);
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
  add_conditions(page);
  page.folded_section("Details");
  page.add(folded("Errors in numbers", map_errors_table(page, summary)));
  return page.finish();
}

}  // namespace armtrue
