#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/camera_summary.h"
#include "armtrue/calibration/doubts.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/gross_poses.h"
#include "armtrue/calibration/worthwhile.h"
#include "armtrue/diagnosis/mistakes.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/calibration_io.h"
#include "armtrue/io/products/residuals_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/report/calibration_page.h"
#include "armtrue/text/number_text.h"
#include "calibration_inputs.h"
#include "command_line.h"
#include "option_text.h"
#include "report_arguments.h"

using namespace armtrue;

namespace {

// The warning for a calibration that misses a criterion; nothing if it meets all.
std::optional<std::string> missed_criterion(const CalibrationResult& result, const Robot& robot,
                                            const Campaign& campaign, const Evaluation& evaluation,
                                            const std::vector<int>& blunders, double max_error_mm) {
  for (const std::string& why : {not_converged(result), lost_in_words(robot, campaign, result),
                                 beyond_any_arm(result.robot, campaign, evaluation, blunders)})
    if (!why.empty()) return why;
  if (max_error_mm == 0) return std::nullopt;
  const double worst = summarize(evaluation.reading_errors()).max / kMillimetre;
  if (worst <= max_error_mm) return std::nullopt;
  return fmt::format("the largest error, {:.4g} mm, is above {:g} mm", worst, max_error_mm);
}

void warn_of_doubts(app::Command& command, const Robot& robot, const Campaign& all,
                    const Campaign& campaign, const CalibrationResult& result,
                    const Evaluation& evaluation, const CalibrationFindings& findings,
                    const std::string& far_above) {
  std::vector<int> lines = campaign.lines_of(findings.quality->blunders);
  if (!lines.empty() && !beyond_any_arm(result.robot, campaign, evaluation).empty())
    command.warn("left out as blunders: " + lines_in_words(lines));
  std::ranges::copy(all.lines_of(rows_of(findings.gross)), std::back_inserter(lines));
  std::ranges::sort(lines);
  app::warn_of_all(command, {left_out_together(all, lines),
                             findings.zone ? ""
                                           : contradiction_of_noise(robot, campaign, result,
                                                                    findings.quality->noise),
                             far_above});
}

void report_not_shown(const app::Command& command, const CalibrationResult& result,
                      const Campaign& campaign) {
  if (campaign.has_pixels_only()) {  // nothing to enter
    if (!set_up_not_shown(result.robot.chain, result.set).empty())
      command.report(
          "the tool stays as the robot file has it: the places of camera and board are "
          "relative to it\n");
    return;
  }
  for (const int parameter : set_up_not_shown(result.robot.chain, result.set))
    command.report(not_shown(result.robot.chain, parameter) + "\n");
}

void report_fit(const app::Command& command, const Robot& nominal, const CalibrationResult& result,
                const Campaign& campaign, const Evaluation& evaluation) {
  const std::vector<double> errors = evaluation.reading_errors();
  const ErrorSummary left = summarize(errors);
  command.report(fmt::format(
      "{}, {}: {} of rank {} after {}; these readings are left "
      "with {:.4g} mm, mean, and {:.4g} mm at most\n",
      counted(campaign.pose_ids.size(), "pose"), counted(errors.size(), "reading"),
      counted(result.names.size(), "unknown"), result.rank, counted(result.iterations, "iteration"),
      left.mean / kMillimetre, left.max / kMillimetre));
  if (!command.reports()) return;
  for (const std::string& sentence : cameras_in_words(nominal, result, campaign, evaluation))
    command.report(sentence + "\n");
}

int run(app::Command& command, const app::CalibrationArguments& arguments) {
  const Robot robot = app::robot_to_calibrate(command, arguments);
  Campaign all = app::campaign_to_fit(command, arguments, robot);
  const std::optional<About> about = app::read_about(command, arguments.page);
  command.progress("identifying");
  const std::vector<GrossPose> gross = find_gross_poses(robot, all);
  const bool all_as_read = gross.empty() && arguments.zone.empty();
  Campaign changed;  // a copy of many rows takes its memory
  if (!all_as_read) changed = without_gross(all, gross);
  const Campaign& campaign = all_as_read ? all : changed;
  app::warn_of_all(command, off_as_wholes(gross));
  std::optional<WeightedZone> zone;
  Campaign unweighted;
  if (!arguments.zone.empty()) {
    unweighted = changed;
    zone = weight_by_zone(changed, robot, app::zone_from_text(arguments.zone));
    app::warn_of_all(command, {far_from_readings(*zone)});
  }
  const Campaign& as_read = zone ? unweighted : campaign;

  CalibrationResult result = calibrate(robot, campaign);
  app::warn_of_all(command, not_shown_by_touches(robot, campaign, result.set));
  Evaluation evaluation = evaluate(result.robot, campaign);
  CalibrationFindings findings{zone, gross, {}, assess(result, campaign, evaluation)};
  // The weights of a zone are not the noise of the readings.
  if (zone)
    findings.quality->noise =
        noise_floor_without(findings.quality->blunders, result.robot, as_read);
  findings.nominal = require_worthwhile(robot, result, campaign, evaluation.position,
                                        findings.quality->blunders,
                                        static_cast<int>(rows_of(gross).size()));
  if (!findings.nominal) findings.nominal = placed_on_targets(robot, result, campaign);
  std::string far_above;
  if (!zone) {  // with one the readings outside are not meant to fit
    far_above = far_above_noise(*findings.quality);
    widen_deviations(times_of_noise(*findings.quality), result);
  }
  warn_of_doubts(command, robot, all, as_read, result, evaluation, findings, far_above);
  const auto missed = missed_criterion(result, robot, as_read, evaluation,
                                       findings.quality->blunders, arguments.max_error_mm);
  if (missed) command.warn(*missed);
  if (!command.wrong_readings.empty()) command.warn("do not correct programs with this result");
  if (!arguments.residuals.empty()) {
    const std::vector<std::string> split(all.rows(), "training");
    write_output(arguments.residuals,
                 write_residuals({{all, evaluate(result.robot, all).residuals, split}}));
  }
  app::write_parameter_tables(arguments.parameters, arguments.correlations, robot, result,
                              campaign.poses());
  report_fit(command, robot, result, campaign, evaluation);
  const Document product =
      write_calibration(result, campaign, std::move(evaluation), command.provenance(), findings);
  write_output(command.output, product);
  command.report_written(command.output);
  if (const std::string near = near_nominal_in_words(result, campaign); !near.empty())
    command.report(near + "\n");
  report_not_shown(command, result, campaign);
  if (arguments.page.is_wanted())
    app::write_report(command, arguments.page,
                      calibration_page(result, robot, campaign,
                                       {gross, findings.nominal, *findings.quality, missed},
                                       app::page_head(command, product, about)));
  return missed || !command.wrong_readings.empty() ? app::kNotReached : app::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("calibrate", "Identify the parameters of a robot from measured poses.",
                       "calibrate --robot robot.yaml measured.csv > calibrated.yaml\n"
                       "  calibrate --robot robot.yaml --new-session-at-s 1234 knocked.csv");
  app::CalibrationArguments arguments;
  app::add_calibration_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
