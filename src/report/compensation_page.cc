#include "armtrue/report/compensation_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"
#include "report/prediction_parts.h"
#include "report/residual_pictures.h"

namespace armtrue {
namespace {

constexpr int kWorstNamed = 3;

template <typename Value>
ErrorSummary over(const std::vector<CorrectedTarget>& targets, const Value& value) {
  std::vector<double> values;
  for (const CorrectedTarget& target : targets) values.push_back(value(target));
  return summarize(values);
}

ErrorSummary before_of(const std::vector<CorrectedTarget>& targets) {
  return over(targets, [](const CorrectedTarget& target) { return target.before.position; });
}

ErrorSummary after_of(const std::vector<CorrectedTarget>& targets) {
  return over(targets, [](const CorrectedTarget& target) { return target.after.position; });
}

ErrorSummary expected_of(const std::vector<CorrectedTarget>& targets) {
  return over(targets, [](const CorrectedTarget& target) { return target.expected(); });
}

ErrorSummary deviation_of(const std::vector<CorrectedTarget>& targets) {
  return over(targets, [](const CorrectedTarget& target) { return *target.deviation; });
}

void add_compensation_verdict(Page& page, const std::vector<CorrectedTarget>& targets,
                              const PredictionConditions& conditions) {
  const auto corrected = std::ranges::count_if(targets, &CorrectedTarget::is_corrected);
  const bool is_all =
      corrected == static_cast<std::ptrdiff_t>(targets.size()) && conditions.all_moves;
  page.verdict(is_all ? Tone::good : Tone::attention,
               is_all               ? "every target is corrected"
               : conditions.all_moves ? "some targets stay as programmed"
                                      : "some moves stay as programmed",
               (conditions.moves.empty() ? "" : keyed(conditions.moves, "moves") + " ") +
                   keyed(compensation_sentence(targets), "sentence"));
  const bool is_known = targets.front().deviation.has_value();
  page.tiles(
      {{"Before", keyed_mm(before_of(targets).mean, "before_mm/mean") + " mm",
        "mean predicted error of " + keyed(std::to_string(targets.size()), "targets") + " targets"},
       {"After", keyed_mm(expected_of(targets).mean, "expected_mm/mean") + " mm",
        "with " + keyed(std::to_string(corrected), "corrected") +
            (is_known ? " corrections, standard deviations of the model included"
                      : " corrections, if the model is exact")},
       {"Floor", is_known ? keyed_mm(deviation_of(targets).mean, "std_mm/mean") + " mm" : "?",
        is_known ? "standard deviation of the model" : "the robot file states no uncertainty"}});
}

// What each target was moved by, at its place, and each inserted point.
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
void add_between(Page& page, const BetweenPoints& between, const Program& program) {
  const std::string key = "between_points/";
  const BetweenPointsSummary summary = summarize(between);
  page.section("Between the points");
  const auto count = [&](size_t number, const char* name) {
    return keyed(std::to_string(number), key + name);
  };
  page.add(
      paragraph("Of " + count(between.moves.size(), "moves") + " straight and circular moves " +
                count(summary.divided, "divided") + " are divided, and " +
                count(summary.inserted, "inserted") +
                " moves are inserted, so that the predicted error between two points is below " +
                keyed_mm(between.tolerance, key + "tolerance_mm") + " mm. Of " +
                count(between.unknown, "unknown") + " moves nothing is predicted."));
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
  page.add(table(
      {"predicted error between points", "mean", "RMS", "95 %", "max"},
      {error_cells("corrected ends alone, mm", *summary.before, kMillimetre, key + "before_mm"),
       error_cells("with inserted points, mm", *summary.after, kMillimetre, key + "after_mm")}));
  std::vector<TableRow> above;
  for (const MoveBetweenPoints& move : between.moves) {
    if (move.why.empty()) continue;
    const std::string of_move = fmt::format("{}above/{}/", key, above.size());
    above.push_back({keyed(program.visits.pose_ids[move.target], of_move + "pose"),
                     std::isfinite(move.after) ? keyed_mm(move.after, of_move + "after_mm") : "-",
                     keyed(move.why, of_move + "why")});
  }
  if (!above.empty())
    page.add(folded("Moves above the tolerance", table({"move", "error, mm", "why"}, above)));
}

void add_notes(Page& page, const std::vector<CorrectedTarget>& targets, const Program& program) {
  page.section("What needs attention");
  std::vector<TableRow> rows;
  for (CommandNote note : command_notes())
    if (const int count = count_of(targets, note); count > 0)
      rows.push_back({to_string(note), keyed(std::to_string(count), "notes/" + to_string(note))});
  page.add(rows.empty() ? paragraph("No target has a note.") : table({"note", "targets"}, rows));
  std::vector<TableRow> worst;
  const std::vector<int> numbers = worst_targets(targets, kWorstNamed);
  for (size_t k = 0; k < numbers.size(); ++k) {
    const size_t row = numbers[k];
    const CorrectedTarget& target = targets[row];
    const std::string key = fmt::format("worst/{}/", k);
    std::string notes;
    for (size_t n = 0; n < target.notes.size(); ++n)
      notes += (n > 0 ? ", " : "") +
               keyed(to_string(target.notes[n]), fmt::format("{}notes/{}", key, n));
    worst.push_back({keyed(program.visits.pose_ids[row], key + "pose"),
                     keyed_mm(target.before.position, key + "before_mm"),
                     keyed_mm(target.after.position, key + "after_mm"),
                     target.deviation ? keyed_mm(*target.deviation, key + "std_mm") : "-", notes});
  }
  page.add(table({"the worst after the correction", "before, mm", "after, mm", "std, mm", "notes"},
                 worst));
}

std::string compensation_numbers(const std::vector<CorrectedTarget>& targets) {
  std::vector<TableRow> rows;
  const auto row = [&](const char* name, const ErrorSummary& errors, double unit,
                       const std::string& key) {
    rows.push_back(error_cells(name, errors, unit, key));
  };
  row("before, mm", before_of(targets), kMillimetre, "before_mm");
  row("before, mrad",
      over(targets, [](const CorrectedTarget& target) { return target.before.orientation; }),
      kMilliradian, "before_mrad");
  row("after, mm", after_of(targets), kMillimetre, "after_mm");
  row("after, mrad",
      over(targets, [](const CorrectedTarget& target) { return target.after.orientation; }),
      kMilliradian, "after_mrad");
  row("after, standard deviation included, mm", expected_of(targets), kMillimetre, "expected_mm");
  if (targets.front().deviation)
    row("standard deviation, mm", deviation_of(targets), kMillimetre, "std_mm");
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
  if (between) add_between(page, *between, program);
  page.section("Where the corrections lie");
  page.pictures(correction_maps(targets, between, program.visits.pose_ids));
  add_notes(page, targets, program);
  if (const int far = count_of(targets, CommandNote::outside_readings); far > 0) {
    page.section("What to measure next");
    page.list({"poses near the " +
               keyed(std::to_string(far), "notes/" + to_string(CommandNote::outside_readings)) +
               " targets that lie outside what was measured"});
  }
  add_conditions(page, conditions);
  page.folded_section("Details");
  page.add(folded("Errors in numbers", compensation_numbers(targets)));
  return page.finish();
}

}  // namespace armtrue
