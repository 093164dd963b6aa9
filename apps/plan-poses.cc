#include <fmt/format.h>

#include <unordered_set>

#include "armtrue/identification/planning.h"
#include "armtrue/io/output.h"
#include "armtrue/kinematics/units.h"
#include "command_line.h"

using namespace armtrue;

namespace {

std::string comparison(const PlanQuality& planned, const PlanQuality& random, bool with_zone) {
  std::string table = fmt::format("{:<40}{:>13}{:>13}\n", "", "planned", "random");
  const auto add = [&](const std::string& what, double a, double b) {
    table += fmt::format("{:<40}{:>13.5g}{:>13.5g}\n", what, a, b);
  };
  for (size_t k = 0; k < planned.observability.size(); ++k)
    add(fmt::format("O{}", k + 1), planned.observability[k], random.observability[k]);
  add("expected error over the candidates, mm", planned.cloud_deviation / kMillimetre,
      random.cloud_deviation / kMillimetre);
  if (with_zone)
    add("expected error in the zone, mm", planned.zone_deviation / kMillimetre,
        random.zone_deviation / kMillimetre);
  return table;
}

// Numbers go on where those of the given poses leave off, so that both fit into one file.
std::vector<JointTarget> with_new_ids(const std::vector<JointVector>& configurations,
                                      const std::vector<std::string>& given_ids) {
  const std::unordered_set<std::string> taken(given_ids.begin(), given_ids.end());
  std::vector<JointTarget> targets;
  for (int number = 1; targets.size() < configurations.size(); ++number) {
    const std::string id = std::to_string(number);
    if (!taken.contains(id)) targets.push_back({id, configurations[targets.size()]});
  }
  return targets;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("plan-poses",
                       "The poses from which a calibration is best. Collisions are not seen: check "
                       "the poses before the arm drives to them.",
                       "plan-poses --robot nominal.yaml --count 40 > targets.csv");
  std::string robot_path, given_path, zone;
  int count = 0;
  double floor_mm = 0;
  bool points = false;
  std::vector<double> box;
  command.add_output();
  command.add_seed();
  CLI::App& options = command.options();
  options.add_option("--robot", robot_path, "The robot that will be measured")->required();
  options.add_option("--count", count, "Number of poses")
      ->required()
      ->check(CLI::Range(1, kCloudSize));
  options.add_option("--given", given_path, "Measured poses that the planned ones shall complete");
  app::add_zone(options, zone,
                "Sphere x,y,z,radius in R_A in which the arm shall be accurate; everywhere if "
                "absent");
  options.add_option("--box-mm", box, "Working box x0,x1,y0,y1,z0,z1 in R_A of the poses")
      ->delimiter(',')
      ->expected(6);
  options
      .add_option("--floor-mm", floor_mm, "Height in R_0 below which neither links nor tool may go")
      ->capture_default_str();
  options.add_flag("--points", points,
                   "Positions only; with --given, what is read there is read again");
  return command.run(argc, argv, [&] {
    const Robot robot = command.robot(robot_path).robot;
    const Campaign given = given_path.empty() ? Campaign() : command.campaign(given_path, robot);
    PlanOptions plan;
    plan.orientation = !points;
    plan.floor = floor_mm * kMillimetre;
    plan.seed = command.seed;
    if (!box.empty())
      plan.box = Box{Eigen::Vector3d(box[0], box[2], box[4]) * kMillimetre,
                     Eigen::Vector3d(box[1], box[3], box[5]) * kMillimetre};
    if (!zone.empty()) plan.zone = app::zone(zone);
    command.progress("planning");
    const PosePlanner planner(robot, plan, given);
    const std::vector<JointVector> planned = planner.plan(count);
    if (command.verbose)
      command.tell(comparison(planner.quality(planned),
                              planner.quality(planner.random(count, command.seed + 1)),
                              !zone.empty()));
    write_output(command.output, write_joint_targets(with_new_ids(planned, given.pose_ids)));
    return app::kSuccess;
  });
}
