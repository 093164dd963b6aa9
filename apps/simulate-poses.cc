#include <fmt/format.h>

#include <algorithm>

#include "armtrue/campaign/simulation.h"
#include "armtrue/io/output.h"
#include "armtrue/kinematics/inverse.h"
#include "armtrue/kinematics/units.h"
#include "command_line.h"

using namespace armtrue;

namespace {

// A true controller would not drive there.
void warn_beyond_travel(const app::Command& command, const std::string& file,
                        const std::vector<JointTarget>& targets, const KinematicChain& chain) {
  const auto beyond = [&](const JointTarget& target) {
    return joint_beyond_travel(chain, target.q) >= 0;
  };
  const auto first = std::ranges::find_if(targets, beyond);
  if (first == targets.end()) return;
  const auto joint = static_cast<size_t>(joint_beyond_travel(chain, first->q));
  const Link& link = chain.links[joint];
  command.warn(fmt::format(
      "{}:{}: {} of {} targets lie beyond the travel of the joints; in the first, '{}', {} stands "
      "at {:.6g} deg, outside {:.6g} to {:.6g} deg",
      file, first->line, std::ranges::count_if(targets, beyond), targets.size(), first->pose,
      link.name, first->q[static_cast<int>(joint)] / kDegree, link.min / kDegree,
      link.max / kDegree));
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command(
      "simulate-poses", "Measured poses as a robot would give them.",
      "simulate-poses --robot nominal.yaml --truth truth.yaml --count 60 --repeats 3 "
      "--noise-mm 0.095 --noise-mrad 0.15 > measured.csv");
  std::string robot_path, truth_path, targets_path;
  SimulationOptions simulation;
  double noise_mm = 0, noise_mrad = 0;
  bool points = false;
  std::vector<double> box;
  std::string order = "random";
  command.add_output();
  command.add_seed();
  CLI::App& options = command.options();
  options.add_option("--robot", robot_path, "The robot that is commanded")->required();
  options.add_option("--truth", truth_path, "The robot that is measured; the same if absent");
  CLI::Option_group* const poses = options.add_option_group("Poses");
  poses->add_option("--count", simulation.poses, "Number of random poses")
      ->check(CLI::Range(1, 10000000));
  poses->add_option("--targets", targets_path,
                    "The poses, as plan-poses writes them; - is standard input");
  poses->require_option(1);
  options.add_option("--repeats", simulation.repeats, "Visits of each pose")
      ->check(CLI::Range(1, 1000));
  options.add_option("--noise-mm", noise_mm, "Noise of the position, per axis")
      ->check(app::not_below_zero());
  options.add_option("--noise-mrad", noise_mrad, "Noise of the orientation, per axis")
      ->check(app::not_below_zero());
  options.add_option("--blunders", simulation.blunders, "Share of readings 2 to 20 mm off")
      ->check(CLI::Range(0.0, 0.5));
  options.add_flag("--points", points, "Positions only");
  options.add_option("--order", order, "Order of the visits: random, or sorted by the first joint")
      ->check(CLI::IsMember({"random", "sorted"}))
      ->capture_default_str();
  app::add_numbers(options, "--box-mm", box, 6, "x0,x1,y0,y1,z0,z1 in mm", "Working box in R_A");
  return command.run(argc, argv, [&] {
    const Robot robot = command.robot(robot_path).robot;
    const Robot truth = truth_path.empty() ? robot : command.robot(truth_path).robot;
    simulation.noise_position = noise_mm * kMillimetre;
    simulation.noise_orientation = noise_mrad * kMilliradian;
    simulation.orientation = !points;
    simulation.order = order == "random" ? VisitOrder::random : VisitOrder::sorted;
    simulation.seed = command.seed;
    if (!box.empty())
      simulation.box = Box{Eigen::Vector3d(box[0], box[2], box[4]) * kMillimetre,
                           Eigen::Vector3d(box[1], box[3], box[5]) * kMillimetre};
    command.progress("simulating");
    Campaign campaign;
    if (targets_path.empty()) {
      campaign = simulate(robot, truth, simulation);
    } else {
      std::vector<JointVector> commanded;
      const std::vector<JointTarget> targets = read_joint_targets(targets_path);
      warn_beyond_travel(command, targets_path, targets, robot.chain);
      for (const JointTarget& target : targets) commanded.push_back(target.q);
      campaign = simulate(commanded, truth, simulation);
      for (size_t pose = 0; pose < targets.size(); ++pose)
        campaign.pose_ids[pose] = targets[pose].pose;
    }
    write_output(command.output, write_campaign(campaign));
    return app::kSuccess;
  });
}
