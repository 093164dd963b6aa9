#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/joint_target_io.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/comparison_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/report/comparison_page.h"
#include "armtrue/text/number_text.h"
#include "command_line.h"
#include "comparison_inputs.h"

using namespace armtrue;

namespace {

RunFile read(app::Command& command, const std::string& path) {
  RunFile run = read_run(path);
  command.add_to_inputs(run.name, run.sha256);
  return run;
}

// Throws unless the numbers of both robots mean the same and one of them is calibrated.
void require_comparable(app::Command& command, const RunFile& before, const RunFile& after,
                        ComparedArms arms) {
  const Robot &one = before.robot->robot, &other = after.robot->robot;
  if (!is_calibrated(one) && !is_calibrated(other))
    throw InputError(fmt::format(
        "{} and {}: neither states standard deviations, so none is a calibrated robot; one of them "
        "may be a nominal robot file, the other what calibrate or close-loop --robot-out wrote",
        before.name, after.name));
  const std::string why = why_not_comparable(one, before.name, other, after.name);
  if (!why.empty()) throw InputError(why);
  app::require_one_arm(command, one, before.name, other, after.name);
  if (one.name != other.name && arms == ComparedArms::one)
    command.warn(fmt::format(
        "the robots are called '{}' and '{}': is this one arm? If they are two, give --two-arms",
        one.name, other.name));
}

void add_loops(app::Command& command, const app::ComparisonArguments& arguments, RunFile& before,
               RunFile& after) {
  if (arguments.loop.empty()) return;
  if (!before.robot)
    throw InputError(before.name +
                     ": --loop belongs to a robot file; give the loops themselves as "
                     "--before and FILE");
  const RunFile first = read(command, arguments.loop_before),
                second = read(command, arguments.loop);
  require_loop(first);
  require_loop(second);
  before.errors = first.errors;
  after.errors = second.errors;
}

NamedPoses poses_of(app::Command& command, const std::string& path, const Robot& robot) {
  NamedPoses poses;
  if (path.empty()) return poses;
  const JointTargetFile file = read_joint_target_file(path, joint_names(robot.chain));
  app::warn_beyond_travel(command, path, file.targets, robot.chain);
  for (const JointTarget& target : file.targets) {
    poses.names.push_back(target.pose);
    poses.q.push_back(target.q);
  }
  command.add_to_inputs(file.name, file.sha256);
  return poses;
}

// Whose page this is.
std::string name_of_arms(const RunFile& before, const RunFile& after, ComparedArms arms) {
  const auto name = [](const RunFile& run) { return run.robot ? run.robot->robot.name : run.name; };
  if (arms == ComparedArms::one || name(before) == name(after)) return name(after);
  return name(before) + " and " + name(after);
}

// The readings of a calibration, if the file that it names stands where it stood and holds the
// same: what was calibrate's input needs no second warning.
std::optional<Campaign> readings_at_hand(app::Command& command, const RunFile& run,
                                         const ComparedRun& compared) {
  if (!run.robot || compared.readings.size() != 1) return std::nullopt;
  for (const auto& [path, sha256] : run.provenance.inputs) {
    if (sha256 != compared.readings.front() || is_device_or_pipe(path) ||
        !std::filesystem::is_regular_file(path))
      continue;
    const Robot& robot = run.robot->robot;
    CampaignFile file = read_campaign(path, robot.chain);
    if (file.sha256 != sha256) continue;
    if (find_computed_orientations(robot, file.campaign)) leave_out_orientations(file.campaign);
    command.add_to_inputs(path, sha256);
    return std::move(file.campaign);
  }
  return std::nullopt;
}

int conclude(app::Command& command, const app::ComparisonArguments& arguments,
             const RunComparison& found) {
  bool is_met = true;
  const double mean = found.arm ? found.arm->mean * found.arm->times_elsewhere() : 0;
  if (arguments.max_change_mm && !(mean <= *arguments.max_change_mm * kMillimetre)) {
    command.warn(
        std::isfinite(mean)
            ? fmt::format("the arms differ by {:.4g} mm on average, more than {:g} mm",
                          mean / kMillimetre, *arguments.max_change_mm)
            : "base and tool take up all of the distance of the arms at these poses, so that "
              "--max-change-mm is not known to be met; compare at more poses");
    is_met = false;
  }
  const std::optional<bool> moved = found.arm_moved();
  if (arguments.require_unchanged && moved.value_or(true)) {
    const std::string undecided = found.undecided();
    const bool is_one = found.arms == ComparedArms::one;
    command.warn(moved ? is_one ? "the arm changed by more than chance"
                                : "the arms differ by more than chance"
                 : !undecided.empty()
                     ? "undecided: " + undecided
                     : std::string("whether the ") + (is_one ? "arm changed" : "arms differ") +
                           " is not tested" +
                           (found.untested.empty() ? "" : ": " + found.untested.front()));
    is_met = false;
  }
  return is_met ? app::kSuccess : app::kNotReached;
}

void require_two_arms(const ComparedRun& before, const ComparedRun& after) {
  const Shared readings = shared_readings(before, after);
  if (readings == Shared::all || readings == Shared::some)
    throw InputError(fmt::format(
        "{} and {} have readings in common, and those are of one arm: give the calibrations of "
        "two arms, or leave out --two-arms",
        before.name, after.name));
}

// A crash, a motor or a mastering changes few parameters of an arm.
void ask_for_two_arms(app::Command& command, const RunComparison& found) {
  const auto [moved, tested] = moved_of_tested(found);
  if (found.arms == ComparedArms::one && 2 * moved > tested)
    command.warn(fmt::format(
        "{} of {} parameters of the arm changed, as between two arms of one type; if these are "
        "two, give --two-arms",
        moved, tested));
}

// `path`: of the poses.
RunComparison compared(const std::string& path, const ComparedRun& before, const ComparedRun& after,
                       const NamedPoses& poses, ComparedArms arms) {
  try {
    return compare_runs(before, after, poses, arms);
  } catch (const std::invalid_argument&) {
    if (poses.q.empty()) throw;
    throw InputError(fmt::format(
        "{}: {} {} not enough to place base and tool of one arm on the other; give more, in which "
        "all joints move",
        path, counted(poses.q.size(), "pose"), poses.q.size() == 1 ? "is" : "are"));
  }
}

int run(app::Command& command, const app::ComparisonArguments& arguments) {
  const ComparedArms arms = arguments.two_arms ? ComparedArms::two : ComparedArms::one;
  RunFile before = read(command, arguments.before), after = read(command, command.input);
  require_one_kind(before, after);
  if (before.robot) require_comparable(command, before, after, arms);
  if (!before.robot && (arguments.max_change_mm || !arguments.poses.empty()))
    throw InputError(before.name + ": is " + kind_in_words(before.kind) +
                     ", which has no arm; --poses and --max-change-mm are for robot files");
  constexpr double kFarthest = 20;  // mm: no two models of an arm are as far apart
  if (arguments.max_change_mm && *arguments.max_change_mm > kFarthest)
    command.warn(fmt::format(
        "--max-change-mm {:g}: no arm changes by {:g} mm, so that every one meets it: is it in um? "
        "Give mm",
        *arguments.max_change_mm, kFarthest));
  add_loops(command, arguments, before, after);
  const std::optional<About> about = app::read_about(command, arguments.page);
  ComparedRun one = compared_run(before), other = compared_run(after);
  if (arms == ComparedArms::two) require_two_arms(one, other);
  const std::optional<Campaign> first = readings_at_hand(command, before, one),
                                second = readings_at_hand(command, after, other);
  if (first && second) {
    one.campaign = &*first;
    other.campaign = &*second;
  }
  const NamedPoses poses =
      after.robot ? poses_of(command, arguments.poses, *other.robot) : NamedPoses();
  command.progress("comparing");
  const RunComparison found = compared(arguments.poses, one, other, poses, arms);
  ask_for_two_arms(command, found);
  const std::vector<std::string> notes = notes_of_runs(one, other, arms);
  const Document product = write_comparison(found, notes, before, after, command.provenance());
  if (arguments.page.is_wanted())
    app::write_report(command, arguments.page,
                      comparison_page(found, name_of_arms(before, after, arms),
                                      app::page_head(command, product, about)));
  write_output(command.output, product);
  command.report(found.sentence + "\n" + comparison_table(found, notes));
  return conclude(command, arguments, found);
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command(
      "compare-runs",
      "What changed between two runs: parameters, effects, error and verdict, before a crash and "
      "after, last year and today, or two models of one campaign. Or what differs between two "
      "arms.",
      "compare-runs --before last-year.yaml today.yaml -o comparison.yaml --report "
      "comparison.html");
  app::ComparisonArguments arguments;
  app::add_comparison_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
