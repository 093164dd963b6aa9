#include <fmt/format.h>

#include <algorithm>

#include "armtrue/io/output.h"
#include "armtrue/io/path_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/path/simulation.h"
#include "columns.h"
#include "command_line.h"
#include "option_text.h"

using namespace armtrue;

namespace {

struct Arguments {
  std::string robot, truth, part;
  std::vector<double> orientation_deg, start_deg, engaged_mm, force_n_mm;  // empty: not given
  double depth_mm = 8, ramp_mm = 5;
  double force_variation = Cut{}.variation;
  std::uint64_t part_seed = Cut{}.part_seed;
  double lag_s = PassOptions{}.lag;
  double period_ms = 32, clock_offset_s = 0, clock_rate_ppm = 0, noise_mm = 0, noise_n = 0;
  double lost = 0;
  bool joints = false;
};

void add_cut_options(app::OptionGroup cut, Arguments& arguments) {
  cut.option("--depth-mm", arguments.depth_mm, "Depth of cut; 0 cuts air")
      .check(app::in_range(0.0, 1000.0))
      .default_shown();
  cut.numbers("--force-n-mm", arguments.force_n_mm, 3, "feed,normal,z in N/mm",
              "Force on the tool along feed, normal (left of it) and z, per mm of depth "
              "[0.58,5,-1.16]");
  cut.numbers("--engaged-mm", arguments.engaged_mm, 2, "s0,s1 in mm",
              "Arc lengths s0,s1 between which the tool cuts [the whole path]");
  cut.option("--ramp-mm", arguments.ramp_mm, "Length of entry and of exit")
      .check(app::not_below_zero())
      .default_shown();
  cut.option("--force-variation", arguments.force_variation,
             "RMS of the force relative to its mean")
      .check(app::in_range(0.0, 1.0))
      .default_shown();
  cut.option("--part-seed", arguments.part_seed,
             "Seed of this variation; the same in every pass over the part")
      .check(app::seed_number())
      .default_shown();
  cut.option("--part", arguments.part,
             "Path with which the part was programmed, if the executed path is a correction of it: "
             "the cut follows this path");
}

void add_recorder_options(app::OptionGroup recorder, Arguments& arguments) {
  recorder.option("--instrument-period-ms", arguments.period_ms, "Between two samples")
      .check(app::in_range(0.01, 1e5))
      .default_shown();
  recorder.option("--clock-offset-s", arguments.clock_offset_s, "Offset of its clock")
      .check(app::in_range(-1e9, 1e9));
  recorder.option("--clock-rate-ppm", arguments.clock_rate_ppm, "Rate error of its clock")
      .check(app::in_range(-1e5, 1e5));
  recorder.option("--noise-mm", arguments.noise_mm, "Noise of the position, per axis")
      .check(app::not_below_zero());
  recorder.option("--noise-n", arguments.noise_n, "Noise of the force, per axis")
      .check(app::not_below_zero());
  recorder.option("--lost", arguments.lost, "Share of samples that are lost")
      .check(app::in_range(0.0, 0.9));
  recorder.flag("--joints", arguments.joints, "Record the joint angles too");
}

void add_options(app::Command& command, Arguments& arguments) {
  command.add_input("The programmed path: t_s, x_mm, y_mm, z_mm");
  command.add_output();
  command.add_seed();
  command.file("--robot", arguments.robot, "The robot that is commanded, in the path's frame")
      .required();
  command.file("--truth", arguments.truth,
               "The robot that is measured; the same, with its effects, if absent");
  command.numbers("--orientation-deg", arguments.orientation_deg, 3, "a,b,c in deg",
                  "a,b,c of the measured frame, where the path has none");
  command.joints(
      "--start-deg", arguments.start_deg,
      "q1,...,q6 near the start, in deg (lengths in mm): the branch, and the orientation "
      "if nothing else states it");
  add_cut_options(command.group("Cut"), arguments);
  command.option("--lag-s", arguments.lag_s, "Time constant of the servos")
      .check(app::in_range(0.0, 10.0))
      .default_shown();
  add_recorder_options(
      command.group("Instrument", "its time is (1 + rate) * (time of the path) + offset"),
      arguments);
  command.add_columns(app::kPathColumns);
}

// All of a pass but the part.
PassOptions pass_options(const Arguments& arguments, std::uint64_t seed) {
  PassOptions pass;
  if (const auto& abc = arguments.orientation_deg; !abc.empty())
    pass.joints.orientation =
        rotation_from_abc(abc[0] * kDegree, abc[1] * kDegree, abc[2] * kDegree);
  pass.cut.depth = arguments.depth_mm * kMillimetre;
  pass.cut.ramp = arguments.ramp_mm * kMillimetre;
  if (!arguments.force_n_mm.empty())
    pass.cut.force_per_depth =
        Eigen::Map<const Eigen::Vector3d>(arguments.force_n_mm.data()) / kMillimetre;
  if (const auto& engaged = arguments.engaged_mm; !engaged.empty())
    pass.cut.engaged = {engaged[0] * kMillimetre, engaged[1] * kMillimetre};
  pass.cut.variation = arguments.force_variation;
  pass.cut.part_seed = arguments.part_seed;
  pass.lag = arguments.lag_s;
  pass.recorder.period = arguments.period_ms * 1e-3;
  pass.recorder.clock_offset = arguments.clock_offset_s;
  pass.recorder.clock_rate = arguments.clock_rate_ppm * 1e-6;
  pass.recorder.noise = arguments.noise_mm * kMillimetre;
  pass.recorder.force_noise = arguments.noise_n;
  pass.recorder.lost = arguments.lost;
  pass.recorder.seed = seed;
  return pass;
}

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

int run(app::Command& command, const Arguments& arguments) {
  PassOptions pass = pass_options(arguments, command.seed);
  const Robot robot = command.read_robot(arguments.robot).robot;
  const Robot truth = arguments.truth.empty() ? robot : command.read_robot(arguments.truth).robot;
  if (!arguments.truth.empty())
    app::require_one_arm(command, robot, arguments.robot, truth, arguments.truth);
  if (!arguments.start_deg.empty())
    pass.joints.start = app::joints_of(arguments.start_deg, robot, "--start-deg");
  const PathFile programmed = command.read_path(command.input, KeepRows::yes, robot);
  if (!arguments.part.empty()) pass.part = read_part(command, arguments.part, programmed, robot);
  if (arguments.depth_mm > 0 && !gives_way(truth))
    command.warn("no effect of the robot is driven by force: the cut moves nothing");
  command.progress("simulating");
  Path measured = app::on_samples_of(
      programmed, [&] { return simulate_pass(programmed.path, robot, truth, pass); });
  if (measured.samples() < 2)
    throw InputError(fmt::format(
        "{}: the pass takes {:g} s, of which the instrument records {} sample{}; a record needs "
        "two: give a shorter --instrument-period-ms (now {:g}) or lose less (--lost)",
        programmed.source,
        programmed.path.time[programmed.path.samples() - 1] - programmed.path.time[0],
        measured.samples(), measured.samples() == 1 ? "" : "s", arguments.period_ms));
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
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
