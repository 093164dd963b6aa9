#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "armtrue/io/output.h"
#include "armtrue/io/report_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/planning/planning.h"
#include "armtrue/planning/separation.h"
#include "armtrue/tracing/loop.h"
#include "command_line.h"

using namespace armtrue;

namespace {

std::string comparison(const PlanQuality& planned, const PlanQuality& random, bool with_zone) {
  std::string table = fmt::format("{:<40}{:>13}{:>13}\n", "", "planned", "random");
  const auto add = [&](const std::string& what, double a, double b) {
    const auto cell = [](double value) {
      return std::isfinite(value) ? fmt::format("{:.5g}", value) : std::string("no bound");
    };
    table += fmt::format("{:<40}{:>13}{:>13}\n", what, cell(a), cell(b));
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

bool determines(const PlanQuality& quality) { return std::isfinite(quality.cloud_deviation); }

// Too few poses promise nothing. How many would do: any will, so random ones tell.
void warn_of_too_few(const app::Command& command, const PosePlanner& planner, int count) {
  int enough = count + 1;
  while (enough < kCloudSize && !determines(planner.quality(planner.random(enough, command.seed))))
    ++enough;
  command.warn(fmt::format(
      "{} pose{} not determine all unknowns, so the expected error has no bound; {} are "
      "the fewest that can, more make it small (--count)",
      count, count == 1 ? " does" : "s do", enough));
}

std::string follows(const Effect& effect) { return "'" + describe(effect) + "'"; }

std::string power_table(const SeparationPlan& plan) {
  std::string table = fmt::format(
      "power at 5 %, with {:.3g} mm and {:.3g} mrad of noise\n{:>7}{:>9}{:>9}   truth, rival\n",
      plan.noise.position / kMillimetre, plan.noise.orientation / kMilliradian, "given", "planned",
      "random");
  for (const SeparatedPair& pair : plan.pairs)
    table +=
        fmt::format("{:>7.2f}{:>9.2f}{:>9.2f}   {}, {}\n", pair.power_given, pair.power_planned,
                    pair.power_random, follows(pair.truth), follows(pair.rival));
  return table;
}

// What poses leave undecided, and what would decide it: a warning for each set of effects no two of
// which poses tell apart, whichever is the truth.
void warn_of_what_is_left(const app::Command& command, const SeparationPlan& plan) {
  using Pair = std::pair<std::string, std::string>;
  std::set<Pair> told;
  for (const SeparatedPair& pair : plan.pairs)
    if (pair.by_poses) told.insert(std::minmax(follows(pair.truth), follows(pair.rival)));

  std::vector<std::string> effects;
  std::map<Pair, std::vector<std::string>> untold;  // to the readings that would tell
  for (const SeparatedPair& pair : plan.pairs) {
    const std::string truth = follows(pair.truth), rival = follows(pair.rival);
    if (told.count(std::minmax(truth, rival))) continue;
    untold[std::minmax(truth, rival)] = pair.readings;
    for (const std::string& effect : {truth, rival})
      if (std::find(effects.begin(), effects.end(), effect) == effects.end())
        effects.push_back(effect);
  }

  std::set<Pair> said;
  for (size_t i = 0; i < effects.size(); ++i)
    for (size_t j = i + 1; j < effects.size(); ++j) {
      const Pair seed = std::minmax(effects[i], effects[j]);
      if (!untold.count(seed) || said.count(seed)) continue;
      std::vector<std::string> set = {effects[i]};
      std::set<std::string> readings;
      const auto add = [&](const std::string& effect) {
        for (const std::string& member : set) {
          const Pair pair = std::minmax(effect, member);
          said.insert(pair);
          readings.insert(untold[pair].begin(), untold[pair].end());
        }
        set.push_back(effect);
      };
      add(effects[j]);
      for (const std::string& effect : effects)
        if (std::all_of(set.begin(), set.end(), [&](const std::string& member) {
              return untold.count(std::minmax(effect, member)) > 0;
            }))
          add(effect);
      command.warn(fmt::format(
          "no poses tell apart {}: refitted they predict alike{}{}", fmt::join(set, ", "),
          readings.empty() ? "" : "; what would: ", fmt::join(readings, "; or ")));
    }
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("plan-poses",
                       "The poses from which a calibration is best or, with --separate, those that "
                       "tell apart what a campaign could not (exit code 3 if no poses do). "
                       "Collisions are not seen: check the poses before the arm drives to them.",
                       "plan-poses --robot nominal.yaml --count 40 > targets.csv\n"
                       "  plan-poses --robot calibrated.yaml --given measured.csv --separate "
                       "loop.yaml --count 15 > targets.csv");
  std::string robot_path, given_path, findings_path, zone;
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
  options.add_option(
      "--given", given_path,
      "Measured poses that the planned ones shall complete; of several sessions the last "
      "is continued, and box and zone are in its R_A");
  options.add_option("--separate", findings_path,
                     "What close-loop or trace-residual wrote: tell its effects from those it "
                     "calls indistinguishable; -v shows the expected power");
  app::add_zone(options, zone,
                "Sphere x,y,z,radius in R_A in which the arm shall be accurate; everywhere if "
                "absent");
  app::add_numbers(options, "--box-mm", box, 6, "x0,x1,y0,y1,z0,z1 in mm",
                   "Working box in R_A of the poses");
  options
      .add_option("--floor-mm", floor_mm, "Height in R_0 below which neither links nor tool may go")
      ->capture_default_str();
  options.add_flag("--points", points,
                   "Positions only; with --given, what is read there is read again");
  options.get_option("--separate")->excludes(options.get_option("--zone"));
  return command.run(argc, argv, [&] {
    const Robot robot = command.robot(robot_path).robot;
    const Campaign given = given_path.empty() ? Campaign() : command.campaign(given_path, robot);
    PlanOptions plan;
    plan.orientation = !points;
    plan.floor = floor_mm * kMillimetre;
    plan.seed = command.seed;
    for (size_t k = 0; k < box.size(); k += 2)
      if (!(box[k] < box[k + 1]))
        throw std::invalid_argument(
            fmt::format("--box-mm: {:g} must be below {:g}", box[k], box[k + 1]));
    if (!box.empty())
      plan.box = Box{Eigen::Vector3d(box[0], box[2], box[4]) * kMillimetre,
                     Eigen::Vector3d(box[1], box[3], box[5]) * kMillimetre};
    if (!zone.empty()) plan.zone = app::zone(zone);
    command.progress("planning");
    if (!findings_path.empty()) {
      const SeparationPlan separation =
          plan_separation(robot, read_findings(findings_path, robot.chain), count, plan, given);
      if (separation.pairs.empty())
        command.warn(findings_path +
                     ": no effect has an entry under 'indistinguishable'; there is "
                     "nothing to separate");
      warn_of_what_is_left(command, separation);
      command.tell(power_table(separation));
      if (separation.poses.empty()) return app::kNotReached;
      write_output(command.output,
                   write_joint_targets(app::numbered(separation.poses, given.pose_ids)));
      return app::kSuccess;
    }
    const PosePlanner planner(robot, plan, given);
    const std::vector<JointVector> planned = planner.plan(count);
    const PlanQuality quality = planner.quality(planned);
    if (!determines(quality)) warn_of_too_few(command, planner, count);
    if (command.verbose)
      command.tell(comparison(quality, planner.quality(planner.random(count, command.seed + 1)),
                              !zone.empty()));
    write_output(command.output, write_joint_targets(app::numbered(planned, given.pose_ids)));
    return app::kSuccess;
  });
}
