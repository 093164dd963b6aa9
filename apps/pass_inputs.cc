#include "pass_inputs.h"

#include "armtrue/kinematics/units.h"
#include "columns.h"

namespace armtrue::app {
namespace {

void add_cut_options(OptionGroup cut, PassArguments& arguments) {
  cut.option("--depth-mm", arguments.depth_mm, "Depth of cut; 0 cuts air")
      .check(in_range(0.0, 1000.0))
      .default_shown();
  cut.numbers("--force-n-mm", arguments.force_n_mm, 3, "feed,normal,z in N/mm",
              "Force on the tool along feed, normal (left of it) and z, per mm of depth "
              "[0.58,5,-1.16]");
  cut.numbers("--engaged-mm", arguments.engaged_mm, 2, "s0,s1 in mm",
              "Arc lengths s0,s1 between which the tool cuts [the whole path]");
  cut.option("--ramp-mm", arguments.ramp_mm, "Length of entry and of exit")
      .check(not_below_zero())
      .default_shown();
  cut.option("--force-variation", arguments.force_variation,
             "RMS of the force relative to its mean")
      .check(in_range(0.0, 1.0))
      .default_shown();
  cut.option("--part-seed", arguments.part_seed,
             "Seed of this variation; the same in every pass over the part")
      .check(seed_number())
      .default_shown();
  cut.option("--part", arguments.part,
             "Path with which the part was programmed, if the executed path is a correction of it: "
             "the cut follows this path");
}

void add_recorder_options(OptionGroup recorder, PassArguments& arguments) {
  recorder.option("--instrument-period-ms", arguments.period_ms, "Between two samples")
      .check(in_range(0.01, 1e5))
      .default_shown();
  recorder.option("--clock-offset-s", arguments.clock_offset_s, "Offset of its clock")
      .check(in_range(-1e9, 1e9));
  recorder.option("--clock-rate-ppm", arguments.clock_rate_ppm, "Rate error of its clock")
      .check(in_range(-1e5, 1e5));
  recorder.option("--noise-mm", arguments.noise_mm, "Noise of the position, per axis")
      .check(not_below_zero());
  recorder.option("--noise-n", arguments.noise_n, "Noise of the force, per axis")
      .check(not_below_zero());
  recorder.option("--lost", arguments.lost, "Share of samples that are lost")
      .check(in_range(0.0, 0.9));
  recorder.flag("--joints", arguments.joints, "Record the joint angles too");
}

}  // namespace

void add_pass_options(Command& command, PassArguments& arguments) {
  command.add_input("The programmed path: t_s, x_mm, y_mm, z_mm");
  command.add_output(ProductKind::table);
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
      .check(in_range(0.0, 10.0))
      .default_shown();
  add_recorder_options(
      command.group("Instrument", "its time is (1 + rate) * (time of the path) + offset"),
      arguments);
  command.add_columns(kPathColumns);
}

PassOptions pass_options(const PassArguments& arguments, std::uint64_t seed) {
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

}  // namespace armtrue::app
