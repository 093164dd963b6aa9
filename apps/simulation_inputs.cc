#include "simulation_inputs.h"

#include "armtrue/kinematics/units.h"
#include "columns.h"
#include "option_text.h"

namespace armtrue::app {

void add_simulation_options(Command& command, SimulationArguments& arguments) {
  command.add_output(ProductKind::table);
  command.add_seed();
  command.file("--robot", arguments.robot, "The robot that is commanded").required();
  command.file("--truth", arguments.truth, "The robot that is measured; the same if absent");
  OptionGroup poses = command.group("Poses");
  poses.option("--count", arguments.count, "Number of random poses").check(in_range(1, 10000000));
  const Option targets = poses.file("--targets", arguments.targets,
                                    "The poses, as plan-poses writes them; - is standard input");
  poses.require_one();
  command.option("--repeats", arguments.repeats, "Visits of each pose").check(in_range(1, 1000));
  command
      .option("--noise-mm", arguments.noise_mm,
              "Noise of the position, per axis, or of each number that a touch, a distance, a beam "
              "or the "
              "z of a profile reads")
      .check(not_below_zero());
  command.option("--noise-mrad", arguments.noise_mrad, "Noise of the orientation, per axis")
      .check(not_below_zero());
  command
      .option("--blunders", arguments.blunders,
              "Share of readings with an error of 2 to 20 mm, or of 2 to 20 px")
      .check(in_range(0.0, 0.5));
  const SightOptions sights = add_reading_options(command, arguments.readings);
  command.option("--noise-px", arguments.noise_px, "With --images: noise of a corner, per axis")
      .check(not_below_zero())
      .needs(sights.images);
  command
      .option("--order", arguments.order,
              "Order of the visits: random, or sorted by the first joint")
      .check(one_of({"random", "sorted"}))
      .default_shown();
  const Option box = command.numbers("--box-mm", arguments.box_mm, 6, "x0,x1,y0,y1,z0,z1 in mm",
                                     "Working box in R_A of random poses");
  box.excludes(targets);
  for (const Option& option : {sights.touches, sights.beams, sights.images, sights.profiles})
    box.excludes(option);
  command.add_columns(kJointTargetColumns);
}

SimulationOptions simulation_options(const SimulationArguments& arguments, std::uint64_t seed) {
  SimulationOptions options;
  static_cast<ReadingKinds&>(options) = reading_kinds(arguments.readings);
  options.poses = arguments.count;
  options.repeats = arguments.repeats;
  options.noise_position = arguments.noise_mm * kMillimetre;
  options.noise_orientation = arguments.noise_mrad * kMilliradian;
  options.noise_pixel = arguments.noise_px;
  options.blunders = arguments.blunders;
  if (options.touches && options.blunders > 0 && options.repeats > 1)
    throw UsageError(
        "--touches and --blunders need --repeats 1: the joint angles of a touch that is off are no "
        "replicate of others");
  options.order = arguments.order == "random" ? VisitOrder::random : VisitOrder::sorted;
  options.box = box_from_numbers(arguments.box_mm);
  options.seed = seed;
  return options;
}

}  // namespace armtrue::app
