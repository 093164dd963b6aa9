#include <fmt/format.h>

#include <algorithm>

#include "armtrue/io/output.h"
#include "armtrue/io/path_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/path/simulation.h"
#include "command_line.h"

using namespace armtrue;

namespace {

bool gives_way(const Robot& robot) {
  return std::any_of(robot.effects.begin(), robot.effects.end(),
                     [](const Effect& e) { return e.driver.involves(DriverKind::force); });
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("simulate-path",
                       "A machining pass as a cell would record it: position and force.",
                       "simulate-path --robot config/robots/kr360-roughing.yaml --noise-mm 0.095 "
                       "--clock-offset-s 1 config/paths/line300.csv > measured.csv");
  std::string robot_path, truth_path, part_path;
  PassOptions pass;
  std::vector<double> orientation, start, engaged, force_per_depth;
  double depth_mm = 8, ramp_mm = 5, period_ms = 32, rate_ppm = 0, noise_mm = 0;
  bool joints = false;
  command.add_input("The programmed path: t_s, x_mm, y_mm, z_mm");
  command.add_output();
  command.add_seed();
  CLI::App& options = command.options();
  options.add_option("--robot", robot_path, "The robot that is commanded, in the path's frame")
      ->required();
  options.add_option("--truth", truth_path,
                     "The robot that is measured; the same, with its effects, if absent");
  app::add_numbers(options, "--orientation-deg", orientation, 3, "a,b,c in deg",
                   "a,b,c of the measured frame, where the path has none");
  app::add_numbers(options, "--start-deg", start, kJoints, "q1,...,q6 in deg",
                   "q1,...,q6 near the start: the branch, and the orientation if nothing else "
                   "states it");
  CLI::Option_group* const cut = options.add_option_group("Cut");
  cut->add_option("--depth-mm", depth_mm, "Depth of cut; 0 cuts air")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  app::add_numbers(*cut, "--force-n-mm", force_per_depth, 3, "feed,normal,z in N/mm",
                   "Force on the tool along feed, normal (left of it) and z, per mm of depth "
                   "[0.58,5,-1.16]");
  app::add_numbers(*cut, "--engaged-mm", engaged, 2, "s0,s1 in mm",
                   "Arc lengths s0,s1 between which the tool cuts [the whole path]");
  cut->add_option("--ramp-mm", ramp_mm, "Length of entry and of exit")
      ->check(app::not_below_zero())
      ->capture_default_str();
  cut->add_option("--force-variation", pass.cut.variation, "RMS of the force relative to its mean")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  cut->add_option("--part-seed", pass.cut.part_seed,
                  "Seed of that variation, which the next pass on such a part has too")
      ->check(app::seed_number())
      ->capture_default_str();
  cut->add_option("--part", part_path,
                  "The path that the part was programmed with, where the one that runs is a "
                  "correction of it: the cut stays there");
  options.add_option("--lag-s", pass.lag, "Time constant of the servos")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  CLI::Option_group* const recorder = options.add_option_group(
      "Instrument", "its time is (1 + rate) * (time of the path) + offset");
  recorder->add_option("--instrument-period-ms", period_ms, "Between two samples")
      ->check(CLI::Range(0.01, 1e5))
      ->capture_default_str();
  recorder->add_option("--clock-offset-s", pass.recorder.clock_offset, "Offset of its clock")
      ->check(CLI::Range(-1e9, 1e9));
  recorder->add_option("--clock-rate-ppm", rate_ppm, "Rate error of its clock")
      ->check(CLI::Range(-1e5, 1e5));
  recorder->add_option("--noise-mm", noise_mm, "Noise of the position, per axis")
      ->check(app::not_below_zero());
  recorder->add_option("--noise-n", pass.recorder.force_noise, "Noise of the force, per axis")
      ->check(app::not_below_zero());
  recorder->add_option("--lost", pass.recorder.lost, "Share of samples that are lost")
      ->check(CLI::Range(0.0, 0.9));
  recorder->add_flag("--joints", joints, "Record the joint angles too");
  return command.run(argc, argv, [&] {
    const Robot robot = command.robot(robot_path).robot;
    const Robot truth = truth_path.empty() ? robot : command.robot(truth_path).robot;
    const PathFile programmed = command.path(command.input, KeepRows::yes);
    if (!part_path.empty()) {
      const PathFile part = command.path(part_path, KeepRows::yes);
      if (part.path.time.size() != programmed.path.time.size() ||
          part.path.time != programmed.path.time)
        throw InputError(part.source + ": its times are not those of " + programmed.source +
                         "; --part takes the program that this path corrects");
      pass.part = part.path;
    }
    if (orientation.size() == 3)
      pass.joints.orientation = rotation_from_abc(
          orientation[0] * kDegree, orientation[1] * kDegree, orientation[2] * kDegree);
    if (start.size() == kJoints)
      pass.joints.start = Eigen::Map<const JointVector>(start.data()) * kDegree;
    pass.cut.depth = depth_mm * kMillimetre;
    pass.cut.ramp = ramp_mm * kMillimetre;
    if (force_per_depth.size() == 3)
      pass.cut.force_per_depth =
          Eigen::Map<const Eigen::Vector3d>(force_per_depth.data()) / kMillimetre;
    if (engaged.size() == 2)
      pass.cut.engaged = {engaged[0] * kMillimetre, engaged[1] * kMillimetre};
    pass.recorder.period = period_ms * 1e-3;
    pass.recorder.clock_rate = rate_ppm * 1e-6;
    pass.recorder.noise = noise_mm * kMillimetre;
    pass.recorder.seed = command.seed;
    if (depth_mm > 0 && !gives_way(truth))
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
          measured.samples(), measured.samples() == 1 ? "" : "s", period_ms));
    if (!joints) measured.q.resize(Eigen::NoChange, 0);
    write_output(command.output, write_path(measured));
    return app::kSuccess;
  });
}
