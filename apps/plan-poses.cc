#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "armtrue/diagnosis/log_check.h"
#include "armtrue/io/joint_target_io.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/ranking_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/planning/planning.h"
#include "armtrue/planning/separation.h"
#include "armtrue/report/plan_tables.h"
#include "armtrue/tracing/loop.h"
#include "columns.h"
#include "command_line.h"
#include "option_text.h"

using namespace armtrue;

namespace {

struct Arguments {
  std::string robot, identify, given, separate, zone;
  int count = 0;
  std::vector<double> box_mm;
  std::optional<double> floor_mm;
  bool points = false, touches = false, images = false, beams = false;
};

void add_options(app::Command& command, Arguments& arguments) {
  command.add_output();
  command.add_seed();
  command.add_new_sessions();
  command.file("--robot", arguments.robot, "The robot that will be measured").required();
  command.identify(arguments.identify);
  command.option("--count", arguments.count, "Number of poses")
      .required()
      .check(app::in_range(1, kCloudSize));
  command.file("--given", arguments.given,
               "Measured poses that the planned ones complement. If they have several sessions, "
               "the plan continues the last; box and zone are in its R_A");
  const app::Option separate =
      command.file("--separate", arguments.separate,
                   "Product of close-loop or trace-residual: plan poses that separate its effects "
                   "from those that it lists as indistinguishable; -v shows the expected power");
  const app::Option zone = command.zone(
      arguments.zone,
      "Sphere x,y,z,radius in R_A in which the arm must be accurate; everywhere if absent");
  command.numbers("--box-mm", arguments.box_mm, 6, "x0,x1,y0,y1,z0,z1 in mm",
                  "Working box in R_A of the poses");
  command.option(
      "--floor-mm", arguments.floor_mm,
      "Height in R_0 below which neither links nor tool may go; that of the robot file if "
      "absent");
  command.flag("--points", arguments.points,
               "Positions only; with --given, what is read there is read again");
  const app::Option touches =
      command.flag("--touches", arguments.touches,
                   "Poses that touch the contacts of the robot file; --given decides for itself");
  const app::Option images =
      command
          .flag("--images", arguments.images,
                "Poses in which a camera of the robot file has a whole board in its image; --given "
                "decides for itself")
          .excludes(touches)
          .excludes(separate);
  command
      .flag("--beams", arguments.beams,
            "Poses in which a beam of the robot file reads a plane or a face; --given decides for "
            "itself")
      .excludes(touches)
      .excludes(images);
  separate.excludes(zone);
  command.add_columns(app::kMeasuredPoseColumns);
}

PlanOptions plan_options(const app::Command& command, const Arguments& arguments) {
  PlanOptions options;
  options.orientation = !arguments.points;
  options.touches = arguments.touches;
  options.images = arguments.images;
  options.beams = arguments.beams;
  if (arguments.floor_mm) options.floor = *arguments.floor_mm * kMillimetre;
  options.seed = command.seed;
  options.box = app::box_from_numbers(arguments.box_mm);
  if (!arguments.zone.empty()) options.zone = app::zone_from_text(arguments.zone);
  return options;
}

bool determines(const PlanQuality& quality) { return std::isfinite(quality.cloud_deviation); }

// Whether a number of poses is enough does not depend on which they are, so random poses show the
// smallest number that is. Nothing if not even the largest is.
std::optional<int> fewest_that_determine(const PosePlanner& planner, int too_few,
                                         std::uint64_t seed) {
  const auto is_enough = [&](int count) {
    return determines(planner.quality(planner.random(count, seed)));
  };
  int enough = std::min(2 * too_few, kCloudSize);
  while (!is_enough(enough)) {
    if (enough == kCloudSize) return std::nullopt;
    too_few = enough;
    enough = std::min(2 * enough, kCloudSize);
  }
  while (enough - too_few > 1) {
    const int middle = (enough + too_few) / 2;
    (is_enough(middle) ? enough : too_few) = middle;
  }
  return enough;
}

// With too few poses the expected error has no bound.
void warn_of_too_few(app::Command& command, const PosePlanner& planner, int count) {
  const std::optional<int> enough = fewest_that_determine(planner, count, command.seed);
  if (!enough)
    return command.warn(
        "no number of such poses determines all unknowns, so the expected error has no bound; add "
        "contacts, anchors or targets, or identify fewer parameters");
  command.warn(fmt::format(
      "{} pose{} not determine all unknowns, so the expected error has no bound; {} are "
      "the fewest that can, more make it small (--count)",
      count, count == 1 ? " does" : "s do", *enough));
}

std::string quoted(const Effect& effect) { return "'" + describe(effect) + "'"; }

// Effects no two of which can be separated by poses, and the readings that separate them.
struct InseparableSet {
  std::vector<std::string> effects;
  std::set<std::string> readings;
};

// Each pair of effects that no poses can separate, whichever of the two is true, is in one of the
// sets. A set starts from such a pair and takes in every effect that forms such a pair with all its
// members.
std::vector<InseparableSet> inseparable_sets(const SeparationPlan& plan) {
  using Pair = std::pair<std::string, std::string>;
  std::set<Pair> told;
  for (const SeparatedPair& pair : plan.pairs)
    if (pair.by_poses) told.insert(std::minmax(quoted(pair.truth), quoted(pair.rival)));

  std::vector<std::string> effects;
  std::map<Pair, std::vector<std::string>> untold;  // to the readings that would tell
  for (const SeparatedPair& pair : plan.pairs) {
    const std::string truth = quoted(pair.truth), rival = quoted(pair.rival);
    if (told.count(std::minmax(truth, rival))) continue;
    untold[std::minmax(truth, rival)] = pair.readings;
    for (const std::string& effect : {truth, rival})
      if (std::find(effects.begin(), effects.end(), effect) == effects.end())
        effects.push_back(effect);
  }

  std::vector<InseparableSet> sets;
  std::set<Pair> covered;
  for (size_t i = 0; i < effects.size(); ++i)
    for (size_t j = i + 1; j < effects.size(); ++j) {
      const Pair seed = std::minmax(effects[i], effects[j]);
      if (!untold.count(seed) || covered.count(seed)) continue;
      InseparableSet& set = sets.emplace_back();
      set.effects.push_back(effects[i]);
      const auto add = [&](const std::string& effect) {
        for (const std::string& member : set.effects) {
          const Pair pair = std::minmax(effect, member);
          covered.insert(pair);
          set.readings.insert(untold[pair].begin(), untold[pair].end());
        }
        set.effects.push_back(effect);
      };
      add(effects[j]);
      for (const std::string& effect : effects)
        if (std::ranges::all_of(set.effects, [&](const std::string& member) {
              return untold.count(std::minmax(effect, member)) > 0;
            }))
          add(effect);
    }
  return sets;
}

void warn_of_inseparable(app::Command& command, const SeparationPlan& plan) {
  for (const auto& [effects, readings] : inseparable_sets(plan))
    command.warn(fmt::format(
        "no poses separate {}: after a refit their predictions are equal{}{}",
        fmt::join(effects, ", "),
        readings.empty() ? "" : "; a reading that does: ", fmt::join(readings, "; or ")));
}

int plan_for_separation(app::Command& command, const Arguments& arguments, const Robot& robot,
                        const Campaign& given, const PlanOptions& options) {
  const SeparationPlan plan = plan_separation(robot, read_findings(arguments.separate, robot.chain),
                                              arguments.count, options, given);
  if (plan.pairs.empty())
    command.warn(
        arguments.separate +
        ": no effect has an entry under 'indistinguishable'; there is nothing to separate");
  warn_of_inseparable(command, plan);
  command.tell(power_table(plan));
  if (plan.poses.empty()) return app::kNotReached;
  write_output(command.output, write_joint_targets(app::numbered(plan.poses, given.pose_ids),
                                                   joint_names(robot.chain)));
  return app::kSuccess;
}

int plan_for_geometry(app::Command& command, const Arguments& arguments, const Robot& robot,
                      const Campaign& given, const PlanOptions& options) {
  const PosePlanner planner(robot, options, given);
  const std::vector<PlannedPose> planned = planner.plan(arguments.count);
  const PlanQuality quality = planner.quality(planned);
  if (!determines(quality)) warn_of_too_few(command, planner, arguments.count);
  if (command.verbose)
    command.tell(plan_table(quality,
                            planner.quality(planner.random(arguments.count, command.seed + 1)),
                            options.zone.has_value()));
  write_output(command.output, write_joint_targets(app::numbered(planned, given.pose_ids),
                                                   joint_names(robot.chain)));
  return app::kSuccess;
}

int run(app::Command& command, const Arguments& arguments) {
  const PlanOptions options = plan_options(command, arguments);
  Robot robot = command.read_robot(arguments.robot).robot;
  app::use_identify(arguments.identify, robot);
  for (const std::string& warning : check_limits(robot).warnings)
    command.warn(arguments.robot + ": " + warning);
  Campaign given;
  if (!arguments.given.empty()) {
    given = command.read_campaign(arguments.given, robot);
    if (given.has_pixels() && !arguments.separate.empty())
      throw InputError(given.source +
                       ": --separate does not plan images; plan those of a calibration without it, "
                       "or readings of an instrument that reads points");
    app::refuse_mistakes(command, robot, given);
  }
  const auto touchable = [](const Contact& contact) { return is_touched(contact.kind); };
  const bool has_contacts = std::ranges::any_of(robot.chain.contacts, touchable);
  if (arguments.touches && !has_contacts)
    throw InputError(arguments.robot + ": --touches needs 'contacts' in the robot file");
  const bool has_cameras = std::ranges::any_of(
      robot.chain.contacts, [](const Contact& contact) { return is_of_images(contact.kind); });
  if (given.rows() == 0 && !arguments.touches && !arguments.images && !arguments.beams &&
      has_cameras)
    command.warn(arguments.robot +
                 ": the poses are planned for an instrument that reads points; give --images for "
                 "poses that show the boards of the robot file to its cameras");
  if (given.rows() == 0 && !arguments.touches && !arguments.images && !arguments.beams &&
      has_contacts)
    command.warn(arguments.robot +
                 ": the poses are planned for an instrument that reads points; give --touches, or "
                 "--given with touches, for poses that touch the contacts of the robot file");
  command.progress("planning");
  return arguments.separate.empty()
             ? plan_for_geometry(command, arguments, robot, given, options)
             : plan_for_separation(command, arguments, robot, given, options);
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command(
      "plan-poses",
      "Plan the best poses for a calibration or, with --separate, poses that separate "
      "effects that a campaign could not (exit code 3 if no poses do). "
      "Collisions are not checked: check the poses before the arm drives to them.",
      "plan-poses --robot nominal.yaml --count 40 > targets.csv\n"
      "  plan-poses --robot calibrated.yaml --given measured.csv --separate "
      "loop.yaml --count 15 > targets.csv");
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
