#include "map_inputs.h"

#include "armtrue/kinematics/units.h"
#include "columns.h"
#include "option_text.h"

namespace armtrue::app {
namespace {

std::string why_no_picture(const std::string& file) {
  if (file.ends_with(".svg")) return "";
  return "'" + file +
         "' does not end with .svg; the picture is an SVG file, of which browsers and "
         "rsvg-convert make other kinds";
}

void add_places(Command& command, MapArguments& arguments) {
  OptionGroup where = command.group("Where");
  const Option box = where.numbers("--box-mm,--box", arguments.box_mm, 6, "x0,x1,y0,y1,z0,z1 in mm",
                                   "A grid in this box of the program's frame, x0,x1,y0,y1,z0,z1");
  const Option targets =
      where.file("--targets", arguments.targets, "Targets of a program; - is standard input");
  where.file("--path", arguments.path,
             "A path; - is standard input. Effects that time drives do not use its time");
  where.require_one();
  const Option step =
      command
          .option("--step-mm", arguments.step_mm,
                  "Largest distance between points of the grid; a twentieth of the longest side if "
                  "absent")
          .check(above_zero())
          .needs(box);
  command
      .numbers("--grid", arguments.grid, 3, "NX,NY,NZ",
               "Points along the sides of the box, NX,NY,NZ")
      .needs(box)
      .excludes(step);
  command
      .numbers(
          "--orientation", arguments.orientation, 3, "a,b,c in deg",
          "Orientation of the tool in the program's frame, as a,b,c in deg (KUKA), of the box and "
          "of a path that states none; that at --start if absent")
      .excludes(targets);
  command.joints("--start", arguments.start,
                 "Joint angles q1,...,q6 in deg (lengths in mm) that show the branch: of the box, "
                 "and of a first Cartesian target "
                 "or sample that states none");
  command
      .numbers("--part-mm", arguments.part_mm, 3, "LX,LY,LZ in mm",
               "Size LX,LY,LZ of a part inside the box; half the box if absent")
      .needs(box);
}

}  // namespace

void add_map_options(Command& command, MapArguments& arguments) {
  command.add_output(ProductKind::table);
  add_models(command, arguments);
  add_frames(command, arguments);
  add_places(command, arguments);
  add_conditions(command, arguments);
  command.add_output("--summary", arguments.summary,
                     "Write errors by cause, direction and places of the part here",
                     ProductKind::document);
  command.add_output("--plot", arguments.plot, "Draw the map here, as .svg")
      .check({"", why_no_picture});
  add_report(command, arguments.page, "with errors by cause, map and places of the part");
  command.add_columns(kProgramColumns);
  command.add_columns(kPathColumns);
}

std::optional<Eigen::Matrix3d> stated_orientation(const MapArguments& arguments) {
  const std::vector<double>& n = arguments.orientation;
  if (n.empty()) return std::nullopt;
  return rotation_from_abc(n[0] * kDegree, n[1] * kDegree, n[2] * kDegree);
}

Grid grid_of(const MapArguments& arguments, const Robot& controller,
             const CompensationOptions& options) {
  if (!options.start)
    throw std::invalid_argument(
        "--box-mm needs joint angles that show the branch; give --start q1,...,q6 in deg, such as "
        "those at which the arm stands in the box");
  const Box box = *box_from_numbers(arguments.box_mm);
  GridSpacing spacing;
  if (!arguments.grid.empty())
    spacing.count = {arguments.grid[0], arguments.grid[1], arguments.grid[2]};
  if (arguments.step_mm) spacing.step = *arguments.step_mm * kMillimetre;
  Grid grid = grid_of_box(box.low, box.high, spacing);
  grid.orientation = stated_orientation(arguments).value_or(
      tcp_in_program(controller, options, *options.start).rotation);
  return grid;
}

std::optional<Eigen::Vector3d> part_of(const MapArguments& arguments) {
  constexpr double kRounding = 1e-9;
  if (arguments.part_mm.empty()) return std::nullopt;
  const Eigen::Vector3d part = kMillimetre * Eigen::Vector3d(arguments.part_mm.data());
  const Box box = *box_from_numbers(arguments.box_mm);
  if (part.minCoeff() < 0 || ((box.high - box.low) * (1 + kRounding) - part).minCoeff() < 0)
    throw std::invalid_argument(
        "--part-mm: the part must fit into --box-mm, each side from 0 to that of the box");
  return part;
}

}  // namespace armtrue::app
