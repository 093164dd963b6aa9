#include "armtrue/identification/loop.h"
#include "armtrue/identification/separation.h"
#include "armtrue/io/input_error.h"
#include "armtrue/io/output.h"
#include "armtrue/io/report_io.h"
#include "armtrue/report/loop_report.h"
#include "command_line.h"

using namespace armtrue;

namespace {

constexpr int kNextPoses = 15;

struct Paths {
  std::string robot, catalogue, test, robot_out, predictor_out, residuals, report, next_poses;
};

std::vector<ResidualRow> residual_rows(const Robot& robot, const Campaign& all,
                                       const Split& split) {
  const Evaluation evaluation = evaluate(robot, all);
  std::vector<std::string> name(all.rows(), "training");
  for (int row : split.held_out) name[row] = "held-out";
  std::vector<ResidualRow> rows;
  for (int row = 0; row < all.rows(); ++row)
    rows.push_back({row, name[row], evaluation.residuals[row]});
  return rows;
}

// Writes the poses that tell apart what was found from what it cannot be told from; returns whether
// there are any.
bool write_next_poses(const app::Command& command, const std::string& path,
                      const TraceResult& found, const Campaign& measured) {
  CloudOptions options;
  options.seed = command.seed;
  const SeparationPlan plan =
      plan_separation(found.fit.robot, found.effects, kNextPoses, options, measured);
  if (!plan.poses.empty())
    write_output(path, write_joint_targets(app::numbered(plan.poses, measured.pose_ids)));
  return !plan.poses.empty();
}

int work(app::Command& command, const Paths& paths, double held_out_share, int nested_folds,
         bool only_catalogue) {
  const Robot robot = command.robot(paths.robot).robot;
  const Campaign all = command.campaign(command.input, robot);
  Campaign training, held_out;
  Split split;
  if (paths.test.empty()) {
    split = split_by_pose(all, held_out_share, command.seed);
    training = all.select(split.training);
    held_out = all.select(split.held_out);
  } else {
    training = all;
    held_out = command.campaign(paths.test, robot);
  }
  TraceOptions options;
  options.seed = command.seed;
  options.beyond_catalogue = !only_catalogue;
  options.progress = [&](const std::string& what) { command.progress(what); };
  const Catalogue catalogue = app::catalogue(paths.catalogue);
  LoopResult result = close_loop(robot, training, held_out, catalogue, options);
  if (nested_folds > 0) {
    command.progress("repeating the search in " + std::to_string(nested_folds) + " folds");
    result.nested =
        nested_validation(robot, all, catalogue, nested_folds, result.trace.effects, options);
  }
  if (!paths.predictor_out.empty()) add_predictor(result, training, held_out, catalogue, options);

  const Provenance provenance = command.provenance();
  if (result.predictor)
    write_output(paths.predictor_out, write_robot(result.predictor->robot, provenance));
  if (!paths.robot_out.empty())
    write_output(paths.robot_out, write_calibration(result.trace.fit, training, provenance));
  if (!paths.residuals.empty())
    write_output(paths.residuals,
                 write_residuals(all, residual_rows(result.trace.fit.robot, all, split)));
  bool has_next_poses = false;
  if (!paths.next_poses.empty()) {
    command.progress("planning the next poses");
    has_next_poses = write_next_poses(command, paths.next_poses, result.trace, all);
    if (!has_next_poses)
      command.warn(paths.next_poses +
                   " is not written: there is nothing that poses would tell apart");
  }
  write_output(command.output,
               write_loop(result, options, provenance, has_next_poses ? paths.next_poses : ""));
  if (!paths.report.empty())
    write_output(paths.report,
                 loop_report(result, effect_descriptions(result), robot.name + ": " + all.source));
  command.tell(before_after_table(result));
  if (!result.trace.fit.converged) {
    command.warn("not converged: " + result.trace.fit.termination);
    return app::kNotReached;
  }
  return app::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command(
      "close-loop",
      "Calibrate, trace the residual to what the model lacks, add it, and report the error before "
      "and "
      "after on poses that took no part.",
      "close-loop --robot robot.yaml measured.csv --robot-out closed.yaml > loop.yaml\n"
      "  close-loop --robot robot.yaml knocked.csv --new-session-at-s 1234 > loop.yaml");
  Paths paths;
  double held_out = 0.25;
  int nested_folds = 0;
  bool only_catalogue = false;
  command.add_input("Measured poses");
  command.add_output();
  command.add_seed();
  command.add_new_sessions();
  CLI::App& options = command.options();
  options.add_option("--robot", paths.robot, "The nominal robot")->required();
  auto* share = options.add_option("--held-out", held_out, "Share of the poses set aside")
                    ->check(CLI::Range(0.0, 0.9))
                    ->capture_default_str();
  options
      .add_option("--test", paths.test,
                  "Measured poses that take no part, from a file of their own")
      ->excludes(share);
  options
      .add_option(
          "--nested", nested_folds,
          "Nested cross-validation beside the held-out figure: repeat the whole search in so "
          "many folds of all measured poses, judge each on the poses it left out, and count "
          "how often each effect is found again; takes about so many times as long")
      ->check(CLI::Range(2, 1000));
  options.add_option("--robot-out", paths.robot_out, "Write the robot with its effects here");
  options.add_option("--predictor-out", paths.predictor_out,
                     "Write a robot here that only predicts: to the effects that are named it adds "
                     "many small ones, none of which is a finding, where poses left out gain");
  options.add_option("--residuals", paths.residuals,
                     "Write the final residual of every reading here");
  options.add_option("--report", paths.report, "Write a page with plots (HTML) here");
  options.add_option("--next-poses", paths.next_poses,
                     "Write 15 poses that tell apart what this data cannot here, if any do; "
                     "plan-poses --separate plans others");
  options.add_option("--catalogue", paths.catalogue, "Effects to look for");
  options.add_flag("--only-catalogue", only_catalogue, "Do not search beyond the catalogue");
  return command.run(argc, argv,
                     [&] { return work(command, paths, held_out, nested_folds, only_catalogue); });
}
