#include <fmt/format.h>

#include "armtrue/calibration/doubts.h"
#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/calibration_io.h"
#include "armtrue/io/products/loop_io.h"
#include "armtrue/io/products/residuals_io.h"
#include "armtrue/planning/separation.h"
#include "armtrue/report/loop_page.h"
#include "armtrue/report/loop_table.h"
#include "armtrue/tracing/loop.h"
#include "armtrue/tracing/loop_doubts.h"
#include "loop_inputs.h"

using namespace armtrue;

namespace {

constexpr int kNextPoses = 15;

LoopResult search(app::Command& command, const app::LoopArguments& arguments, const Robot& robot,
                  const app::MeasuredLoop& measured, const TraceOptions& options) {
  const Catalogue catalogue = app::catalogue(arguments.catalogue);
  LoopResult result = close_loop(robot, measured.training, measured.held_out, catalogue, options,
                                 command.angles_read_early);
  app::warn_of_all(command, off_as_wholes(result.gross_poses));
  result.wrong_readings = command.wrong_readings;
  if (!result.wrong_readings.empty()) result.verdict = Verdict::unexplained;
  // A pose that is held out or left out may be the first after a change: all show its place.
  if (!result.explanation.empty() && command.warned_of_change)
    result.explanation =
        explanation_of_rest(result.trace.fit, measured.all).value_or(result.explanation);
  if (arguments.nested_folds > 0) {
    command.progress(fmt::format("repeating the search in {} folds", arguments.nested_folds));
    const Campaign sound = without_gross(measured.all, measured.split.training, result.gross_poses);
    result.nested = nested_validation(robot, sound, catalogue, arguments.nested_folds,
                                      result.trace.effects, options);
  }
  return result;
}

// Plans poses that separate each found effect from its rivals. Returns false if there are no such
// poses; the file is written in any case, so that poses of an earlier campaign do not stay in it.
bool write_next_poses(app::Command& command, const std::string& path, const TraceResult& found,
                      const Campaign& measured) {
  command.progress("planning the next poses");
  CloudOptions options;
  options.seed = command.seed;
  const std::vector<PlannedPose> planned =
      plan_separation(found.fit.robot, found.effects, kNextPoses, options, measured).poses;
  write_output(path, write_joint_targets(app::numbered(planned, measured.pose_ids),
                                         joint_names(found.fit.robot.chain)));
  if (planned.empty())
    command.warn(path + " holds no poses: there is nothing that poses could separate");
  return !planned.empty();
}

// The result fitted to all poses of the campaign, if a product holds it. With --test no pose of it
// was held out.
std::optional<FitToAll> fit_for_products(app::Command& command, const app::LoopArguments& arguments,
                                         const Robot& robot, const app::MeasuredLoop& measured,
                                         const LoopResult& result) {
  if (!arguments.wants_fit()) return std::nullopt;
  if (measured.split.held_out.empty())
    return FitToAll{result_of(result), result.gross_poses,
                    without_gross(measured.training, result.gross_poses)};
  command.progress("fitting the result to all poses");
  return fit_to_all(robot, result, measured.all, app::catalogue(arguments.catalogue));
}

void write_fit(const app::LoopArguments& arguments, const Robot& nominal, const FitToAll& fit,
               const Provenance& provenance) {
  for (const std::string& path : {arguments.robot_out, arguments.predictor_out})
    if (!path.empty())
      write_output(path,
                   write_calibration(fit.fit, fit.sound, provenance, {.gross = fit.gross_poses}));
  app::write_parameter_tables(arguments.parameters, arguments.correlations, nominal, fit.fit,
                              fit.sound.poses());
}

int run(app::Command& command, const app::LoopArguments& arguments) {
  Robot robot = command.read_robot(arguments.robot).robot;
  command.warn_if_calibrated(robot, arguments.robot);
  command.forget_remainder(robot, arguments.robot);
  app::use_identify(arguments.identify, robot);
  robot.free_links = arguments.no_priors;
  const std::optional<About> about = app::read_about(command, arguments.page);
  const app::MeasuredLoop measured = app::read_measured_loop(command, arguments, robot);
  TraceOptions options;
  options.seed = command.seed;
  options.beyond_catalogue = !arguments.only_catalogue;
  options.progress = [&](const std::string& what) { command.progress(what); };
  const LoopResult result = search(command, arguments, robot, measured, options);
  const LoopDoubts doubts = doubts_of_loop(robot, measured.training, result);
  app::warn_of_all(command, doubts.sentences);
  const Provenance provenance = command.provenance();
  const std::optional<FitToAll> fit = fit_for_products(command, arguments, robot, measured, result);
  if (fit) write_fit(arguments, robot, *fit, provenance);
  if (!arguments.residuals.empty())
    write_output(arguments.residuals,
                 write_residuals(result_of(result).robot, measured.all, measured.split,
                                 arguments.test.empty() ? Campaign() : measured.held_out));
  const bool planned = !arguments.next_poses.empty() &&
                       write_next_poses(command, arguments.next_poses, result.trace, measured.all);
  const std::string next_poses = planned ? arguments.next_poses : "";
  const Document product = write_loop(result, options, provenance, next_poses);
  write_output(command.output, product);
  command.report(before_after_table(result));
  const std::string to_all =
      measured.split.held_out.empty()
          ? ""
          : fmt::format(", fitted to all {} poses", measured.all.pose_ids.size());
  for (const std::string& path : {arguments.robot_out, arguments.predictor_out})
    command.report_written(path, to_all);
  for (const std::string& path : {arguments.residuals, command.output})
    command.report_written(path);
  if (arguments.page.is_wanted())
    app::write_report(
        command, arguments.page,
        loop_page(result, fit, robot, measured.training, judged_readings(result, measured.held_out),
                  app::page_head(command, product, about)));
  const bool may_be_used = doubts.may_be_used && result.wrong_readings.empty() && !result.moved;
  return may_be_used ? app::kSuccess : app::kNotReached;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command(
      "close-loop",
      "Calibrate, find the effects that the model lacks, add them, and report the error before and "
      "after on held-out poses.",
      "close-loop --robot robot.yaml measured.csv --robot-out closed.yaml > loop.yaml\n"
      "  close-loop --robot robot.yaml knocked.csv --new-session-at-s 1234 > loop.yaml");
  app::LoopArguments arguments;
  app::add_loop_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
