#include "loop_inputs.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "armtrue/calibration/hold_out.h"
#include "armtrue/diagnosis/mistakes.h"
#include "armtrue/diagnosis/stated_deviations.h"
#include "columns.h"

namespace armtrue::app {

bool LoopArguments::wants_fit() const {
  return !robot_out.empty() || !predictor_out.empty() || !parameters.empty() ||
         !correlations.empty();
}

bool LoopArguments::uses_all_poses() const {
  return nested_folds > 0 || wants_fit() || !residuals.empty() || !next_poses.empty();
}

void add_loop_options(Command& command, LoopArguments& arguments) {
  command.add_input("Measured poses");
  command.add_output(ProductKind::document);
  command.add_seed();
  command.add_new_sessions();
  command.file("--robot", arguments.robot, "The nominal robot").required();
  command.identify(arguments.identify);
  const Option share = command
                           .option("--held-out", arguments.held_out,
                                   "Share of the poses that is held out: no fit uses them")
                           .check(in_range(0.0, 0.9))
                           .default_shown();
  const Option region = command.flag(
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
      .check(in_range(2, 1000));
  command.add_output("--robot-out", arguments.robot_out, "Write the robot with its effects here",
                     ProductKind::document);
  command.add_output("--predictor-out", arguments.predictor_out,
                     "Write the same robot here too: the name of an option that scripts may have",
                     ProductKind::document);
  command.add_output("--residuals", arguments.residuals,
                     "Write the final residual of every reading here", ProductKind::table);
  add_parameter_tables(command, arguments.parameters, arguments.correlations);
  add_report(command, arguments.page, "with verdict, causes, errors and pictures");
  command.add_output("--next-poses", arguments.next_poses,
                     "Write 15 poses here that separate the causes that these readings cannot, if "
                     "poses can; plan-poses --separate plans others",
                     ProductKind::table);
  command.file("--catalogue", arguments.catalogue, "Effects to look for");
  command.flag("--only-catalogue", arguments.only_catalogue, "Do not search beyond the catalogue");
  command.flag("--no-priors", arguments.no_priors,
               "Least squares without priors: the readings alone determine the links");
  command.add_columns(kMeasuredPoseColumns);
}

MeasuredLoop read_measured_loop(Command& command, const LoopArguments& arguments,
                                const Robot& robot) {
  std::error_code missing;  // of standard input, or a file that reading names
  if (!arguments.test.empty() &&
      std::filesystem::equivalent(arguments.test, command.input, missing) && !missing)
    throw InputError(arguments.test +
                     ": --test and FILE are the same file; --test needs poses that no fit uses");
  MeasuredLoop measured;
  measured.all = command.read_campaign(command.input, robot);
  warn_of_all(command, {trust_usual_deviation(robot, measured.all)});
  refuse_mistakes(command, robot, measured.all);
  const SensorError sensor = command.sensor_error;
  sensor.take_off(measured.all, robot.chain);
  command.warn_if_needless(robot, measured.all);
  if (arguments.test.empty()) {
    HeldOut held_out = hold_out(robot, measured.all,
                                {arguments.held_out, arguments.held_out_region, command.seed});
    warn_of_all(command, {held_out.fewer});
    measured.split = std::move(held_out.split);
    measured.training = measured.all.select(measured.split.training);
    measured.held_out = measured.all.select(measured.split.held_out);
    if (!arguments.uses_all_poses() && !command.warned_of_change) measured.all = {};
  } else {
    measured.training = measured.all;
    measured.held_out = command.read_campaign(arguments.test, robot, Command::Copies::keep);
    sensor.take_off(measured.held_out, robot.chain);
    warn_of_all(command, {trust_usual_deviation(robot, measured.held_out)});
    refuse_mistakes(command, robot, measured.held_out);
  }
  if (const std::string why = why_not_apart(measured.training, measured.held_out); !why.empty())
    throw InputError(why);
  warn_of_all(command, {repeats_in_words(measured.training, measured.held_out)});
  return measured;
}

}  // namespace armtrue::app
