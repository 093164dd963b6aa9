#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "armtrue/calibration/doubts.h"
#include "armtrue/campaign/split.h"
#include "armtrue/diagnosis/mistakes.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/calibration_io.h"
#include "armtrue/io/products/loop_io.h"
#include "armtrue/io/products/residuals_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/planning/separation.h"
#include "armtrue/report/loop_page.h"
#include "armtrue/report/loop_table.h"
#include "armtrue/text/input_error.h"
#include "armtrue/tracing/loop.h"
#include "armtrue/tracing/loop_doubts.h"
#include "columns.h"
#include "command_line.h"
#include "report_arguments.h"

using namespace armtrue;

namespace {

constexpr int kNextPoses = 15;

struct Arguments {
  std::string robot, identify, catalogue, test, robot_out, predictor_out, residuals, next_poses,
      parameters, correlations;
  app::ReportArguments page;
  double held_out = 0.25;
  int nested_folds = 0;  // 0: no nested validation
  bool only_catalogue = false, no_priors = false, held_out_region = false;
};

void add_options(app::Command& command, Arguments& arguments) {
  command.add_input("Measured poses");
  command.add_output(app::ProductKind::document);
  command.add_seed();
  command.add_new_sessions();
  command.file("--robot", arguments.robot, "The nominal robot").required();
  command.identify(arguments.identify);
  const app::Option share = command
                                .option("--held-out", arguments.held_out,
                                        "Share of the poses that is held out: no fit uses them")
                                .check(app::in_range(0.0, 0.9))
                                .default_shown();
  const app::Option region = command.flag(
      "--held-out-region", arguments.held_out_region,
      "Hold out one end of the measured region and not random poses, to see how well the "
      "result holds elsewhere; --seed 1 to 6 chooses the end, the farthest first");
  command.file("--test", arguments.test, "Held-out poses from a separate file")
      .excludes(share)
      .excludes(region);
  command
      .option("--nested", arguments.nested_folds,
              "Number of folds of a nested cross-validation, beside the held-out error: repeat the "
              "whole search in each fold of all measured poses, evaluate it on the poses left out, "
              "and count how often each effect is found again; takes about that many times as long")
      .check(app::in_range(2, 1000));
  command.add_output("--robot-out", arguments.robot_out, "Write the robot with its effects here",
                     app::ProductKind::document);
  command.add_output("--predictor-out", arguments.predictor_out,
                     "Write the same robot here too: the name of an option that scripts may have",
                     app::ProductKind::document);
  command.add_output("--residuals", arguments.residuals,
                     "Write the final residual of every reading here");
  app::add_parameter_tables(command, arguments.parameters, arguments.correlations);
  app::add_report(command, arguments.page, "with verdict, causes, errors and pictures");
  command.add_output("--next-poses", arguments.next_poses,
                     "Write 15 poses here that separate the causes that these readings cannot, if "
                     "poses can; plan-poses --separate plans others");
  command.file("--catalogue", arguments.catalogue, "Effects to look for");
  command.flag("--only-catalogue", arguments.only_catalogue, "Do not search beyond the catalogue");
  command.flag("--no-priors", arguments.no_priors,
               "Least squares without priors: the readings alone determine the links");
  command.add_columns(app::kMeasuredPoseColumns);
}

// The measured poses: those that the search may use and the held-out ones.
struct Measured {
  Campaign all;  // of the file that is searched; empty if nobody asks for it after the split
  Split split;   // of `all`; empty with --test
  Campaign training, held_out;
};

// A reading in both parts would test a model that was fitted to it.
void check_apart(const Campaign& training, const Campaign& test) {
  const auto shared = shared_reading(training, test);
  if (!shared) return;
  const bool is_one_file = training.source == test.source;
  throw InputError(fmt::format(
      "{}:{}: this reading stands in {} too{}", test.source, test.line[shared->test],
      is_one_file ? fmt::format("line {}", training.line[shared->training]) : training.source,
      is_one_file ? ", as another pose; a copy shows nothing new: remove it, or give both the "
                    "same pose"
                  : "; --test needs poses that no fit uses"));
}

void warn_of_repeats(app::Command& command, const Campaign& training, const Campaign& test) {
  const RepeatedPoses poses = repeated_poses(training, test);
  if (poses.repeated == 0) return;
  command.warn(fmt::format(
      "{}: {} of {} held-out poses stand at the joint angles of training poses (pose {} at those "
      "of {}): they are repeats, and their error says nothing of other poses; {}",
      test.source, poses.repeated, poses.of, poses.test, poses.training,
      training.source == test.source ? "give the repeats of a pose one name"
                                     : "give --test other poses"));
}

Measured read_measured(app::Command& command, const Arguments& arguments, const Robot& robot) {
  Measured measured;
  measured.all = command.read_campaign(command.input, robot);
  if (measured.all.has_pixels() && !arguments.next_poses.empty())
    throw InputError(measured.all.source +
                     ": poses are not planned for images; leave out --next-poses");
  app::refuse_mistakes(command, robot, measured.all);
  command.warn_if_needless(robot, measured.all);
  if (arguments.test.empty()) {
    measured.split = arguments.held_out_region
                         ? split_by_region(robot, measured.all, arguments.held_out, command.seed)
                         : split_by_pose(measured.all, arguments.held_out, command.seed);
    measured.training = measured.all.select(measured.split.training);
    measured.held_out = measured.all.select(measured.split.held_out);
    check_apart(measured.training, measured.held_out);
    warn_of_repeats(command, measured.training, measured.held_out);
    const bool is_asked_for =
        arguments.nested_folds > 0 ||
        std::ranges::any_of(
            std::array{arguments.residuals, arguments.next_poses, arguments.robot_out,
                       arguments.predictor_out, arguments.parameters, arguments.correlations},
            [](const std::string& path) { return !path.empty(); });
    if (!is_asked_for) measured.all = {};
  } else {
    measured.training = measured.all;
    measured.held_out = command.read_campaign(arguments.test, robot);
    app::refuse_mistakes(command, robot, measured.held_out);
    check_apart(measured.training, measured.held_out);
    warn_of_repeats(command, measured.training, measured.held_out);
  }
  return measured;
}

// All readings but those of gross training poses.
Campaign sound_of_all(const Measured& measured, const LoopResult& result) {
  std::set<int> off;
  for (int row : rows_of(result.gross_poses))
    off.insert(measured.split.training.empty() ? row : measured.split.training[row]);
  std::vector<int> rows;
  for (int row = 0; row < measured.all.rows(); ++row)
    if (!off.contains(row)) rows.push_back(row);
  return measured.all.select(rows);
}

LoopResult search(app::Command& command, const Arguments& arguments, const Robot& robot,
                  const Measured& measured, const TraceOptions& options) {
  const Catalogue catalogue = app::catalogue(arguments.catalogue);
  LoopResult result = close_loop(robot, measured.training, measured.held_out, catalogue, options);
  app::warn_of_all(command, off_as_wholes(result.gross_poses));
  if (arguments.nested_folds > 0) {
    command.progress("repeating the search in " + std::to_string(arguments.nested_folds) +
                     " folds");
    result.nested = nested_validation(robot, sound_of_all(measured, result), catalogue,
                                      arguments.nested_folds, result.trace.effects, options);
  }
  return result;
}

std::string residuals(const Robot& robot, const Measured& measured, bool with_test) {
  std::vector<std::string> split(measured.all.rows(), "training");
  for (int row : measured.split.held_out) split[row] = "held-out";
  std::vector<Residuals> parts = {{measured.all, evaluate(robot, measured.all).residuals, split}};
  if (with_test && measured.held_out.rows() > 0)
    parts.push_back({measured.held_out, evaluate(robot, measured.held_out).residuals,
                     std::vector<std::string>(measured.held_out.rows(), "held-out")});
  return write_residuals(parts);
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
std::optional<FitToAll> fit_for_products(app::Command& command, const Arguments& arguments,
                                         const Measured& measured, const LoopResult& result) {
  if (arguments.robot_out.empty() && arguments.predictor_out.empty() &&
      arguments.parameters.empty() && arguments.correlations.empty())
    return std::nullopt;
  if (measured.split.held_out.empty())
    return FitToAll{result_of(result), result.gross_poses,
                    without_gross(measured.training, result.gross_poses)};
  command.progress("fitting the result to all poses");
  return fit_to_all(result, measured.all, app::catalogue(arguments.catalogue));
}

void write_fit(const Arguments& arguments, const Robot& nominal, const FitToAll& fit,
               const Provenance& provenance) {
  if (!arguments.robot_out.empty() || !arguments.predictor_out.empty()) {
    const Document robot =
        write_calibration(fit.fit, fit.sound, provenance, {.gross = fit.gross_poses});
    for (const std::string& path : {arguments.robot_out, arguments.predictor_out})
      if (!path.empty()) write_output(path, robot);
  }
  app::write_parameter_tables(arguments.parameters, arguments.correlations, nominal, fit.fit,
                              static_cast<int>(fit.sound.pose_ids.size()));
}

int run(app::Command& command, const Arguments& arguments) {
  Robot robot = command.read_robot(arguments.robot).robot;
  command.warn_if_calibrated(robot, arguments.robot);
  command.forget_remainder(robot, arguments.robot);
  app::use_identify(arguments.identify, robot);
  robot.free_links = arguments.no_priors;
  const std::optional<About> about = app::read_about(command, arguments.page);
  const Measured measured = read_measured(command, arguments, robot);
  TraceOptions options;
  options.seed = command.seed;
  options.beyond_catalogue = !arguments.only_catalogue;
  options.progress = [&](const std::string& what) { command.progress(what); };
  const LoopResult result = search(command, arguments, robot, measured, options);
  const LoopDoubts doubts = doubts_of_loop(robot, measured.training, result);
  app::warn_of_all(command, doubts.sentences);
  const Provenance provenance = command.provenance();
  const std::optional<FitToAll> fit = fit_for_products(command, arguments, measured, result);
  if (fit) write_fit(arguments, robot, *fit, provenance);
  if (!arguments.residuals.empty())
    write_output(arguments.residuals,
                 residuals(result_of(result).robot, measured, !arguments.test.empty()));
  const bool planned = !arguments.next_poses.empty() &&
                       write_next_poses(command, arguments.next_poses, result.trace, measured.all);
  const std::string next_poses = planned ? arguments.next_poses : "";
  write_output(command.output, write_loop(result, options, provenance, next_poses));
  command.report(before_after_table(result));
  const std::string to_all =
      measured.split.held_out.empty()
          ? ""
          : fmt::format(", fitted to all {} poses", measured.all.pose_ids.size());
  for (const std::string& path : {arguments.robot_out, arguments.predictor_out})
    if (!path.empty() && path != "-") command.report("wrote " + path + to_all + "\n");
  for (const std::string& path : {arguments.residuals, command.output})
    if (!path.empty() && path != "-") command.report("wrote " + path + "\n");
  if (arguments.page.is_wanted())
    app::write_report(command, arguments.page,
                      loop_page(result, fit, robot, measured.training, measured.held_out,
                                next_poses, app::page_head(command, about)));
  return doubts.may_be_used ? app::kSuccess : app::kNotReached;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command(
      "close-loop",
      "Calibrate, find the effects that the model lacks, add them, and report the error before and "
      "after on held-out poses.",
      "close-loop --robot robot.yaml measured.csv --robot-out closed.yaml > loop.yaml\n"
      "  close-loop --robot robot.yaml knocked.csv --new-session-at-s 1234 > loop.yaml");
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
