#include "plan_inputs.h"

#include <algorithm>

#include "armtrue/kinematics/units.h"
#include "columns.h"
#include "option_text.h"

namespace armtrue::app {

void add_plan_options(Command& command, PlanArguments& arguments) {
  command.add_output(ProductKind::table);
  command.add_seed();
  command.add_new_sessions();
  command.file("--robot", arguments.robot, "The robot that will be measured").required();
  command.identify(arguments.identify);
  command.option("--count", arguments.count, "Number of poses")
      .required()
      .check(in_range(1, kCloudSize));
  command.file("--given", arguments.given,
               "Measured poses that the planned ones complement. If they have several sessions, "
               "the plan continues the last; box and zone are in its R_A");
  const Option separate =
      command.file("--separate", arguments.separate,
                   "Product of close-loop or trace-residual: plan poses that separate its effects "
                   "from those that it lists as indistinguishable; -v shows the expected power");
  const Option zone = command.zone(
      arguments.zone,
      "Sphere x,y,z,radius in R_A in which the arm must be accurate; everywhere if absent");
  command.numbers("--box-mm", arguments.box_mm, 6, "x0,x1,y0,y1,z0,z1 in mm",
                  "Working box in R_A of the poses");
  command.option(
      "--floor-mm", arguments.floor_mm,
      "Height in R_0 below which neither links nor tool may go; that of the robot file if "
      "absent");
  add_reading_options(command, arguments.readings);
  separate.excludes(zone);
  command.add_columns(kMeasuredPoseColumns);
}

PlanOptions plan_options(const Command& command, const PlanArguments& arguments) {
  PlanOptions options;
  static_cast<ReadingKinds&>(options) = reading_kinds(arguments.readings);
  if (arguments.floor_mm) options.floor = *arguments.floor_mm * kMillimetre;
  options.seed = command.seed;
  options.box = box_from_numbers(arguments.box_mm);
  if (!arguments.zone.empty()) options.zone = zone_from_text(arguments.zone);
  return options;
}

Campaign poses_to_complement(Command& command, const PlanArguments& arguments, const Robot& robot) {
  if (arguments.given.empty()) return {};
  Campaign given = command.read_campaign(arguments.given, robot, Command::Copies::keep);
  refuse_mistakes(command, robot, given);
  return given;
}

void warn_of_other_readings(Command& command, const PlanArguments& arguments, const Robot& robot,
                            const Campaign& given) {
  const auto touchable = [](const Contact& contact) { return is_touched(contact.kind); };
  const bool has_contacts = std::ranges::any_of(robot.chain.contacts, touchable);
  if (arguments.readings.touches && !has_contacts)
    throw InputError(arguments.robot + ": --touches needs 'contacts' in the robot file");
  const bool has_cameras = std::ranges::any_of(
      robot.chain.contacts, [](const Contact& contact) { return is_of_images(contact.kind); });
  if (given.rows() > 0 || reading_kinds(arguments.readings).needs_sights()) return;
  if (has_cameras)
    command.warn(arguments.robot +
                 ": the poses are planned for an instrument that reads points; give --images for "
                 "poses that show the boards of the robot file to its cameras");
  if (has_contacts)
    command.warn(arguments.robot +
                 ": the poses are planned for an instrument that reads points; give --touches, or "
                 "--given with touches, for poses that touch the contacts of the robot file");
}

}  // namespace armtrue::app
