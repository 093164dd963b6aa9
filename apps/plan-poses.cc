#include <fmt/format.h>

#include <optional>

#include "armtrue/diagnosis/log_check.h"
#include "armtrue/io/joint_target_io.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/ranking_io.h"
#include "armtrue/planning/planning.h"
#include "armtrue/planning/separation.h"
#include "armtrue/report/plan_tables.h"
#include "armtrue/text/number_text.h"
#include "command_line.h"
#include "plan_inputs.h"

using namespace armtrue;

namespace {

// With too few poses the expected error has no bound.
void warn_of_too_few(app::Command& command, const PosePlanner& planner, int count) {
  const std::optional<int> enough = planner.fewest_that_determine(count, command.seed);
  if (!enough)
    return command.warn(
        "no number of such poses determines all unknowns, so the expected error has no bound; add "
        "contacts, anchors or targets, or identify fewer parameters");
  command.warn(
      fmt::format("{} {} not determine all unknowns, so the expected error has no bound; {} are "
                  "the fewest that can, more make it small (--count)",
                  counted(count, "pose"), count == 1 ? "does" : "do", *enough));
}

int plan_for_separation(app::Command& command, const app::PlanArguments& arguments,
                        const Robot& robot, const Campaign& given, const PlanOptions& options) {
  const SeparationPlan plan = plan_separation(robot, read_findings(arguments.separate, robot.chain),
                                              arguments.count, options, given);
  if (plan.pairs.empty())
    command.warn(
        arguments.separate +
        ": no effect has an entry under 'indistinguishable'; there is nothing to separate");
  app::warn_of_all(command, inseparable_in_words(plan));
  command.tell(power_table(plan));
  if (plan.poses.empty()) return app::kNotReached;
  write_output(command.output, write_joint_targets(app::numbered(plan.poses, given.pose_ids),
                                                   joint_names(robot.chain)));
  return app::kSuccess;
}

int plan_for_geometry(app::Command& command, const app::PlanArguments& arguments,
                      const Robot& robot, const Campaign& given, const PlanOptions& options) {
  const PosePlanner planner(robot, options, given);
  const std::vector<PlannedPose> planned = planner.plan(arguments.count);
  const PlanQuality quality = planner.quality(planned);
  if (!quality.determines_all()) warn_of_too_few(command, planner, arguments.count);
  if (command.verbose)
    command.tell(plan_table(quality,
                            planner.quality(planner.random(arguments.count, command.seed + 1)),
                            options.zone.has_value()));
  write_output(command.output, write_joint_targets(app::numbered(planned, given.pose_ids),
                                                   joint_names(robot.chain)));
  return app::kSuccess;
}

int run(app::Command& command, const app::PlanArguments& arguments) {
  const PlanOptions options = app::plan_options(command, arguments);
  Robot robot = command.read_robot(arguments.robot).robot;
  app::use_identify(arguments.identify, robot);
  for (const std::string& warning : check_limits(robot).warnings)
    command.warn(arguments.robot + ": " + warning);
  const Campaign given = app::poses_to_complement(command, arguments, robot);
  app::warn_of_other_readings(command, arguments, robot, given);
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
  app::PlanArguments arguments;
  app::add_plan_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
