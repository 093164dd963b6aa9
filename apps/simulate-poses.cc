#include <fmt/format.h>

#include <algorithm>

#include "armtrue/campaign/simulation.h"
#include "armtrue/io/joint_target_io.h"
#include "armtrue/io/output.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "columns.h"
#include "command_line.h"
#include "option_text.h"

using namespace armtrue;

namespace {

struct Arguments {
  std::string robot, truth, targets;
  int count = SimulationOptions{}.poses, repeats = SimulationOptions{}.repeats;
  double noise_mm = 0, noise_mrad = 0, noise_px = 0, blunders = 0;
  bool points = false, images = false, beams = false;
  std::string order = "random";
  std::vector<double> box_mm;
};

void add_options(app::Command& command, Arguments& arguments) {
  command.add_output();
  command.add_seed();
  command.file("--robot", arguments.robot, "The robot that is commanded").required();
  command.file("--truth", arguments.truth, "The robot that is measured; the same if absent");
  app::OptionGroup poses = command.group("Poses");
  poses.option("--count", arguments.count, "Number of random poses")
      .check(app::in_range(1, 10000000));
  const app::Option targets = poses.file(
      "--targets", arguments.targets, "The poses, as plan-poses writes them; - is standard input");
  poses.require_one();
  command.option("--repeats", arguments.repeats, "Visits of each pose")
      .check(app::in_range(1, 1000));
  command
      .option("--noise-mm", arguments.noise_mm,
              "Noise of the position, per axis, or of what a beam reads")
      .check(app::not_below_zero());
  command.option("--noise-mrad", arguments.noise_mrad, "Noise of the orientation, per axis")
      .check(app::not_below_zero());
  command
      .option("--blunders", arguments.blunders,
              "Share of readings with an error of 2 to 20 mm, or of 2 to 20 px")
      .check(app::in_range(0.0, 0.5));
  const app::Option points = command.flag("--points", arguments.points, "Positions only");
  const app::Option images =
      command
          .flag("--images", arguments.images,
                "What the cameras of the robot file see of its boards, in place of positions; "
                "random poses show the whole board")
          .excludes(points);
  const app::Option beams =
      command
          .flag("--beams", arguments.beams,
                "What the beams of the robot file read of its planes and faces, in place of "
                "positions; each beam reads the nearest in its range, and random poses show one")
          .excludes(points)
          .excludes(images);
  command.option("--noise-px", arguments.noise_px, "With --images: noise of a corner, per axis")
      .check(app::not_below_zero())
      .needs(images);
  command
      .option("--order", arguments.order,
              "Order of the visits: random, or sorted by the first joint")
      .check(app::one_of({"random", "sorted"}))
      .default_shown();
  command
      .numbers("--box-mm", arguments.box_mm, 6, "x0,x1,y0,y1,z0,z1 in mm",
               "Working box in R_A of random poses")
      .excludes(targets)
      .excludes(images)
      .excludes(beams);
  command.add_columns(app::kJointTargetColumns);
}

SimulationOptions simulation_options(const Arguments& arguments, std::uint64_t seed) {
  SimulationOptions options;
  options.poses = arguments.count;
  options.repeats = arguments.repeats;
  options.noise_position = arguments.noise_mm * kMillimetre;
  options.noise_orientation = arguments.noise_mrad * kMilliradian;
  options.noise_pixel = arguments.noise_px;
  options.blunders = arguments.blunders;
  options.images = arguments.images;
  options.beams = arguments.beams;
  options.orientation = !arguments.points;
  options.order = arguments.order == "random" ? VisitOrder::random : VisitOrder::sorted;
  options.box = app::box_from_numbers(arguments.box_mm);
  options.seed = seed;
  return options;
}

// A real controller refuses such targets.
void warn_beyond_travel(app::Command& command, const std::string& file,
                        const std::vector<JointTarget>& targets, const KinematicChain& chain) {
  const auto beyond = [&](const JointTarget& target) {
    return beyond_travel(chain, target.q).has_value();
  };
  const auto first = std::ranges::find_if(targets, beyond);
  if (first == targets.end()) return;
  const auto [index, value] = *beyond_travel(chain, first->q);
  const Link& link = chain.links[index];
  const double unit = is_prismatic(link) ? kMillimetre : kDegree;
  const char* const unit_name = is_prismatic(link) ? "mm" : "deg";
  command.warn(fmt::format(
      "{}:{}: {} of {} targets lie beyond the travel of the joints; in the first, '{}', {} stands "
      "at {:.6g} {}, outside {:.6g} to {:.6g} {}",
      file, first->line, std::ranges::count_if(targets, beyond), targets.size(), first->pose,
      link.name, value / unit, unit_name, link.min / unit, link.max / unit, unit_name));
}

Campaign simulate_targets(app::Command& command, const std::string& path, const Robot& robot,
                          const Robot& truth, const SimulationOptions& options) {
  const std::vector<JointTarget> targets = read_joint_targets(path, joint_names(robot.chain));
  warn_beyond_travel(command, path, targets, robot.chain);
  std::vector<JointVector> commanded;
  for (const JointTarget& target : targets) commanded.push_back(target.q);
  Campaign campaign = simulate(commanded, truth, options);
  const std::string nothing =
      options.beams ? "no beam reads a plane" : "no camera sees a corner of a board";
  if (campaign.rows() == 0)
    throw InputError(path + ": " + nothing + " in any of the poses; plan them with plan-poses " +
                     (options.beams
                          ? "--beams, or check the places of beams and planes, and range_mm"
                          : "--images, or check the places of cameras and boards"));
  if (campaign.pose_ids.size() < targets.size())
    command.warn(fmt::format("{}: in {} of {} poses {}", path,
                             targets.size() - campaign.pose_ids.size(), targets.size(), nothing));
  for (std::string& id : campaign.pose_ids)  // numbers, from 1
    id = targets[static_cast<size_t>(*read_number(id)) - 1].pose;
  return campaign;
}

int run(app::Command& command, const Arguments& arguments) {
  const SimulationOptions options = simulation_options(arguments, command.seed);
  const Robot robot = command.read_robot(arguments.robot).robot;
  const Robot truth = arguments.truth.empty() ? robot : command.read_robot(arguments.truth).robot;
  if (!arguments.truth.empty())
    app::require_one_arm(command, robot, arguments.robot, truth, arguments.truth);
  if (!arguments.images && std::ranges::any_of(truth.chain.contacts, [](const Contact& contact) {
        return is_of_images(contact.kind);
      }))
    command.warn(
        "the robot has cameras and boards, and simulated readings are points, not pixels; --images "
        "makes pixels");
  command.progress("simulating");
  write_output(command.output, write_campaign(arguments.targets.empty()
                                                  ? simulate(robot, truth, options)
                                                  : simulate_targets(command, arguments.targets,
                                                                     robot, truth, options),
                                              joint_names(robot.chain)));
  return app::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command(
      "simulate-poses", "Measured poses as a robot would give them.",
      "simulate-poses --robot nominal.yaml --truth truth.yaml --count 60 --repeats 3 "
      "--noise-mm 0.095 --noise-mrad 0.15 > measured.csv");
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
