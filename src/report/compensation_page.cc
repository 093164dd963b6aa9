#include "armtrue/report/compensation_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "armtrue/kinematics/units.h"
#include "report/prediction_parts.h"
#include "report/residual_pictures.h"

namespace armtrue {
namespace {

void add_compensation_verdict(Page& page, const std::vector<CorrectedTarget>& targets,
                              const PredictionConditions& conditions) {
  const bool is_all =
      std::ranges::all_of(targets, &CorrectedTarget::is_corrected) && conditions.all_moves;
  page.verdict(
      is_all ? Tone::good : Tone::attention,
      is_all                 ? "every target is corrected"
      : conditions.all_moves ? "some targets stay as programmed"
                             : "some moves stay as programmed",
      (conditions.moves.empty() ? "" : page.value("moves") + " ") + page.value("sentence"));
  const bool is_known = targets.front().deviation.has_value();
  page.tiles(
      {{"Before", page.value("before_mm/mean") + " mm",
        "mean predicted error of " + page.value("targets") + " targets"},
       {"Expected", page.value("expected_mm/mean") + " mm",
        "with " + page.value("corrected") +
            (is_known ? " corrections, standard deviations of the model included"
                      : " corrections, if the model is exact")},
       {"Uncertainty", is_known ? page.value("std_mm/mean") + " mm" : "?",
        is_known ? "standard deviation of the model" : "the robot file states no uncertainty"}});
}

// The correction of each target and of each inserted point as a vector at its place.
std::vector<Drawing> correction_maps(const std::vector<CorrectedTarget>& targets,
                                     const std::optional<BetweenPoints>& between,
                                     std::vector<std::string> names) {
  std::vector<Eigen::Vector3d> places, moved;
  const auto add = [&](const CorrectedTarget& target) {
    places.push_back(target.intended.translation);
    moved.push_back(target.pose.translation - target.intended.translation);
  };
  std::ranges::for_each(targets, add);
  const bool has_points = between && !between->points.empty();
  if (has_points) std::ranges::for_each(between->points, add);
  names.resize(places.size(), "inserted point");
  return field_maps(
      places, {{"correction", Look::after, moved}},
      {.file = "map",
       .title = "Corrections",
       .frame = "the program's frame",
       .note = has_points ? "What the command of each target and inserted point is moved by."
                          : "What the command of each target is moved by.",
       .what = "corrections",
       .names = std::move(names)});
}

Drawing targets_picture(const std::vector<CorrectedTarget>& targets,
                        const std::vector<std::string>& names) {
  const Eigen::Index rows = targets.size();
  Eigen::VectorXd before(rows), after(rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    before[k] = targets[k].before.position / kMillimetre;
    after[k] = targets[k].expected() / kMillimetre;
  }
  return rows_picture(
      before, after,
      {.after = targets.front().deviation ? "corrected, standard deviation included" : "corrected",
       .names = names});
}

// Straight and circular moves between their points.
void add_between(Page& page, const BetweenPoints& between) {
  const std::string key = "between_points/";
  const BetweenPointsSummary summary = summarize(between);
  page.section("Between the points");
  const auto value = [&](const char* name) { return page.value(key + name); };
  std::string text = "Straight and circular moves: " + value("moves") +
                     "; divided: " + value("divided") + "; moves inserted: " + value("inserted") +
                     ". The predicted error between two points is then below " +
                     value("tolerance_mm") + " mm.";
  if (value("unknown") != "0")
    text += " Moves of which nothing is predicted: " + value("unknown") + ".";
  page.add(paragraph(text));
  if (!summary.before || !summary.after) return;
  Eigen::VectorXd before(between.moves.size()), after(before.size());
  for (Eigen::Index k = 0; k < before.size(); ++k) {
    before[k] = between.moves[k].before / kMillimetre;
    after[k] = between.moves[k].after / kMillimetre;
  }
  page.pictures({rows_picture(before, after,
                              {.file = "between",
                               .title = "Predicted error between the points",
                               .note = "The largest error of each move in the order of the "
                                       "program, at the same time.",
                               .axis = "move",
                               .before = "corrected ends alone",
                               .after = "with inserted points"})});
  page.add(table({"predicted error between points", "mean", "RMS", "95 %", "max"},
                 {page.error_row("corrected ends alone, mm", key + "before_mm"),
                  page.error_row("with inserted points, mm", key + "after_mm")}));
  const std::vector<TableRow> above = page.rows(key + "above", {"pose", "after_mm", "why"});
  if (!above.empty())
    page.add(folded("Moves above the tolerance", table({"move", "error, mm", "why"}, above)));
}

void add_notes(Page& page, const std::vector<CorrectedTarget>& targets) {
  page.section("What needs attention");
  std::vector<TableRow> rows;
  for (CommandNote note : command_notes())
    if (count_of(targets, note) > 0)
      rows.push_back({to_string(note), page.value("notes/" + to_string(note))});
  page.add(rows.empty() ? paragraph("No target has a note.") : table({"note", "targets"}, rows));
  std::vector<TableRow> worst = page.rows("worst", {"pose", "before_mm", "after_mm", "std_mm"});
  for (size_t k = 0; k < worst.size(); ++k)
    worst[k].push_back(
        fmt::to_string(fmt::join(page.values(fmt::format("worst/{}/notes", k)), ", ")));
  page.add(table({"the worst after the correction", "before, mm", "after, mm", "std, mm", "notes"},
                 worst));
}

std::string compensation_numbers(const Page& page, bool is_known) {
  std::vector<TableRow> rows{
      page.error_row("before, mm", "before_mm"), page.error_row("before, mrad", "before_mrad"),
      page.error_row("after, mm", "after_mm"), page.error_row("after, mrad", "after_mrad"),
      page.error_row("after, standard deviation included, mm", "expected_mm")};
  if (is_known) rows.push_back(page.error_row("standard deviation, mm", "std_mm"));
  return table({"predicted error", "mean", "RMS", "95 %", "max"}, rows);
}

}  // namespace

Report compensation_page(const std::vector<CorrectedTarget>& targets, const Program& program,
                         const std::optional<BetweenPoints>& between,
                         const PredictionConditions& conditions, const PageHead& head) {
  Page page(head, conditions.robot, "Compensation");
  add_compensation_verdict(page, targets, conditions);
  page.section("Errors along the program");
  page.pictures({targets_picture(targets, program.visits.pose_ids)});
  if (between) add_between(page, *between);
  page.section("Where the corrections lie");
  page.pictures(correction_maps(targets, between, program.visits.pose_ids));
  add_notes(page, targets);
  if (count_of(targets, CommandNote::outside_readings) > 0) {
    page.section("What to measure next");
    page.list({"poses near the " + page.value("notes/" + to_string(CommandNote::outside_readings)) +
               " targets that lie outside what was measured"});
  }
  add_conditions(page);
  page.folded_section("Details");
  page.add(folded("Errors in numbers",
                  compensation_numbers(page, targets.front().deviation.has_value())));
  return page.finish();
}

}  // namespace armtrue
