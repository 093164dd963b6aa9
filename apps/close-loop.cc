#include <fmt/format.h>

#include <set>

#include "armtrue/io/output.h"
#include "armtrue/io/report_io.h"
#include "armtrue/planning/separation.h"
#include "armtrue/report/loop_report.h"
#include "armtrue/text/input_error.h"
#include "armtrue/tracing/loop.h"
#include "command_line.h"

using namespace armtrue;

namespace {

constexpr int kNextPoses = 15;

struct Paths {
  std::string robot, catalogue, test, robot_out, predictor_out, residuals, report, next_poses;
};

std::string residuals(const Robot& robot, const Campaign& measured, const Split& split,
                      const Campaign& test) {
  std::vector<std::string> names(measured.rows(), "training");
  for (int row : split.held_out) names[row] = "held-out";
  std::vector<Residuals> all = {{measured, evaluate(robot, measured).residuals, names}};
  if (test.rows() > 0)
    all.push_back(
        {test, evaluate(robot, test).residuals, std::vector<std::string>(test.rows(), "held-out")});
  return write_residuals(all);
}

// Poses that tell apart what was found from what it cannot be told from; none if no poses do.
std::vector<JointVector> next_poses(const TraceResult& found, const Campaign& measured,
                                    std::uint64_t seed) {
  CloudOptions options;
  options.seed = seed;
  return plan_separation(found.fit.robot, found.effects, kNextPoses, options, measured).poses;
}

// Readings that are in both files took part.
void check_apart(const Campaign& training, const Campaign& test) {
  const auto reading = [](const Campaign& campaign, int row) {
    std::vector<double> numbers(campaign.q[row].begin(), campaign.q[row].end());
    if (!campaign.position.empty())
      numbers.insert(numbers.end(), campaign.position[row].begin(), campaign.position[row].end());
    if (!campaign.distance.empty()) numbers.push_back(campaign.length(row));
    return numbers;
  };
  std::set<std::vector<double>> known;
  for (int row = 0; row < training.rows(); ++row) known.insert(reading(training, row));
  for (int row = 0; row < test.rows(); ++row)
    if (known.contains(reading(test, row)))
      throw InputError(
          fmt::format("{}:{}: this reading stands in {} too; --test is for poses that take no part",
                      test.source, test.line[row], training.source));
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
    check_apart(training, held_out);
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
    write_output(paths.residuals, residuals(result.trace.fit.robot, all, split,
                                            paths.test.empty() ? Campaign() : held_out));
  std::vector<JointVector> planned;
  if (!paths.next_poses.empty()) {
    command.progress("planning the next poses");
    planned = next_poses(result.trace, all, command.seed);
    // Written in any case, or the poses of another campaign could stay.
    write_output(paths.next_poses, write_joint_targets(app::numbered(planned, all.pose_ids)));
    if (planned.empty())
      command.warn(paths.next_poses +
                   " holds no poses: there is nothing that poses would tell apart");
  }
  write_output(command.output,
               write_loop(result, options, provenance, planned.empty() ? "" : paths.next_poses));
  if (!paths.report.empty())
    write_output(paths.report,
                 loop_report(result, effect_descriptions(result), robot.name + ": " + all.source));
  command.tell(before_after_table(result));
  if (!result.trace.fit.converged) {
    command.warn(app::not_converged(result.trace.fit));
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
  command.add_output("--robot-out", paths.robot_out, "Write the robot with its effects here");
  command.add_output("--predictor-out", paths.predictor_out,
                     "Write a robot here that only predicts: to the effects that are named it adds "
                     "many small ones, none of which is a finding, where poses left out gain");
  command.add_output("--residuals", paths.residuals,
                     "Write the final residual of every reading here");
  command.add_output("--report", paths.report, "Write a page with plots (HTML) here");
  command.add_output("--next-poses", paths.next_poses,
                     "Write 15 poses that tell apart what this data cannot here, if any do; "
                     "plan-poses --separate plans others");
  options.add_option("--catalogue", paths.catalogue, "Effects to look for");
  options.add_flag("--only-catalogue", only_catalogue, "Do not search beyond the catalogue");
  return command.run(argc, argv,
                     [&] { return work(command, paths, held_out, nested_folds, only_catalogue); });
}
