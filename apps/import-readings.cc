#include <fmt/format.h>
#include <fmt/ranges.h>

#include "armtrue/import/import_io.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/output.h"
#include "armtrue/io/source.h"
#include "armtrue/urdf/urdf_io.h"
#include "columns.h"
#include "command_line.h"
#include "standard_streams.h"

using namespace armtrue;

namespace {

struct Arguments {
  std::string points, joints, robot, urdf;
  ImportOptions import;
};

// The name of a shipped preset, or a file.
app::Check preset() {
  const app::Check word = app::one_of(import_presets());
  return {"", [word](const std::string& text) {
            if (text.ends_with(".yaml") || text.ends_with(".json")) return std::string();
            const std::string why = word.why_wrong(text);
            return why.empty() ? why : why + ", nor a file .yaml";
          }};
}

void add_column_options(app::Command& command, ImportOptions& import) {
  app::OptionGroup columns = command.group("Columns");
  columns
      .option("--column", import.columns,
              "OUR=THEIRS: their column holds our quantity, such as q1_deg=A1; may be given "
              "several times")
      .one_each();
  columns
      .option(
          "--ignore", import.ignored,
          "Column to leave out; x* stands for all that begin with x; may be given several times")
      .one_each();
  columns
      .option("--unit", import.units,
              "THEIRS=UNIT: unit of a column that states none; may be given several times")
      .one_each();
  columns.option("--length-unit", import.length_unit, "Unit of all lengths that state none")
      .check(app::one_of({"mm", "cm", "m", "um", "in"}));
  columns.option("--angle-unit", import.angle_unit, "Unit of all angles that state none")
      .check(app::one_of({"deg", "rad", "mrad"}));
  columns.option("--time-unit", import.time_unit, "Unit of all times that state none")
      .check(app::one_of({"s", "ms", "us", "ns", "min", "h"}));
  columns
      .option(
          "--angles", import.angles,
          "Convention of orientation angles: abc is Rz(A) Ry(B) Rx(C), rpy is Rz(yaw) Ry(pitch) "
          "Rx(roll), rotvec is a rotation vector")
      .check(app::one_of({"abc", "rpy", "rotvec"}));
  columns
      .option("--quaternion", import.quaternion,
              "Order of a quaternion whose columns are only numbered: wxyz or xyzw")
      .check(app::one_of({"wxyz", "xyzw"}));
  columns
      .option("--marker", import.markers,
              "Marker whose point is read, of several in each row (NAME_x, NAME_y, NAME_z); may be "
              "given several times; those that differ in a number alone if absent")
      .one_each();
  columns
      .option("--dates", import.dates,
              "Order of dates such as 3/5/2024, day-first or month-first; found from the cells if "
              "absent")
      .check(app::one_of({"day-first", "month-first"}));
  columns
      .option("--decimal", import.decimal,
              "Decimal sign, point or comma; found from the cells if absent")
      .check(app::one_of({"point", "comma"}));
}

void add_options(app::Command& command, Arguments& arguments) {
  command.add_input("A table with joint angles and measured points");
  command.add_output();
  app::Option points =
      command.file("--points", arguments.points, "Table of the instrument, instead of FILE");
  app::Option joints =
      command.file("--joints", arguments.joints, "Table of the controller, with the joint angles");
  points.needs(joints);
  joints.needs(points);
  app::Option robot = command.file("--robot", arguments.robot,
                                   "Robot of the joints in the table. Join by stops: its geometry "
                                   "decides which stops belong together");
  command
      .file("--urdf", arguments.urdf,
            "URDF from which --robot was made: its joints have the names of joint states")
      .needs(robot);
  ImportOptions& import = arguments.import;
  app::OptionGroup join = command.group("Join of two tables");
  join.option("--join", import.join,
              "How to join the tables: by id, order or time of the rows or, if the clocks differ, "
              "by stops, the standstills found in both tables")
      .needs(joints)
      .check(app::one_of({"id", "order", "time", "stops"}));
  join.option("--max-gap-s", import.max_gap_s,
              "Join by time: largest gap between the joint samples before and after a point")
      .check(app::above_zero())
      .default_shown();
  join.option("--clock-offset-s", import.clock_offset_s,
              "Join by time or stops: added to the times of the points. If absent, 0 by time, "
              "estimated by stops");
  join.option("--preset", import.presets,
              fmt::format("Format of a table: {}; or a file .yaml with another, see "
                          "armtrue-formats(5). One for the points, one for the joint angles",
                          fmt::join(import_presets(), ", ")))
      .one_each()
      .needs(joints)
      .check(preset());
  join.option("--body", import.body,
              "Rigid body or marker on the robot, of a motion capture that has several")
      .needs(joints);
  add_column_options(command, import);
}

int run(app::Command& command, Arguments arguments) {
  if (!arguments.points.empty() && command.input != "-")
    throw app::UsageError("FILE '" + command.input +
                          "' and --points are both given; give one of them");
  if (!arguments.robot.empty()) arguments.import.robot = command.read_robot(arguments.robot).robot;
  if (!arguments.urdf.empty()) {
    Source source(arguments.urdf);
    const std::string text = source.read_all();
    arguments.import.joint_of_link = urdf_joint_of_link(text, source.name());
  }
  command.progress("reading");
  const ImportedReadings readings =
      arguments.points.empty()
          ? import_readings(command.input, arguments.import)
          : import_readings(arguments.points, arguments.joints, arguments.import);
  write_output(command.output, write_campaign(readings.campaign, readings.joints));
  if (!command.quiet) app::print_error(readings.mapping);
  for (const std::string& warning : readings.warnings) command.warn(warning);
  return app::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("import-readings", "Exported tables to measured poses.",
                       "import-readings --points tracker.csv --joints controller.csv "
                       "--angle-unit deg -o measured.csv");
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
