#include <fmt/format.h>

#include <algorithm>

#include "armtrue/io/output.h"
#include "armtrue/io/path_io.h"
#include "armtrue/text/number_text.h"
#include "option_text.h"
#include "pass_inputs.h"

using namespace armtrue;

namespace {

bool gives_way(const Robot& robot) {
  return std::any_of(robot.effects.begin(), robot.effects.end(),
                     [](const Effect& e) { return e.driver.involves(DriverKind::force); });
}

Path read_part(app::Command& command, const std::string& path, const PathFile& programmed,
               const Robot& robot) {
  const PathFile part = command.read_path(path, KeepRows::yes, robot);
  if (!part.path.has_times_of(programmed.path))
    throw InputError(part.source + ": its times are not those of " + programmed.source +
                     "; --part takes the program that this path corrects");
  return part.path;
}

int run(app::Command& command, const app::PassArguments& arguments) {
  PassOptions pass = app::pass_options(arguments, command.seed);
  const Robot robot = command.read_robot(arguments.robot).robot;
  const Robot truth = arguments.truth.empty() ? robot : command.read_robot(arguments.truth).robot;
  if (!arguments.truth.empty())
    app::require_one_arm(command, robot, arguments.robot, truth, arguments.truth);
  pass.joints.orientation_option = "--orientation-deg";
  pass.joints.start_option = "--start-deg";
  if (!arguments.start_deg.empty())
    pass.joints.start = app::joints_of(command, arguments.start_deg, robot, "--start-deg");
  const PathFile programmed = command.read_path(command.input, KeepRows::yes, robot);
  if (!arguments.part.empty()) pass.part = read_part(command, arguments.part, programmed, robot);
  if (arguments.depth_mm > 0 && !gives_way(truth))
    command.warn("no effect of the robot is driven by force: the cut moves nothing");
  command.progress("simulating");
  Path measured = app::on_samples_of(
      programmed, [&] { return simulate_pass(programmed.path, robot, truth, pass); });
  if (measured.samples() < 2)
    throw InputError(
        fmt::format("{}: the pass takes {:g} s, of which the instrument records {}; a record needs "
                    "two: give a shorter --instrument-period-ms (now {:g}) or lose less (--lost)",
                    programmed.source,
                    programmed.path.time[programmed.path.samples() - 1] - programmed.path.time[0],
                    counted(measured.samples(), "sample"), arguments.period_ms));
  if (!arguments.joints) measured.q.resize(Eigen::NoChange, 0);
  write_output(command.output, write_path(measured, joint_names(robot.chain)));
  return app::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("simulate-path",
                       "A machining pass as a cell would record it: position and force.",
                       "simulate-path --robot config/robots/kr360-roughing.yaml --noise-mm 0.095 "
                       "--clock-offset-s 1 config/paths/line300.csv > measured.csv");
  app::PassArguments arguments;
  app::add_pass_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
