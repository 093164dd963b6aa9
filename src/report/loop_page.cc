#include "armtrue/report/loop_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "armtrue/calibration/doubts.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/text/number_text.h"
#include "report/curve_pictures.h"
#include "report/evaluation_parts.h"
#include "report/parameters_table.h"
#include "report/readings_left_out.h"

namespace armtrue {
namespace {

std::string index_key(const char* list, size_t k) { return fmt::format("{}/{}/", list, k); }

Tone tone_of(const LoopResult& result) {
  if (result.worse_than_nominal || result.verdict == Verdict::unexplained) return Tone::bad;
  const bool is_done =
      result.verdict == Verdict::closed || result.verdict == Verdict::nothing_to_explain;
  return is_done ? Tone::good : Tone::attention;
}

std::string badge_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::closed:
      return "closed";
    case Verdict::nothing_to_explain:
      return "nothing to explain";
    case Verdict::not_separable:
      return "cause not yet decided";
    case Verdict::too_few_poses:
      return "too few poses";
    case Verdict::unknown_noise:
      return "the noise is not known";
    case Verdict::unexplained:
      break;
  }
  return "a rest is unexplained";
}

// The readings on which the models are compared: the held-out ones, else those of the training.
struct Judging {
  const Campaign& campaign;
  std::string set, words;  // as a key, and in words
};

Judging judging(const LoopResult& result, const Campaign& training, const Campaign& held_out) {
  const std::string what = result.of_distances ? "distances" : "readings";
  if (result.held_out_poses > 0) return {held_out, "held_out", "held-out " + what};
  return {training, "training", "training " + what};
}

// Whether the result is more than the geometry.
bool has_effects(const LoopResult& result) {
  return !result.trace.effects.empty() || !result.held.empty() || result.applied;
}

std::vector<Judged> models_of(const LoopResult& result, const Campaign& judging) {
  const bool has_more = has_effects(result);
  std::vector<Judged> models;
  models.push_back({"nominal robot", Look::nominal, evaluate(result.nominal, judging)});
  models.push_back({"calibrated geometry", has_more ? Look::before : Look::after,
                    evaluate(result.trace.stages.front().robot, judging)});
  if (has_more)
    models.push_back({"with its effects", Look::after, evaluate(result_of(result).robot, judging)});
  return models;
}

void add_tiles(Page& page, const LoopResult& result, const Judging& by) {
  const bool held_out = result.held_out_poses > 0, has_more = has_effects(result);
  const auto mean_of = [&](size_t stage) {
    return page.value(fmt::format("stages/{}/{}/position_mm/mean", stage, by.set)) + " mm";
  };
  const std::string readings = fmt::format("mean of {} {}", by.campaign.readings(), by.words);
  std::vector<Page::Tile> tiles{{"Nominal", mean_of(0), "base and tool placed, " + readings},
                                {"Calibrated", mean_of(1), "geometry, " + readings}};
  if (has_more)
    tiles.push_back(
        {"With effects",
         held_out ? page.value("before_after/after_mm") + " mm" : mean_of(result.stages.size() - 1),
         readings});
  if (result.after_arm)
    tiles.push_back({"The arm alone", page.value("before_after/after_arm_mm") + " mm",
                     "without what station and tool do, as programs are corrected"});
  if (result.after_readings)
    tiles.push_back(
        {"The readings", page.value("before_after/after_readings_mm") + " mm",
         "with what follows time, temperature or the way to a pose, which no program can"});
  tiles.push_back(floor_tile(page, result.noise, "before_after/floor_mm"));
  page.tiles(tiles);
}

void add_joints(Page& page, const LoopResult& result) {
  if (result.joints.empty()) return;
  page.section("What each joint does");
  page.add(paragraph(
      "The curve that programs are corrected with: causes with a name and all that "
      "the joint does besides. A part of it that lies inside its band about zero is not shown by "
      "these poses."));
  std::vector<Drawing> pictures;
  for (const JointCurve& curve : result.joints)
    pictures.push_back(joint_picture(curve, result.applied->fit.robot.chain));
  page.pictures(pictures);
}

void add_owners(Page& page, const LoopResult& result) {
  if (result.parts.empty()) return;
  std::vector<TableRow> rows;
  for (size_t k = 0; k < result.parts.size(); ++k) {
    const std::string key = index_key("arm_and_station", k), size = page.value(key + "rms_mm");
    const bool of_arm = result.parts[k].of_arm;
    rows.push_back({page.value(key + "what"), of_arm ? size : "", of_arm ? "" : size});
  }
  page.section("Arm and station");
  page.add(paragraph("What each cause takes off the training readings. Programs are corrected for "
                     "what the arm does, and not for what the station does.") +
           table({"cause", "arm, RMS mm", "station, RMS mm"}, rows));
}

std::string statistics_of(const Page& page, const LoopResult& result, size_t k) {
  const TracedEffect& traced = result.trace.effects[k];
  const std::string key = index_key("effects", k), evidence = key + "evidence/";
  std::vector<TableRow> rows;
  rows.push_back({"fall of EBIC", page.value(evidence + "delta_ebic")});
  rows.push_back({"family-wise p", page.value(evidence + "p_value")});
  rows.push_back({"cross-validated gain", page.value(evidence + "cross_validated_gain")});
  rows.push_back({"share of the variance that the effects explain, 95 %",
                  keyed_share(traced.variance_share.ci95[0], key + "variance_share_ci95/0") +
                      " to " +
                      keyed_share(traced.variance_share.ci95[1], key + "variance_share_ci95/1")});
  if (k < result.gains.size())
    rows.push_back(
        {"held-out gain, mm (95 %)", page.value(evidence + "held_out_gain_mm") + " (" +
                                         page.value(evidence + "held_out_gain_ci95_mm/0") + " to " +
                                         page.value(evidence + "held_out_gain_ci95_mm/1") + ")"});
  if (result.nested)
    rows.push_back(
        {"found again, folds", page.value(fmt::format("nested_cv/found_again/{}/folds", k)) +
                                   " of " + page.value("nested_cv/folds")});
  std::string html = paragraph(page.value(key + "description")) + table({"", ""}, rows);
  if (traced.indistinguishable.empty()) return html;
  html += "<p>Effects that these readings cannot distinguish:</p>\n<ul>\n";
  for (const std::string& rival : page.values(key + "unidentifiable"))
    html += "<li>" + rival + "</li>\n";
  return html + "</ul>\n";
}

void add_effects(Page& page, const LoopResult& result) {
  if (result.trace.effects.empty()) return;
  page.section("Causes, by their share");
  std::vector<size_t> order(result.trace.effects.size());
  for (size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::ranges::stable_sort(order, [&](size_t a, size_t b) {
    return result.trace.effects[a].variance_share.value >
           result.trace.effects[b].variance_share.value;
  });
  const Robot& robot = result.trace.fit.robot;
  constexpr size_t kShown = 6;  // the others have small shares
  const bool folds = order.size() > kShown + 2;
  page.add("<div class=\"effects\">\n");
  for (size_t place = 0; place < order.size(); ++place) {
    const size_t k = order[place];
    if (folds && place == kShown)
      page.add(
          fmt::format("</div>\n<details><summary>{}</summary>\n<div "
                      "class=\"effects\">\n",
                      counted(order.size() - kShown, "further effect")));
    const TracedEffect& traced = result.trace.effects[k];
    const std::string key = index_key("effects", k);
    page.add("<div class=\"effect\"><h3>" + page.value(key + "sentence") + "</h3>\n" +
             share_bar(traced.variance_share.value) +
             paragraph(keyed_share(traced.variance_share.value, key + "variance_share") +
                       " of what the effects explain <span class=\"quiet\">(" +
                       page.value(key + "parameter") + " follows " + page.value(key + "driver") +
                       " (" + page.value(key + "shape") + "))</span>"));
    page.pictures({effect_picture(traced, result.curves[k], robot, k)});
    page.add(folded("Statistics", statistics_of(page, result, k)) + "</div>\n");
  }
  page.add(folds ? "</div></details>\n" : "</div>\n");
}

void add_next(Page& page, const LoopResult& result) {
  page.section("What to measure next");
  std::vector<std::string> items;
  if (page.has("next_poses"))
    items.push_back("the poses of " + page.file_name("next_poses") +
                    ", which tell the causes apart");
  for (size_t k = 0; k < result.trace.effects.size(); ++k) {
    const TracedEffect& traced = result.trace.effects[k];
    if (!traced.indistinguishable.empty() && !traced.separated_by.empty())
      items.push_back("for " + escaped(to_string(traced.effect.parameter)) + ": " +
                      page.value(index_key("effects", k) + "separated_by"));
  }
  if (result.verdict == Verdict::too_few_poses)
    items.push_back(fmt::format("some {} like these", counted(result.more_poses, "more pose")));
  if (result.verdict == Verdict::unknown_noise)
    items.push_back("every pose twice or more, driven to anew: repeats show the noise");
  if (result.verdict == Verdict::unexplained && result.explanation.empty()) {
    items.push_back("the same with time, temperatures and payload logged at each reading");
    items.push_back("repeats after driving to the pose anew, else the floor is too low");
    if (!result.pattern.empty())
      items.push_back("the best candidate that was not added: " + page.value("remaining/pattern") +
                      ", p " + page.value("remaining/pattern_p"));
  }
  if (items.empty())
    items.push_back(
        "nothing to learn more from poses like these; poses where the arm will work "
        "show how far the result carries (evaluate-poses)");
  std::ranges::sort(items);
  items.erase(std::unique(items.begin(), items.end()), items.end());
  page.list(items);
}

std::string stages_table(const Page& page, const LoopResult& result) {
  TableRow head{"stage", "unknowns", "training mean, mm"};
  std::vector<std::string> keys{"name", "parameters", "training/position_mm/mean"};
  if (result.held_out_poses > 0)
    for (const auto& [name, of] : {std::pair("mean", "mean"), {"95 %", "p95"}, {"max", "max"}}) {
      head.push_back(fmt::format("held-out {}, mm", name));
      keys.push_back(fmt::format("held_out/position_mm/{}", of));
    }
  std::string html = table(head, page.rows("stages", keys));
  if (result.worst)
    html += paragraph("The worst held-out pose is " + page.value("worst_held_out/pose") + ": " +
                      page.value("worst_held_out/after_mm") + " mm with the final model.");
  if (!result.contradicted_rows.empty())
    html += paragraph("Readings that the others of their pose contradict, " +
                      lines_in_words(result.contradicted_rows) +
                      ": the errors count them, the verdict does without. Without them: " +
                      page.value("contradicted/after_mm") + " mm.");
  if (result.applied)
    html += paragraph(
        "The last line is the arm as it is applied: what it does besides has no name and is no "
        "finding, and the verdict does without it.");
  return html;
}

std::string nested_text(const Page& page) {
  const auto value = [&](const std::string& key) { return page.value("nested_cv/" + key); };
  return paragraph("Nested cross-validation, the whole search repeated in " + value("folds") +
                   " folds: mean error " + value("before_mm") + " mm with geometry alone, " +
                   value("after_mm") + " mm with what the search added (gain " + value("gain_mm") +
                   " mm, standard error " + value("gain_se_mm") + " mm).");
}

std::string axes_table(const Page& page, const LoopResult& result, const Judging& by) {
  std::vector<TableRow> rows;
  for (size_t k = 0; k < result.stages.size(); ++k) {
    const bool is_last = k + 1 == result.stages.size() && !result.rejected;
    if (k >= 2 && !is_last) continue;
    const PoseErrors& errors =
        by.set == "held_out" ? result.stages[k].held_out : result.stages[k].training;
    for (const AxisErrors& axis : errors.axes) {
      const std::string key = fmt::format("stages/{}/{}/axes_mm/{}/", k, by.set, axis.axis);
      rows.push_back({fmt::format("{}, {}", axis.axis,
                                  k == 0   ? "nominal robot"
                                  : k == 1 ? "calibrated geometry"
                                           : "with its effects"),
                      page.value(key + "mean"), page.value(key + "min"), page.value(key + "max")});
    }
  }
  return table({"axis", "mean, mm", "min, mm", "max, mm"}, rows);
}

void add_rest(Page& page, const LoopResult& result, const Judging& by) {
  std::string html = stages_table(page, result) + axes_table(page, result, by);
  if (result.nested) html += nested_text(page);
  if (result.lack_of_fit)
    html += paragraph("Lack of fit against the noise: p " + page.value("remaining/lack_of_fit_p") +
                      ".");
  page.folded_section("Details");
  page.add(folded("Stages of the model", html));
}

// The parameters of the fit to all poses if there is one, as a robot file has them.
void add_parameters(Page& page, const LoopResult& result, const std::optional<FitToAll>& to_all,
                    const Robot& nominal, const Campaign& training) {
  const CalibrationResult& fit = to_all ? to_all->fit : result_of(result);
  const int poses = (to_all ? to_all->sound : training).poses();
  page.add(folded(
      counted(fit.set.kept.size(), "parameter"),
      paragraph(fmt::format("Fitted to {} {}poses, beside the effects. A share of 1: the readings "
                            "say all; below a half the parameter stands near its nominal value. "
                            "Turns of base and tool have no number of their own; their change is "
                            "a rotation vector.",
                            poses, to_all ? "" : "training ")) +
          parameters_table(nominal, fit, poses, "robot:")));
}

}  // namespace

Report loop_page(const LoopResult& result, const std::optional<FitToAll>& to_all,
                 const Robot& nominal, const Campaign& training, const Campaign& held_out,
                 const PageHead& head) {
  const Campaign sound = without_gross(training, result.gross_poses);
  const Judging by = judging(result, sound, held_out);
  const std::vector<Judged> models = models_of(result, by.campaign);
  Page page(head, nominal.name, "Closing the loop");
  page.verdict(tone_of(result), badge_of(result.verdict), page.value("sentence"));
  add_tiles(page, result, by);
  page.add(unseen_scale_text(page, "unseen_scale/"));
  page.add(frames_text());
  add_effects(page, result);
  add_joints(page, result);
  add_owners(page, result);
  add_next(page, result);
  add_error_pictures(page, models, by.campaign, {}, by.words, upwards(nominal));
  add_readings_left_out(page, result.gross_poses, result.excluded_rows, "data/");
  add_rest(page, result, by);
  add_parameters(page, result, to_all, nominal, sound);
  return page.finish();
}

}  // namespace armtrue
