#include <fmt/format.h>

#include <algorithm>
#include <cmath>
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
#include "columns.h"
#include "command_line.h"
#include "option_text.h"
#include "report_arguments.h"

using namespace armtrue;

namespace {

struct Arguments {
  std::string robot, identify, identify_per_session, residuals, zone, parameters, correlations;
  double max_error_mm = 0;  // 0: no limit
  bool no_priors = false;
  app::ReportArguments page;
};

void add_options(app::Command& command, Arguments& arguments) {
  command.add_input("Measured poses");
  command.add_output(app::ProductKind::document);
  command.file("--robot", arguments.robot, "The nominal robot").required();
  command.identify(arguments.identify);
  command.option(
      "--identify-per-session", arguments.identify_per_session,
      "Zero offsets that each session has of its own, like its base, such as A2.theta,A5.theta "
      "after a re-mastering; replaces 'identify_per_session' of the robot file");
  command.add_new_sessions();
  command.add_output("--residuals", arguments.residuals,
                     "Write the residual of every reading here");
  app::add_parameter_tables(command, arguments.parameters, arguments.correlations);
  command.zone(arguments.zone,
               "Sphere x,y,z,radius in R_A in which the arm must be accurate: the farther a "
               "reading is outside, the less it counts");
  command
      .option("--max-error-mm", arguments.max_error_mm,
              "Exit with 3 if calibration: training: position_mm: max, the largest error of "
              "the readings, is larger")
      .check(app::above_zero());
  command.flag("--no-priors", arguments.no_priors,
               "Least squares without priors: the readings alone determine the links");
  app::add_report(command, arguments.page, "with errors before and after, maps and parameters");
  command.add_columns(app::kMeasuredPoseColumns);
}

// weight_by_zone() multiplies the sigma of a reading at the distance d outside a sphere of radius r
// by sqrt(1 + (d / r)^2). The smallest factor shows how far outside the nearest reading lies.
WeightedZone weight_readings_by_zone(app::Command& command, Campaign& campaign, const Robot& robot,
                                     const Zone& zone) {
  Campaign weighted = campaign;
  weighted.sigma_position.assign(campaign.rows(), 1.0);
  weight_by_zone(weighted, robot, zone);
  const std::vector<double>& factors = weighted.sigma_position;
  const double least = *std::ranges::min_element(factors);
  const double outside = zone.radius * std::sqrt(least * least - 1);
  if (outside > zone.radius)
    command.warn(fmt::format(
        "no reading lies in the zone or near it, the nearest {:.4g} mm outside: what the robot "
        "will do there is extrapolated; measure poses in it (plan-poses --zone), or correct "
        "--zone, which is x,y,z,radius in mm in the instrument's frame",
        outside / kMillimetre));
  weight_by_zone(campaign, robot, zone);
  return {zone, static_cast<int>(std::ranges::count(factors, 1.0))};
}

// A zone weighs the readings with standard deviations that are not theirs: their noise is that of
// the readings without them.
NoiseFloor noise_of(const CalibrationResult& result, const Campaign& as_read,
                    const std::vector<int>& blunders) {
  std::vector<int> sound;
  for (int row = 0; row < as_read.rows(); ++row)
    if (!std::ranges::binary_search(blunders, row)) sound.push_back(row);
  const Campaign readings = as_read.select(sound);
  return noise_floor(result.robot, readings, evaluate(result.robot, readings));
}

// The warning for a calibration that misses a criterion; nothing if it meets all.
std::optional<std::string> missed_criterion(const CalibrationResult& result, const Robot& robot,
                                            const Campaign& campaign, const Evaluation& evaluation,
                                            double max_error_mm) {
  for (const std::string& why : {not_converged(result), lost_in_words(robot, campaign, result),
                                 beyond_any_arm(result.robot, campaign, evaluation)})
    if (!why.empty()) return why;
  if (max_error_mm == 0) return std::nullopt;
  const double worst = summarize(evaluation.reading_errors()).max / kMillimetre;
  if (worst <= max_error_mm) return std::nullopt;
  return fmt::format("the largest error, {:.4g} mm, is above {:g} mm", worst, max_error_mm);
}

void report_near_nominal(const app::Command& command, const CalibrationResult& result,
                         const Campaign& campaign) {
  const NearNominal near = near_nominal(result, campaign);
  if (near.parameters.empty()) return;
  std::string names;
  for (int k : near.parameters) names += (names.empty() ? "" : ", ") + result.names[k];
  command.report(
      names + ": near the nominal value for lack of readings; " +
      (near.poses > 0
           ? fmt::format("some {} more poses like these would determine them", near.poses)
           : "no number of poses like these would determine them; move every joint "
             "over its travel") +
      "\n");
}

void warn_of_doubts(app::Command& command, const Robot& robot, const Campaign& all,
                    const Campaign& campaign, const CalibrationResult& result,
                    const CalibrationFindings& findings, const std::string& far_above) {
  std::vector<int> lines;
  for (int row : findings.quality->blunders) lines.push_back(campaign.line[row]);
  for (int row : rows_of(findings.gross)) lines.push_back(all.line[row]);
  std::ranges::sort(lines);
  app::warn_of_all(command, {left_out_together(all, lines),
                             findings.zone ? ""
                                           : contradiction_of_noise(robot, campaign, result,
                                                                    findings.quality->noise),
                             far_above});
}

void report_not_shown(const app::Command& command, const CalibrationResult& result) {
  for (const int parameter : set_up_not_shown(result.robot.chain, result.set))
    command.report(not_shown(result.robot.chain, parameter) + "\n");
}

void report_fit(const app::Command& command, const Robot& nominal, const CalibrationResult& result,
                const Campaign& campaign, const Evaluation& evaluation) {
  const std::vector<double> errors = evaluation.reading_errors();
  const ErrorSummary left = summarize(errors);
  command.report(fmt::format(
      "{} poses, {} readings: {} unknowns of rank {} after {} iterations; these readings are left "
      "with {:.4g} mm, mean, and {:.4g} mm at most\n",
      campaign.pose_ids.size(), errors.size(), result.names.size(), result.rank,
      result.iterations, left.mean / kMillimetre, left.max / kMillimetre));
  if (!command.reports()) return;
  for (const std::string& sentence : cameras_in_words(nominal, result, campaign, evaluation))
    command.report(sentence + "\n");
}

// The nominal robot with base and targets placed, where the targets stand for the tool.
std::optional<Robot> placed_on_targets(const Robot& nominal, const CalibrationResult& result,
                                       const Campaign& campaign) {
  if (campaign.target_names.empty() ||
      std::ranges::find(result.set.kept, kFirstBaseParameter) == result.set.kept.end())
    return std::nullopt;
  return placed_nominal(nominal, campaign);
}

// Directions and ways of the joints, a fifth of a million readings, go once the readings have been
// checked, if no effect of the robot follows them.
void drop_unused_motion(const Robot& robot, Campaign& campaign) {
  const auto follows = [](const Effect& effect) {
    return effect.driver.involves(DriverKind::arrival) ||
           effect.driver.involves(DriverKind::stroke);
  };
  if (std::ranges::any_of(robot.effects, [&](const Effect& effect) {
        return follows(effect) || std::ranges::any_of(effect.members, follows);
      }))
    return;
  campaign.stroke.clear();
  campaign.arrival = std::vector<Direction>();
}

int run(app::Command& command, const Arguments& arguments) {
  Robot robot = command.read_robot(arguments.robot).robot;
  command.warn_if_calibrated(robot, arguments.robot);
  command.forget_remainder(robot, arguments.robot);
  app::use_identify(arguments.identify, robot);
  if (!arguments.identify_per_session.empty())
    robot.identify_per_session = app::split_list(arguments.identify_per_session);
  robot.free_links = arguments.no_priors;
  Campaign all = command.read_campaign(command.input, robot);
  if (!arguments.identify_per_session.empty() && all.session_names.size() < 2)
    command.warn("--identify-per-session " + arguments.identify_per_session +
                 " changes nothing: " + all.source +
                 " is one session; name sessions in a column, or give --new-session-at-s");
  const std::optional<About> about = app::read_about(command, arguments.page);
  app::refuse_mistakes(command, robot, all);
  command.warn_if_needless(robot, all);
  drop_unused_motion(robot, all);
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
    zone = weight_readings_by_zone(command, changed, robot, app::zone_from_text(arguments.zone));
  }
  const Campaign& as_read = zone ? unweighted : campaign;

  CalibrationResult result = calibrate(robot, campaign);
  app::warn_of_all(command, not_shown_by_touches(robot, campaign, result.set));
  Evaluation evaluation = evaluate(result.robot, campaign);
  CalibrationFindings findings{zone, gross, {}, assess(result, campaign, evaluation)};
  if (zone) findings.quality->noise = noise_of(result, as_read, findings.quality->blunders);
  findings.nominal = require_worthwhile(robot, result, campaign, evaluation.position,
                                        findings.quality->blunders,
                                        static_cast<int>(rows_of(gross).size()));
  if (!findings.nominal) findings.nominal = placed_on_targets(robot, result, campaign);
  std::string far_above;
  if (!zone) {  // with one the readings outside are not meant to fit
    far_above = far_above_noise(*findings.quality);
    widen_deviations(times_of_noise(*findings.quality), result);
  }
  warn_of_doubts(command, robot, all, as_read, result, findings, far_above);
  const auto missed = missed_criterion(result, robot, as_read, evaluation, arguments.max_error_mm);
  if (missed) command.warn(*missed);
  if (!arguments.residuals.empty()) {
    const std::vector<std::string> split(all.rows(), "training");
    write_output(arguments.residuals,
                 write_residuals({{all, evaluate(result.robot, all).residuals, split}}));
  }
  app::write_parameter_tables(arguments.parameters, arguments.correlations, robot, result,
                              static_cast<int>(campaign.pose_ids.size()));
  report_fit(command, robot, result, campaign, evaluation);
  write_output(command.output, write_calibration(result, campaign, std::move(evaluation),
                                                 command.provenance(), findings));
  command.report_written(command.output);
  report_near_nominal(command, result, campaign);
  report_not_shown(command, result);
  if (arguments.page.is_wanted())
    app::write_report(command, arguments.page,
                      calibration_page(result, robot, campaign,
                                       {gross, findings.nominal, *findings.quality, missed},
                                       app::page_head(command, about)));
  return missed ? app::kNotReached : app::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("calibrate", "Identify the parameters of a robot from measured poses.",
                       "calibrate --robot robot.yaml measured.csv > calibrated.yaml\n"
                       "  calibrate --robot robot.yaml --new-session-at-s 1234 knocked.csv");
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
