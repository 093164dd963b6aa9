#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "armtrue/compensation/error_map.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/error_map_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/report/error_map_page.h"
#include "columns.h"
#include "command_line.h"
#include "option_text.h"
#include "program_arguments.h"
#include "report_arguments.h"

using namespace armtrue;

namespace {

constexpr double kDefaultSteps = 20;  // along the longest side of a box
constexpr double kMostPoints = 2e6;   // of a grid: 1 GB
constexpr double kStepsAlike = 1e-9;  // of a step: rounding adds no point
constexpr double kMaxDisagreement = 10 * kMillimetre;
constexpr double kNoError = 1e-9;  // [m]
constexpr size_t kMostNamed = 5;   // in one warning

struct Arguments : app::ProgramArguments {
  std::string targets, path, summary, plot;
  app::ReportArguments page;
  std::vector<double> box_mm, grid, orientation, part_mm;
  std::optional<double> step_mm;
};

std::string why_no_picture(const std::string& file) {
  if (file.ends_with(".svg")) return "";
  return "'" + file +
         "' does not end with .svg; the picture is an SVG file, of which browsers and "
         "rsvg-convert make other kinds";
}

void add_places(app::Command& command, Arguments& arguments) {
  app::OptionGroup where = command.group("Where");
  const app::Option box =
      where.numbers("--box-mm,--box", arguments.box_mm, 6, "x0,x1,y0,y1,z0,z1 in mm",
                    "A grid in this box of the program's frame, x0,x1,y0,y1,z0,z1");
  const app::Option targets =
      where.file("--targets", arguments.targets, "Targets of a program; - is standard input");
  where.file("--path", arguments.path,
             "A path; - is standard input. Effects that time drives do not use its time");
  where.require_one();
  const app::Option step =
      command
          .option("--step-mm", arguments.step_mm,
                  "Largest distance between points of the grid; a twentieth of the longest side if "
                  "absent")
          .check(app::above_zero())
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

void add_options(app::Command& command, Arguments& arguments) {
  command.add_output();
  app::add_models(command, arguments);
  app::add_frames(command, arguments);
  add_places(command, arguments);
  app::add_conditions(command, arguments);
  command.add_output("--summary", arguments.summary,
                     "Write errors by cause, direction and places of the part here",
                     app::ProductKind::document);
  command.add_output("--plot", arguments.plot, "Draw the map here, as .svg")
      .check({"", why_no_picture});
  app::add_report(command, arguments.page, "with errors by cause, map and places of the part");
  command.add_columns(app::kProgramColumns);
  command.add_columns(app::kPathColumns);
}

// The pose of the TCP in the program's frame by the constants of the controller's model.
Pose tcp_at(const Robot& controller, const CompensationOptions& options, const JointVector& q) {
  KinematicChain chain = controller.chain;
  chain.base = {};
  chain.tool = options.tool;
  return inverse(options.base) * ChainEvaluator(chain).pose(q);
}

// That of --orientation, else that at --start; nothing if neither is given.
std::optional<Eigen::Matrix3d> orientation_of(const Robot& controller,
                                              const CompensationOptions& options,
                                              const Arguments& arguments) {
  const std::vector<double>& n = arguments.orientation;
  if (!n.empty()) return rotation_from_abc(n[0] * kDegree, n[1] * kDegree, n[2] * kDegree);
  if (options.start) return tcp_at(controller, options, *options.start).rotation;
  return std::nullopt;
}

// The grid of --box-mm, with --grid or --step-mm.
Grid grid_of(const Arguments& arguments) {
  const Box box = *app::box_from_numbers(arguments.box_mm);
  Grid grid{box.low, box.high};
  const Eigen::Vector3d side = grid.high - grid.low;
  if (arguments.start.empty())
    throw std::invalid_argument(
        "--box-mm needs joint angles that show the branch; give --start q1,...,q6 in deg, such as "
        "those at which the arm stands in the box");
  const double step = arguments.step_mm ? *arguments.step_mm * kMillimetre
                                        : std::max(side.maxCoeff() / kDefaultSteps, kNoError);
  double points = 1;
  std::array<double, 3> count{};
  for (size_t axis = 0; axis < 3; ++axis) {
    const double length = side[static_cast<int>(axis)];
    count[axis] =
        arguments.grid.empty() ? std::ceil(length / step - kStepsAlike) + 1 : arguments.grid[axis];
    if (!(count[axis] >= 1) || count[axis] != std::floor(count[axis]))
      throw std::invalid_argument(
          fmt::format("--grid: '{:g}' is no number of points; give three whole numbers from 1 on",
                      count[axis]));
    points *= count[axis];
  }
  if (points > kMostPoints)
    throw std::invalid_argument(
        fmt::format("the grid has {:.4g} points, more than {:.0f}; give a larger --step-mm, a "
                    "coarser --grid or a smaller --box-mm",
                    points, kMostPoints));
  for (size_t axis = 0; axis < 3; ++axis) grid.count[axis] = static_cast<int>(count[axis]);
  return grid;
}

std::optional<Eigen::Vector3d> part_of(const Arguments& arguments) {
  if (arguments.part_mm.empty()) return std::nullopt;
  const Eigen::Vector3d part = kMillimetre * Eigen::Vector3d(arguments.part_mm.data());
  const Box box = *app::box_from_numbers(arguments.box_mm);
  if (part.minCoeff() < 0 || ((box.high - box.low) * (1 + kStepsAlike) - part).minCoeff() < 0)
    throw std::invalid_argument(
        "--part-mm: the part must fit into --box-mm, each side from 0 to that of the box");
  return part;
}

void refuse_other_joints(const PathFile& file, Eigen::Index sample, const Pose& tcp,
                         const std::string& columns) {
  const double apart = (tcp.translation - file.path.position.col(sample)).norm();
  if (apart > kMaxDisagreement)
    throw InputError(fmt::format(
        "{}:{}: its joint angles put the tool {:.4g} mm away from its position; they belong to "
        "another robot, base or tool: correct --controller, --base or --tool, or take the columns "
        "{} out",
        file.source, file.line[sample], apart / kMillimetre, columns));
}

// A path as Cartesian targets with its joint angles, if it has some, as hints.
Program program_of(const PathFile& file, const Robot& controller,
                   const CompensationOptions& options, const Arguments& arguments) {
  const Path& path = file.path;
  if (path.has_orientation() && !arguments.orientation.empty())
    throw InputError(file.source +
                     ": states its orientation, and --orientation is given too; leave that out");
  const auto orientation = orientation_of(controller, options, arguments);
  if (!path.has_orientation() && !orientation && !path.has_joints())
    throw InputError(file.source +
                     ": states neither an orientation (a_deg, b_deg, c_deg) nor joint angles; give "
                     "--orientation a,b,c, or --start with joint angles near its first sample");
  Program program;
  Campaign& visits = program.visits;
  visits.source = file.source;
  visits.line = file.line;
  for (Eigen::Index i = 0; i < path.samples(); ++i) {
    visits.pose.push_back(static_cast<int>(i));
    visits.pose_ids.push_back(std::to_string(i + 1));
    visits.q.emplace_back(path.has_joints() ? JointVector(path.q.col(i))
                                            : JointVector::Zero(joint_count(controller.chain)));
    if (path.has_force()) visits.force_n.emplace_back(path.force.col(i));
    Pose tcp;
    if (path.has_joints()) {
      tcp = tcp_at(controller, options, visits.q.back());
      refuse_other_joints(file, i, tcp, encoder_columns(controller.chain));
    }
    if (path.has_orientation())
      tcp.rotation =
          rotation_from_abc(path.orientation(0, i), path.orientation(1, i), path.orientation(2, i));
    else if (orientation && !(path.has_joints() && arguments.orientation.empty()))
      tcp.rotation = *orientation;
    tcp.translation = path.position.col(i);
    program.poses.push_back(tcp);
    program.hinted.push_back(path.has_joints());
  }
  return program;
}

ErrorMap map_program(const Robot& robot, const Robot& controller, const Program& program,
                     const CompensationOptions& options, Following following) {
  try {
    return map_errors(robot, controller, program, options, following);
  } catch (const UnreachableTarget& error) {
    const auto row = static_cast<size_t>(error.row);
    throw InputError(fmt::format("{}:{}: target '{}': {}", program.visits.source,
                                 program.visits.line[row], program.visits.pose_ids[row],
                                 error.what()));
  }
}

// One row, with what the command line says of all points.
Campaign conditions_of(const Arguments& arguments, const std::vector<const Robot*>& robots) {
  Campaign one;
  one.source = "--box-mm";
  one.pose = {0};
  one.pose_ids = {"box"};
  one.line = {0};
  one.q = {JointVector::Zero(joint_count(robots.front()->chain))};
  app::fill_conditions(one, arguments, robots);
  return one;
}

// What is mapped, and what its rows say.
struct Mapped {
  ErrorMap map;
  Campaign visits;
};

Mapped map_all(app::Command& command, const Robot& robot, const Robot& controller,
               const Arguments& arguments) {
  CompensationOptions options = app::program_options(arguments, controller);
  if (options.tool_is_measured) options.tool = robot.chain.tool;
  if (!arguments.box_mm.empty()) {
    app::require_flange(controller, arguments);
    Grid grid = grid_of(arguments);
    grid.orientation = *orientation_of(controller, options, arguments);
    Mapped mapped{{}, conditions_of(arguments, {&robot, &controller})};
    for (const Robot* of : {&robot, &controller})
      app::require_conditions(mapped.visits, *of, arguments, app::HasColumns::no);
    command.progress("mapping");
    mapped.map = map_errors(robot, controller, grid, mapped.visits, options);
    return mapped;
  }
  Program program;
  if (arguments.path.empty()) {
    program = command.read_program(arguments.targets, controller).program;
  } else {
    const PathFile file = command.read_path(arguments.path, KeepRows::no, controller);
    if (file.lost > 0)
      command.warn(fmt::format("{}: {} rows without a position left out", file.source, file.lost));
    program = program_of(file, controller, options, arguments);
  }
  if (program.is_cartesian()) app::require_flange(controller, arguments);
  app::fill_conditions(program.visits, arguments, {&robot, &controller});
  for (const Robot* of : {&robot, &controller})
    app::require_conditions(program.visits, *of, arguments,
                            arguments.path.empty() ? app::HasColumns::yes : app::HasColumns::no);
  command.progress("mapping");
  Mapped mapped{map_program(robot, controller, program, options,
                            arguments.path.empty() ? Following::branch : Following::continuous),
                {}};
  mapped.visits = std::move(program.visits);
  return mapped;
}

// Reasons to doubt the map, in sentences without a full stop.
std::vector<std::string> doubts_of_map(const Robot& robot, const Robot& controller,
                                       const Mapped& mapped, const ErrorMapSummary& summary,
                                       const Arguments& arguments) {
  std::vector<std::string> found =
      doubts_of_models(app::pair_of(robot, controller, arguments), mapped.visits, "the errors");
  std::vector<std::string> moving;
  for (const Effect& effect : robot.effects)
    if (effect.driver.involves(DriverKind::arrival) || effect.driver.involves(DriverKind::stroke))
      moving.push_back(fmt::format("{} ({} follows {})", effect.name, to_string(effect.parameter),
                                   to_string(effect.driver)));
  if (mapped.map.grid && !moving.empty())
    found.push_back(fmt::format(
        "in a box no joint arrives from anywhere, so {} counts as 0; --targets or --path show it",
        fmt::join(moving, ", ")));
  if (summary.before.max < kNoError)
    found.push_back("the controller already runs the model of " + arguments.robot +
                    ": every error is 0");
  return found;
}

void warn_of_notes(app::Command& command, const ErrorMap& map) {
  for (CommandNote note : map_notes()) {
    const int count = count_of(map, note);
    if (count == 0) continue;
    std::vector<std::string> names;
    for (size_t k = 0; k < map.points.size() && !map.grid && names.size() <= kMostNamed; ++k)
      if (map.points[k].has(note))
        names.push_back(names.size() < kMostNamed ? map.names[k] : "...");
    command.warn(fmt::format("{} of {} points: {}{}", count, map.points.size(), to_string(note),
                             names.empty() ? "" : fmt::format(" ({})", fmt::join(names, ", "))));
  }
}

// The grid of a box is one of places beside the foot of the arm.
void refuse_positioner(const Robot& controller, const Arguments& arguments) {
  if (!controller.ground_link || arguments.box_mm.empty()) return;
  throw InputError(arguments.controller +
                   ": has a positioner, whose axes a box leaves open; give the places as targets "
                   "with e1_deg and so on");
}

int run(app::Command& command, Arguments& arguments) {
  const auto [robot, controller] = app::read_models(command, arguments);
  app::refuse_other_files(robot, controller, arguments);
  refuse_positioner(controller, arguments);
  app::warn_of_tool(command, arguments);
  const std::optional<About> about = app::read_about(command, arguments.page);
  const std::optional<Eigen::Vector3d> part = part_of(arguments);
  const Mapped mapped = map_all(command, robot, controller, arguments);
  const ErrorMap& map = mapped.map;
  const ErrorMapSummary summary = summarize(map, part);
  app::refuse_other_arm(map.points[summary.best].error.norm(),
                        app::pair_of(robot, controller, arguments));

  PredictionConditions conditions{
      robot.name,
      controller.name,
      {fmt::format("The controller runs {} and nothing else.", arguments.controller),
       app::assumed_frames(controller, arguments)},
      station_effects(robot, arguments.tool_is_measured)};
  app::warn_of_doubts(command, doubts_of_map(robot, controller, mapped, summary, arguments),
                      conditions);
  for (const std::string& effect : conditions.not_applied)
    command.warn("not applied, because it belongs to the station: " + effect);
  warn_of_notes(command, map);
  if (!arguments.plot.empty()) write_output(arguments.plot, error_map_plot(map));
  if (!arguments.summary.empty())
    write_output(arguments.summary,
                 write_error_map_summary(map, summary, conditions, command.provenance()));
  write_output(command.output, write_error_map(map, joint_names(robot.chain)));
  command.report(error_map_table(map, summary));
  if (arguments.page.is_wanted())
    app::write_report(command, arguments.page,
                      error_map_page(map, summary, conditions, app::page_head(command, about)));
  return app::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command(
      "map-errors",
      "Predicted error of an arm over a box, the targets of a program or a path, split by cause: "
      "where in the cell should the part stand, what would a calibrated controller gain.",
      "map-errors --robot closed.yaml --controller nominal.yaml --tool 0,0,150,0,0,0 "
      "--box-mm 1400,2200,-400,400,300,1100 --start 0,-60,90,0,60,0 "
      "--plot map.svg -o map.csv");
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
