#include "armtrue/report/calibration_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "armtrue/calibration/identified_values.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "report/evaluation_parts.h"
#include "report/parameters_table.h"
#include "report/readings_left_out.h"

namespace armtrue {
namespace {

std::string mean_mm(const Evaluation& evaluation, const std::string& key) {
  return keyed_mm(summarize(evaluation.reading_errors()).mean, key + "position_mm/mean") + " mm";
}

void add_calibration_verdict(Page& page, const CalibrationResult& result, const Campaign& campaign,
                             const CalibrationStory& story, const std::vector<Judged>& models) {
  const std::string after = mean_mm(models.back().evaluation, "calibration/training/");
  const std::string before =
      story.nominal ? mean_mm(models.front().evaluation, "calibration/nominal/") : "";
  std::string sentence =
      "Mean error " + (before.empty() ? "" : before + " before, ") + after +
      " after the calibration, of the " +
      keyed(std::to_string(campaign.rows()), "calibration/rows") +
      " readings that it was fitted to; " +
      keyed(std::to_string(result.names.size()), "calibration/unknowns") + " unknowns from " +
      keyed(std::to_string(campaign.pose_ids.size()), "calibration/poses") + " poses.";
  if (story.missed) sentence += " " + escaped(*story.missed) + ".";
  const NoiseFloor& noise = story.quality.noise;
  const double mean = summarize(models.back().evaluation.reading_errors()).mean;
  const bool is_above = noise.source != NoiseFloor::Source::none && !is_at_floor(mean, noise);
  page.verdict(story.missed || is_above ? Tone::attention : Tone::good,
               !result.converged ? "did not converge"
               : story.missed    ? "a criterion is missed"
               : is_above        ? "calibrated, more than noise is left"
                                 : "calibrated",
               sentence);
  page.tiles({{"Before", before.empty() ? "?" : before,
               before.empty() ? "base and tool are not both identified"
                              : "nominal robot, base and tool placed"},
              {"After", after, "calibrated robot"},
              floor_tile(story.quality.noise, "calibration/floor_mm")});
}

void add_calibration_next(Page& page, const CalibrationResult& result, const Campaign& campaign) {
  page.section("What to measure next");
  std::vector<std::string> items{
      "held-out poses, to judge the result: evaluate-poses, or close-loop, which finds effects "
      "that the geometry lacks"};
  const NearNominal near = near_nominal(result, campaign);
  if (near.poses > 0)
    items.push_back("some " + keyed(std::to_string(near.poses), "calibration/more_poses") +
                    " more poses like these: they would determine the " +
                    std::to_string(near.parameters.size()) +
                    " parameters that stand near their nominal values for lack of readings");
  else if (!near.parameters.empty())
    items.push_back(
        "poses that move every joint over its travel: " + std::to_string(near.parameters.size()) +
        " parameters stand near their nominal values, and poses like these do not "
        "determine them");
  page.list(items);
}

void add_not_shown(Page& page, const CalibrationResult& result) {
  const KinematicChain& chain = result.robot.chain;
  std::vector<std::string> items;
  for (const int parameter : set_up_not_shown(chain, result.set))
    items.push_back(keyed(not_shown(chain, parameter),
                          "calibration/not_shown/" + parameter_name(chain, parameter)));
  if (items.empty()) return;
  page.section("To enter by hand");
  page.list(items);
}

}  // namespace

Report calibration_page(const CalibrationResult& result, const Robot& nominal,
                        const Campaign& campaign, const CalibrationStory& story,
                        const PageHead& head) {
  std::vector<Judged> models;
  std::vector<TabledModel> tabled;
  if (story.nominal)
    models.push_back({"nominal robot", Look::before, evaluate(*story.nominal, campaign)});
  models.push_back({"calibrated robot", Look::after, evaluate(result.robot, campaign)});
  if (story.nominal)
    tabled.push_back({"nominal robot", "calibration/nominal/", &models.front().evaluation});
  tabled.push_back({"calibrated robot", "calibration/training/", &models.back().evaluation});
  std::vector<bool> left_out(campaign.rows(), false);
  std::vector<int> lines;
  for (int row : story.quality.blunders) {
    left_out[row] = true;
    lines.push_back(campaign.line[row]);
  }
  Page page(head, result.robot.name, "Calibration");
  add_calibration_verdict(page, result, campaign, story, models);
  page.add(unseen_scale_text(unseen_scale(result.robot, campaign), "calibration/unseen_scale/"));
  add_error_pictures(page, models, campaign, left_out, "readings of the fit",
                     upwards(result.robot));
  add_calibration_next(page, result, campaign);
  add_readings_left_out(page, story.gross, lines, "calibration/");
  add_not_shown(page, result);
  page.section("Parameters");
  page.add(
      paragraph("The identified parameters, before and after, how well each is known, and how much "
                "of it the readings say: 1 is all, below a half it stands near its nominal value. "
                "Turns of base and tool have no number of their own; their change is a rotation "
                "vector."));
  page.add(
      folded(fmt::format("{} parameters", result.set.kept.size()),
             parameters_table(nominal, result, static_cast<int>(campaign.pose_ids.size()), "")));
  page.add(folded("Errors in numbers", errors_table(tabled, campaign)));
  page.add(folded(
      "The fit",
      table({"fit", ""},
            {{"rank", keyed(std::to_string(result.rank), "calibration/rank")},
             {"condition", keyed(result.condition, "calibration/condition")},
             {"iterations", keyed(std::to_string(result.iterations), "calibration/iterations")}})));
  return page.finish();
}

Report evaluation_page(const Robot& robot, const Robot& file, const Campaign& campaign,
                       const Evaluation& evaluation, const std::optional<Robot>& against,
                       const PageHead& head, Bounds bounds) {
  std::vector<Judged> models;
  std::vector<TabledModel> tabled;
  if (against) models.push_back({"compared robot", Look::before, evaluate(*against, campaign)});
  models.push_back({"this robot", Look::after, evaluation});
  if (against) tabled.push_back({"compared robot", "against/", &models.front().evaluation});
  tabled.push_back({"this robot", "", &models.back().evaluation});
  const NoiseFloor noise = noise_floor(robot, campaign, evaluation);
  const ErrorSummary errors = summarize(evaluation.reading_errors());
  const bool is_known = noise.source != NoiseFloor::Source::none;
  const bool is_near = bounds != Bounds::broken && is_at_floor(errors.mean, noise);
  Page page(head, robot.name, "Errors on measured poses");
  page.verdict(is_near ? Tone::good : Tone::attention,
               is_near                    ? "at the floor"
               : bounds == Bounds::broken ? "beyond the promised bounds"
               : is_known                 ? "above the floor"
                                          : "no floor is known",
               "Mean error " + mean_mm(evaluation, "") + ", 95 % of the readings below " +
                   keyed_mm(errors.p95, "position_mm/p95") + " mm, largest " +
                   keyed_mm(errors.max, "position_mm/max") + " mm, of " +
                   keyed(std::to_string(campaign.rows()), "rows") + " readings at " +
                   keyed(std::to_string(campaign.pose_ids.size()), "poses") + " poses.");
  page.tiles({{"Before", against ? mean_mm(models.front().evaluation, "against/") : "?",
               against ? keyed(against->name, "against/robot") : "--against names a robot"},
              {"After", mean_mm(evaluation, ""), "this robot"},
              floor_tile(noise, "floor_mm")});
  page.add(unseen_scale_text(unseen_scale(robot, campaign), "unseen_scale/"));
  add_error_pictures(page, models, campaign, {}, "readings", upwards(robot));
  page.section("What to measure next");
  page.list({is_near ? "nothing: the errors are those of the noise"
                     : "a campaign for close-loop, which looks for what makes the rest"});
  page.folded_section("Details");
  page.add(folded("Errors in numbers", errors_table(tabled, campaign)));
  std::vector<TableRow> rows;
  for (const auto& [name, std] : file.std)
    if (const auto parameter = find_parameter(file.chain, name)) {
      const DisplayUnit unit = unit_in_files(file.chain, *parameter);
      rows.push_back({escaped(name), keyed(std / unit.si, "robot:std/" + name), unit.name});
    }
  if (!rows.empty())
    page.add(folded("Parameters, as the robot file states them",
                    table({"parameter", "standard deviation", "unit"}, rows)));
  return page.finish();
}

}  // namespace armtrue
