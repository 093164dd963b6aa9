#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "armtrue/campaign/simulation.h"
#include "armtrue/io/joint_target_io.h"
#include "armtrue/io/output.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "command_line.h"
#include "simulation_inputs.h"

using namespace armtrue;

namespace {

// The targets, with what they name of the contacts of the robot. Throws InputError if it has none
// of that name.
std::vector<PlannedPose> poses_of(const std::vector<JointTarget>& targets, const std::string& file,
                                  const KinematicChain& chain, bool touches) {
  const std::vector<TouchSight> sights =
      touches ? touch_sights_of(chain) : std::vector<TouchSight>{};
  std::vector<PlannedPose> poses;
  for (const JointTarget& target : targets) {
    poses.push_back({target.q, target.contact, target.target});
    if (!touches || target.contact.empty() || BeamName::is_one(target.contact)) continue;
    if (std::ranges::find(sights, target.contact, &TouchSight::name) == sights.end())
      throw InputError(fmt::format(
          "{}:{}: column 'contact': '{}' is no contact of the robot that is measured; add it to "
          "the robot file, under 'contacts', or empty the cell",
          file, target.line, target.contact));
  }
  return poses;
}

// Why a pose has no reading, and what to do if none has.
struct Nothing {
  std::string why, remedy;
};

Nothing nothing_read(const SimulationOptions& options) {
  std::vector<std::string> why, remedies;
  const auto add = [&](bool asked, const char* reason, const char* remedy) {
    if (!asked) return;
    why.emplace_back(reason);
    remedies.emplace_back(remedy);
  };
  add(options.images, "no camera sees a corner of a board",
      "--images, or check the places of cameras and boards");
  add(options.beams, "no beam reads a plane",
      "--beams, or check the places of beams and planes, and range_mm");
  add(options.touches, "no contact is touched",
      "--touches, which names them in a column 'contact', or check the places of contacts");
  add(options.profiles.has_value(), "the scanner reads no plane and no sphere",
      "--profiles, or check the tool, the places of contacts, and what the scanner sees");
  return {fmt::format("{}", fmt::join(why, ", ")), fmt::format("{}", fmt::join(remedies, "; "))};
}

Campaign simulate_targets(app::Command& command, const std::string& path, const Robot& robot,
                          const Robot& truth, const SimulationOptions& options) {
  const std::vector<JointTarget> targets = read_joint_targets(path, joint_names(robot.chain));
  app::warn_beyond_travel(command, path, targets, robot.chain);
  Campaign campaign =
      simulate(poses_of(targets, path, truth.chain, options.touches), truth, options);
  const Nothing nothing = nothing_read(options);
  if (campaign.rows() == 0)
    throw InputError(path + ": " + nothing.why +
                     " in any of the poses; plan them with plan-poses " + nothing.remedy);
  if (campaign.pose_ids.size() < targets.size())
    command.warn(fmt::format("{}: in {} of {} poses {}", path,
                             targets.size() - campaign.pose_ids.size(), targets.size(),
                             nothing.why));
  for (std::string& id : campaign.pose_ids)  // numbers, from 1
    id = targets[*read_whole_number(id) - 1].pose;
  return campaign;
}

int run(app::Command& command, const app::SimulationArguments& arguments) {
  const SimulationOptions options = app::simulation_options(arguments, command.seed);
  const Robot robot = command.read_robot(arguments.robot).robot;
  const Robot truth = arguments.truth.empty() ? robot : command.read_robot(arguments.truth).robot;
  if (!arguments.truth.empty())
    app::require_one_arm(command, robot, arguments.robot, truth, arguments.truth);
  if (!options.needs_sights() &&
      std::ranges::any_of(truth.chain.contacts,
                          [](const Contact& contact) { return is_of_images(contact.kind); }))
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
  app::SimulationArguments arguments;
  app::add_simulation_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
