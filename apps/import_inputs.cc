#include "import_inputs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "armtrue/io/source.h"
#include "armtrue/urdf/urdf_io.h"
#include "robot_program_files.h"

namespace armtrue::app {
namespace {

// The name of a shipped preset, or a file.
Check preset() {
  const Check word = one_of(import_presets());
  return {"", [word](const std::string& text) {
            if (text.ends_with(".yaml") || text.ends_with(".json")) return std::string();
            const std::string why = word.why_wrong(text);
            return why.empty() ? why : why + ", nor a file .yaml";
          }};
}

void add_column_options(Command& command, ImportOptions& import) {
  OptionGroup columns = command.group("Columns");
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
      .check(one_of({"mm", "cm", "m", "um", "in"}));
  columns.option("--angle-unit", import.angle_unit, "Unit of all angles that state none")
      .check(one_of({"deg", "rad", "mrad"}));
  columns.option("--time-unit", import.time_unit, "Unit of all times that state none")
      .check(one_of({"s", "ms", "us", "ns", "min", "h"}));
  columns
      .option(
          "--angles", import.angles,
          "Convention of orientation angles: abc is Rz(A) Ry(B) Rx(C), rpy is Rz(yaw) Ry(pitch) "
          "Rx(roll), rotvec is a rotation vector")
      .check(one_of({"abc", "rpy", "rotvec"}));
  columns
      .option("--quaternion", import.quaternion,
              "Order of a quaternion whose columns are only numbered: wxyz or xyzw")
      .check(one_of({"wxyz", "xyzw"}));
  columns
      .option("--marker", import.markers,
              "Marker whose point is read, of several in each row (NAME_x, NAME_y, NAME_z); may be "
              "given several times; those that differ in a number alone if absent")
      .one_each();
  columns
      .option("--dates", import.dates,
              "Order of dates such as 3/5/2024, day-first or month-first; found from the cells if "
              "absent")
      .check(one_of({"day-first", "month-first"}));
  columns
      .option("--decimal", import.decimal,
              "Decimal sign, point or comma; found from the cells if absent")
      .check(one_of({"point", "comma"}));
}

void add_program_options(Command& command, ImportArguments& arguments) {
  OptionGroup group = command.group("Path of a robot program");
  const Option program = group.file(
      "--program", arguments.program,
      "A robot program instead of FILE: write its straight and circular moves as the path for "
      "mirror-correct, with its time: t_s, x_mm, y_mm, z_mm. " +
          kinds_of_programs(" with its .dat"));
  add_texts_of_others(command, program, arguments.with);
  const Option feed = group.option("--feed-mm-s", arguments.feed_mm_s, "Speed of the tool on it")
                          .check(above_zero())
                          .needs(program);
  program.needs(feed);
  group
      .option("--acceleration-m-s2", arguments.acceleration_m_s2,
              "Of the tool along the path, where it starts and where the program stops")
      .check(above_zero())
      .default_shown()
      .needs(program);
  group.option("--period-ms", arguments.period_ms, "Between two samples")
      .check(in_range(0.1, 1000.0))
      .default_shown()
      .needs(program);
}

}  // namespace

void add_import_options(Command& command, ImportArguments& arguments) {
  command.add_input(
      "A table with joint angles and measured points, or with --pass the record of a motion");
  command.add_output(ProductKind::table);
  Option points = command.file(
      "--points", arguments.points,
      "Table of the instrument, or recording of ROS 2 (.mcap, .db3, its folder), instead of FILE");
  Option joints =
      command.file("--joints", arguments.joints,
                   "Table of the controller, with the joint angles, or recording of ROS 2");
  points.needs(joints);
  Option images = command.folder(
      "--images", arguments.images,
      "Folder with the images of a camera, one for each row of --joints, instead of FILE");
  Option board = command.option(
      "--board", arguments.board,
      "The board in them: checkerboard:9x6:25mm (inner corners), circles:7x6:20mm, "
      "asymmetric-circles:4x11:20mm, charuco:7x5:30mm:5x5 (squares, family of the markers), "
      "apriltag:6x6:40mm:12mm:36h11 (side, gap, family)");
  images.needs(joints).needs(board).excludes(points);
  board.needs(images);
  command.option("--camera", arguments.camera, "Name of the camera, where the robot has several")
      .needs(images);
  command
      .flag("--pass", arguments.is_pass,
            "FILE is the record of a motion for mirror-correct, points or forces or both: write "
            "t_s, x_mm, y_mm, z_mm, fx_n, fy_n, fz_n")
      .excludes(points)
      .excludes(joints)
      .excludes(images);
  Option robot = command.file("--robot", arguments.robot,
                              "Robot of the joints in the table. Join by stops: its geometry "
                              "decides which stops belong together");
  command
      .file("--urdf", arguments.urdf,
            "URDF from which --robot was made: its joints have the names of joint states")
      .needs(robot);
  ImportOptions& import = arguments.import;
  OptionGroup join = command.group("Join of two tables");
  join.option("--join", import.join,
              "How to join the tables: by id, order or time of the rows or, if the clocks differ, "
              "by stops, the standstills found in both tables")
      .needs(joints)
      .check(one_of({"id", "order", "time", "stops"}));
  join.option(
          "--max-gap-s", import.max_gap_s,
          "Join by time: largest gap between the joint samples before and after a point; of a "
          "recording with some joints in each message also the age of a value that still counts")
      .check(above_zero())
      .default_shown();
  join.option("--clock-offset-s", import.clock_offset_s,
              "Join by time or stops: added to the times of the points. If absent, 0 by time, "
              "estimated by stops");
  join.option("--preset", import.presets,
              fmt::format("Format of a table: {}; or a file .yaml with another, see "
                          "armtrue-formats(5). One for the points, one for the joint angles",
                          fmt::join(import_presets(), ", ")))
      .one_each()
      .check(preset());
  join.option("--body", import.body,
              "Rigid body or marker on the robot, of a motion capture or a table that has several; "
              "of a recording with transforms the child frame");
  join.option("--points-topic", import.points_topic,
              "Topic of the points, where a recording of ROS 2 has several")
      .needs(points);
  join.option("--joints-topic", import.joints_topic,
              "Topic of the joint states, where a recording of ROS 2 has several")
      .needs(joints);
  add_column_options(command, import);
  add_program_options(command, arguments);
}

void complete(Command& command, ImportArguments& arguments) {
  if (!arguments.program.empty() &&
      (command.input != "-" || arguments.is_pass || !arguments.joints.empty()))
    throw UsageError("--program is read instead of tables; leave FILE, --pass and --joints out");
  const bool has_images = !arguments.images.empty();
  if ((has_images || !arguments.points.empty()) && command.input != "-")
    throw UsageError("FILE '" + command.input + "' and " + (has_images ? "--images" : "--points") +
                     " are both given; give one of them");
  if (!arguments.joints.empty() && !has_images && arguments.points.empty())
    throw UsageError("--joints needs --points or --images: what was read there");
  if (!arguments.import.presets.empty() && arguments.joints.empty() && !arguments.is_pass)
    throw UsageError("--preset needs --joints or --pass: it is of one table of two, or of a pass");
  if (has_images && !arguments.import.join.empty())
    throw UsageError(
        "--join is of two tables; images are joined by the column 'image' of "
        "--joints or, without it, by the order of their names");
  if (!arguments.robot.empty()) arguments.import.robot = command.read_robot(arguments.robot).robot;
  if (!arguments.urdf.empty()) {
    Source source(arguments.urdf);
    const std::string text = source.read_all();
    arguments.import.joint_of_link = urdf_joint_of_link(text, source.name());
  }
}

}  // namespace armtrue::app
