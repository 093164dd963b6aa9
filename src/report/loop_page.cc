#include "armtrue/report/loop_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "armtrue/tracing/description.h"
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

// The readings that judge: those held out, else those of the training.
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
  return !result.trace.effects.empty() || result.applied;
}

std::vector<Judged> models_of(const LoopResult& result, const Campaign& judging) {
  const bool has_more = has_effects(result);
  std::vector<Judged> models;
  models.push_back({"nominal robot", has_more ? Look::nominal : Look::before,
                    evaluate(result.nominal, judging)});
  models.push_back({"calibrated geometry", has_more ? Look::before : Look::after,
                    evaluate(result.trace.stages.front().robot, judging)});
  if (has_more)
    models.push_back({"with its effects", Look::after, evaluate(result_of(result).robot, judging)});
  return models;
}

void add_tiles(Page& page, const LoopResult& result, const Judging& by) {
  const bool held_out = result.held_out_poses > 0, has_more = has_effects(result);
  const auto mean_of = [&](size_t stage) {
    const Stage& of = result.stages[stage];
    return keyed_mm((held_out ? of.held_out : of.training).position.mean,
                    fmt::format("stages/{}/{}/position_mm/mean", stage, by.set)) +
           " mm";
  };
  const std::string readings = fmt::format("mean of {} {}", by.campaign.rows(), by.words);
  const bool in_summary = held_out && has_more;
  std::vector<Page::Tile> tiles{
      {"Before",
       in_summary ? keyed_mm(result.before, "before_after/before_mm") + " mm"
                  : mean_of(has_more ? 1 : 0),
       has_more ? "calibrated geometry; nominal robot " + mean_of(0) : "nominal robot"},
      {"After",
       held_out ? keyed_mm(result.after, "before_after/after_mm") + " mm"
                : mean_of(result.stages.size() - 1),
       (has_more ? "with its effects, " : "calibrated geometry, ") + readings}};
  if (result.after_arm)
    tiles.push_back({"The arm alone",
                     keyed_mm(*result.after_arm, "before_after/after_arm_mm") + " mm",
                     "without what the station does, as programs are corrected"});
  if (result.after_readings)
    tiles.push_back({"The readings",
                     keyed_mm(*result.after_readings, "before_after/after_readings_mm") + " mm",
                     "with what follows time, temperature or the way to a pose, which no program can"});
  tiles.push_back({"Floor", keyed_mm(result.floor, "before_after/floor_mm") + " mm",
                   "what a perfect model would show"});
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
    const Part& part = result.parts[k];
    const std::string key = index_key("arm_and_station", k);
    const std::string size = keyed_mm(part.position, key + "rms_mm");
    rows.push_back(
        {keyed(part.what, key + "what"), part.of_arm ? size : "", part.of_arm ? "" : size});
  }
  page.section("Arm and station");
  page.add(paragraph("What each cause takes off the training readings. Programs are corrected for "
                     "what the arm does, and not for what the station does.") +
           table({"cause", "arm, RMS mm", "station, RMS mm"}, rows));
}

std::string statistics_of(const LoopResult& result, size_t k) {
  const TracedEffect& traced = result.trace.effects[k];
  const std::string key = index_key("effects", k);
  std::vector<TableRow> rows;
  rows.push_back({"fall of EBIC", keyed(traced.evidence.delta_ebic, key + "evidence/delta_ebic")});
  rows.push_back({"family-wise p", keyed(traced.evidence.p_value, key + "evidence/p_value")});
  rows.push_back({"cross-validated gain", keyed(traced.evidence.cross_validated_gain,
                                                key + "evidence/cross_validated_gain")});
  rows.push_back({"share of the variance that the effects explain, 95 %",
                  keyed_share(traced.variance_share.ci95[0], key + "variance_share_ci95/0") +
                      " to " +
                      keyed_share(traced.variance_share.ci95[1], key + "variance_share_ci95/1")});
  if (k < result.gains.size()) {
    const HeldOutGain& gain = result.gains[k];
    rows.push_back({"held-out gain, mm (95 %)",
                    keyed_mm(gain.position, key + "evidence/held_out_gain_mm") + " (" +
                        keyed_mm(gain.ci95[0], key + "evidence/held_out_gain_ci95_mm/0") + " to " +
                        keyed_mm(gain.ci95[1], key + "evidence/held_out_gain_ci95_mm/1") + ")"});
  }
  if (result.nested)
    rows.push_back({"found again, folds",
                    keyed(std::to_string(result.nested->found_again[k]),
                          fmt::format("nested_cv/found_again/{}/folds", k)) +
                        " of " + keyed(std::to_string(result.nested->folds), "nested_cv/folds")});
  std::string html =
      paragraph(keyed(effect_descriptions(result)[k], key + "description")) + table({"", ""}, rows);
  if (traced.indistinguishable.empty()) return html;
  html += "<p>Effects that these readings cannot distinguish:</p>\n<ul>\n";
  for (size_t r = 0; r < traced.indistinguishable.size(); ++r)
    html += "<li>" +
            keyed(unidentifiable(traced, traced.indistinguishable[r]),
                  fmt::format("{}unidentifiable/{}", key, r)) +
            "</li>\n";
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
          fmt::format("</div>\n<details><summary>{} further effects</summary>\n<div "
                      "class=\"effects\">\n",
                      order.size() - kShown));
    const TracedEffect& traced = result.trace.effects[k];
    const HeldOutGain* gain = k < result.gains.size() ? &result.gains[k] : nullptr;
    const std::string key = index_key("effects", k);
    page.add("<div class=\"effect\"><h3>" +
             keyed(for_the_cell(traced, gain, robot), key + "sentence") + "</h3>\n" +
             share_bar(traced.variance_share.value) +
             paragraph(keyed_share(traced.variance_share.value, key + "variance_share") +
                       " of what the effects explain <span class=\"quiet\">(" +
                       keyed(to_string(traced.effect.parameter), key + "parameter") + " follows " +
                       keyed(to_string(traced.effect.driver), key + "driver") + " (" +
                       keyed(to_string(traced.effect.shape), key + "shape") + ")" + ")</span>"));
    page.pictures({effect_picture(traced, result.curves[k], robot, k)});
    page.add(folded("Statistics", statistics_of(result, k)) + "</div>\n");
  }
  page.add(folds ? "</div></details>\n" : "</div>\n");
}

void add_next(Page& page, const LoopResult& result, const std::string& next_poses) {
  page.section("What to measure next");
  std::vector<std::string> items;
  if (!next_poses.empty())
    items.push_back("the poses of <span class=\"file\" data-key=\"next_poses\">" +
                    escaped(next_poses) + "</span>, which tell the causes apart");
  for (size_t k = 0; k < result.trace.effects.size(); ++k) {
    const TracedEffect& traced = result.trace.effects[k];
    if (!traced.indistinguishable.empty() && !traced.separated_by.empty())
      items.push_back("for " + escaped(to_string(traced.effect.parameter)) + ": " +
                      keyed(traced.separated_by, index_key("effects", k) + "separated_by"));
  }
  if (result.verdict == Verdict::too_few_poses)
    items.push_back(fmt::format("some {} more poses like these", result.more_poses));
  if (result.verdict == Verdict::unknown_noise)
    items.push_back("every pose twice or more, driven to anew: repeats show the noise");
  if (result.verdict == Verdict::unexplained && result.explanation.empty()) {
    items.push_back("the same with time, temperatures and payload logged at each reading");
    items.push_back("repeats after driving to the pose anew, else the floor is too low");
    if (!result.pattern.empty())
      items.push_back(
          "the best candidate that was not added: " + keyed(result.pattern, "remaining/pattern") +
          ", p " + keyed(result.trace.remaining_p, "remaining/pattern_p"));
  }
  if (items.empty())
    items.push_back(
        "nothing to learn more from poses like these; poses where the arm will work "
        "show how far the result carries (evaluate-poses)");
  std::ranges::sort(items);
  items.erase(std::unique(items.begin(), items.end()), items.end());
  page.list(items);
}

std::string stages_table(const LoopResult& result) {
  std::vector<TableRow> rows;
  const auto row = [&](const Stage& stage, const std::string& key) {
    TableRow cells{keyed(stage.name, key + "name"),
                   keyed(std::to_string(stage.parameters), key + "parameters"),
                   keyed_mm(stage.training.position.mean, key + "training/position_mm/mean")};
    if (result.held_out_poses > 0) {
      const ErrorSummary& errors = stage.held_out.position;
      cells.push_back(keyed_mm(errors.mean, key + "held_out/position_mm/mean"));
      cells.push_back(keyed_mm(errors.p95, key + "held_out/position_mm/p95"));
      cells.push_back(keyed_mm(errors.max, key + "held_out/position_mm/max"));
    }
    rows.push_back(cells);
  };
  for (size_t k = 0; k < result.stages.size(); ++k) row(result.stages[k], index_key("stages", k));
  TableRow head{"stage", "unknowns", "training mean, mm"};
  if (result.held_out_poses > 0)
    for (const char* name : {"held-out mean, mm", "held-out 95 %, mm", "held-out max, mm"})
      head.push_back(name);
  std::string html = table(head, rows);
  if (result.worst)
    html += paragraph("The worst held-out pose is " +
                      keyed(result.worst->pose, "worst_held_out/pose") + ": " +
                      keyed_mm(result.worst->error, "worst_held_out/after_mm") +
                      " mm with the final model.");
  if (result.applied)
    html += paragraph(
        "The last line is the arm as it is applied: what it does besides has no name and is no "
        "finding, and the verdict does without it.");
  return html;
}

std::string nested_text(const NestedValidation& nested) {
  return paragraph("Nested cross-validation, the whole search repeated in " +
                   keyed(std::to_string(nested.folds), "nested_cv/folds") + " folds: mean error " +
                   keyed_mm(nested.before.mean, "nested_cv/before_mm") +
                   " mm with geometry alone, " + keyed_mm(nested.after.mean, "nested_cv/after_mm") +
                   " mm with what the search added (gain " +
                   keyed_mm(nested.gain.mean, "nested_cv/gain_mm") + " mm, standard error " +
                   keyed_mm(nested.gain.error, "nested_cv/gain_se_mm") + " mm).");
}

std::string axes_table(const LoopResult& result, const Judging& by) {
  std::vector<TableRow> rows;
  for (size_t k = 0; k < result.stages.size(); ++k) {
    const bool is_last = k + 1 == result.stages.size() && !result.rejected;
    const bool is_shown = k < 2 || is_last;
    const PoseErrors& errors =
        by.set == "held_out" ? result.stages[k].held_out : result.stages[k].training;
    for (const AxisErrors& axis : errors.axes) {
      if (!is_shown) continue;
      const std::string key = fmt::format("stages/{}/{}/axes_mm/{}/", k, by.set, axis.axis);
      rows.push_back({fmt::format("{}, {}", axis.axis,
                                  k == 0   ? "nominal robot"
                                  : k == 1 ? "calibrated geometry"
                                           : "with its effects"),
                      keyed_mm(axis.mean, key + "mean"), keyed_mm(axis.min, key + "min"),
                      keyed_mm(axis.max, key + "max")});
    }
  }
  return table({"axis", "mean, mm", "min, mm", "max, mm"}, rows);
}

void add_rest(Page& page, const LoopResult& result, const Judging& by) {
  std::string html = stages_table(result) + axes_table(result, by);
  if (result.nested) html += nested_text(*result.nested);
  if (result.lack_of_fit)
    html += paragraph("Lack of fit against the noise: p " +
                      keyed(*result.lack_of_fit, "remaining/lack_of_fit_p") + ".");
  page.folded_section("Details");
  page.add(folded("Stages of the model", html));
}

// Of the robot file, if one is written: it is fitted to all poses.
void add_parameters(Page& page, const LoopResult& result, const std::optional<FitToAll>& to_all,
                    const Robot& nominal, const Campaign& training) {
  const CalibrationResult& fit = to_all ? to_all->fit : result_of(result);
  const auto poses = (to_all ? to_all->sound : training).pose_ids.size();
  page.add(folded(
      fmt::format("{} parameters", fit.set.kept.size()),
      paragraph(fmt::format("Fitted to {} {}poses, beside the effects. A share of 1: the readings "
                            "say all; below a half the parameter stands near its nominal value. "
                            "Turns of base and tool have no number of their own; their change is "
                            "a rotation vector.",
                            poses, to_all ? "" : "training ")) +
          parameters_table(nominal, fit, static_cast<int>(poses), "robot:")));
}

}  // namespace

Report loop_page(const LoopResult& result, const std::optional<FitToAll>& to_all,
                 const Robot& nominal, const Campaign& training, const Campaign& held_out,
                 const std::string& next_poses, const PageHead& head) {
  const Campaign sound = without_gross(training, result.gross_poses);
  const Judging by = judging(result, sound, held_out);
  const std::vector<Judged> models = models_of(result, by.campaign);
  Page page(head, nominal.name, "Closing the loop");
  page.verdict(tone_of(result), badge_of(result.verdict),
               keyed(verdict_in_words(result), "sentence"));
  add_tiles(page, result, by);
  page.add(unseen_scale_text(result.scale, "unseen_scale/"));
  add_effects(page, result);
  add_joints(page, result);
  add_owners(page, result);
  add_next(page, result, next_poses);
  add_error_pictures(page, models, by.campaign, {}, by.words, upwards(nominal));
  add_readings_left_out(page, result.gross_poses, result.excluded_rows, "data/");
  add_rest(page, result, by);
  add_parameters(page, result, to_all, nominal, sound);
  return page.finish();
}

}  // namespace armtrue
