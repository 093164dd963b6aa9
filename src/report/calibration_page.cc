#include "armtrue/report/calibration_page.h"

#include <fmt/format.h>

#include "armtrue/calibration/identified_values.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/text/number_text.h"
#include "report/evaluation_parts.h"
#include "report/parameters_table.h"
#include "report/readings_left_out.h"

namespace armtrue {
namespace {

std::string mean_mm(const Page& page, const std::string& key) {
  return page.value(key + "position_mm/mean") + " mm";
}

void add_calibration_verdict(Page& page, const CalibrationResult& result,
                             const CalibrationStory& story, const Evaluation& evaluation) {
  const std::string after = mean_mm(page, "calibration/training/");
  const std::string before = story.nominal ? mean_mm(page, "calibration/nominal/") : "";
  std::string sentence = "Mean error " + (before.empty() ? "" : before + " before, ") + after +
                         " after the calibration, of the " + page.value("calibration/rows") +
                         " readings that it was fitted to; " + page.value("calibration/unknowns") +
                         " unknowns from " + page.value("calibration/poses") + " poses.";
  if (story.missed) sentence += " " + escaped(*story.missed) + ".";
  const NoiseFloor& noise = story.quality.noise;
  const double mean = summarize(evaluation.reading_errors()).mean;
  const bool is_above = noise.source != NoiseFloor::Source::none && !is_at_floor(mean, noise);
  page.verdict(story.missed || is_above ? Tone::attention : Tone::good,
               !result.converged ? "did not converge"
               : story.missed    ? "a criterion is missed"
               : is_above        ? "calibrated, more than noise is left"
                                 : "calibrated",
               sentence);
  page.tiles({{"Nominal", before.empty() ? "?" : before,
               before.empty() ? "base and tool are not both identified" : "base and tool placed"},
              {"Calibrated", after, "of the readings that the fit used"},
              floor_tile(page, story.quality.noise, "calibration/floor_mm")});
}

void add_calibration_next(Page& page, const CalibrationResult& result, const Campaign& campaign) {
  page.section("What to measure next");
  std::vector<std::string> items{
      "held-out poses, to judge the result: evaluate-poses, or close-loop, which finds effects "
      "that the geometry lacks"};
  const NearNominal near = near_nominal(result, campaign);
  if (near.poses > 0)
    items.push_back("some " + page.value("calibration/more_poses") +
                    " more poses like these: they would determine the " +
                    counted(near.parameters.size(), "parameter") +
                    " near the nominal value for lack of readings");
  else if (!near.parameters.empty())
    items.push_back("poses that move every joint over its travel: " +
                    counted(near.parameters.size(), "parameter") +
                    " near the nominal value, not determined by poses like these");
  page.list(items);
}

void add_not_shown(Page& page, const CalibrationResult& result) {
  std::vector<std::string> items;
  for (const int parameter : set_up_not_shown(result.robot.chain, result.set))
    items.push_back(
        page.value("calibration/not_shown/" + parameter_name(result.robot.chain, parameter)));
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
  if (story.nominal) tabled.push_back({"nominal robot", "calibration/nominal/"});
  tabled.push_back({"calibrated robot", "calibration/training/"});
  std::vector<bool> left_out(campaign.rows(), false);
  std::vector<int> lines;
  for (int row : story.quality.blunders) {
    left_out[row] = true;
    lines.push_back(campaign.line[row]);
  }
  Page page(head, result.robot.name, "Calibration");
  add_calibration_verdict(page, result, story, models.back().evaluation);
  page.add(unseen_scale_text(page, "calibration/unseen_scale/"));
  page.add(frames_text());
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
  page.add(folded(counted(result.set.kept.size(), "parameter"),
                  parameters_table(nominal, result, campaign.poses(), "")));
  page.add(folded("Errors in numbers", errors_table(page, tabled)));
  page.add(folded("The fit",
                  table({"fit", ""}, {{"rank", page.value("calibration/rank")},
                                      {"condition", page.value("calibration/condition")},
                                      {"iterations", page.value("calibration/iterations")}})));
  return page.finish();
}

Report evaluation_page(const Robot& robot, const Robot& file, const Campaign& campaign,
                       const Evaluation& evaluation, const std::optional<Robot>& against,
                       const PageHead& head, Bounds bounds) {
  std::vector<Judged> models;
  std::vector<TabledModel> tabled;
  if (against) models.push_back({"compared robot", Look::before, evaluate(*against, campaign)});
  models.push_back({"this robot", Look::after, evaluation});
  if (against) tabled.push_back({"compared robot", "against/"});
  tabled.push_back({"this robot", ""});
  const NoiseFloor noise = noise_floor(robot, campaign, evaluation);
  const bool is_known = noise.source != NoiseFloor::Source::none;
  const bool is_near =
      bounds != Bounds::broken && is_at_floor(summarize(evaluation.reading_errors()).mean, noise);
  Page page(head, robot.name, "Errors on measured poses");
  page.verdict(is_near ? Tone::good : Tone::attention,
               is_near                    ? "at the floor"
               : bounds == Bounds::broken ? "beyond the promised bounds"
               : is_known                 ? "above the floor"
                                          : "no floor is known",
               "Mean error " + mean_mm(page, "") + ", 95 % of the readings below " +
                   page.value("position_mm/p95") + " mm, largest " + page.value("position_mm/max") +
                   " mm, of " + page.value("rows") + " readings at " + page.value("poses") +
                   " poses.");
  std::vector<Page::Tile> tiles;
  if (against)
    tiles.push_back({"Compared with", mean_mm(page, "against/"), page.value("against/robot")});
  tiles.push_back({"This robot", mean_mm(page, ""), "mean of these readings"});
  tiles.push_back(floor_tile(page, noise, "floor_mm"));
  page.tiles(tiles);
  page.add(unseen_scale_text(page, "unseen_scale/"));
  add_error_pictures(page, models, campaign, {}, "readings", upwards(robot));
  page.section("What to measure next");
  page.list({is_near ? "nothing: the errors are those of the noise"
                     : "a campaign for close-loop, which looks for what makes the rest"});
  page.folded_section("Details");
  page.add(folded("Errors in numbers", errors_table(page, tabled)));
  std::vector<TableRow> rows;
  for (const auto& [name, std] : file.std)
    if (const auto parameter = find_parameter(file.chain, name)) {
      const DisplayUnit unit = unit_in_files(file.chain, *parameter);
      rows.push_back(
          {escaped(name), keyed(rounded(std / unit.si), "robot:std/" + name), unit.name});
    }
  if (!rows.empty())
    page.add(folded("Parameters, as the robot file states them",
                    table({"parameter", "standard deviation", "unit"}, rows)));
  return page.finish();
}

}  // namespace armtrue
