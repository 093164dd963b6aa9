#include <fmt/format.h>

#include "armtrue/compensation/target_doubts.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/error_map_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/report/error_map_page.h"
#include "armtrue/text/number_text.h"
#include "map_inputs.h"

using namespace armtrue;

namespace {

ErrorMap map_program(const Robot& robot, const Robot& controller, const Program& program,
                     const CompensationOptions& options, Following following) {
  try {
    return map_errors(robot, controller, program, options, following);
  } catch (const UnreachableTarget& error) {
    const size_t row = error.row;
    throw InputError(fmt::format("{}:{}: target '{}': {}", program.visits.source,
                                 program.visits.line[row], program.visits.pose_ids[row],
                                 error.what()));
  }
}

// One row, with what the command line says of all points.
Campaign conditions_of(const app::MapArguments& arguments,
                       const std::vector<const Robot*>& robots) {
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
               const app::MapArguments& arguments) {
  CompensationOptions options = app::program_options(arguments, controller);
  if (options.tool_is_measured) options.tool = robot.chain.tool;
  if (!arguments.box_mm.empty()) {
    app::require_flange(controller, arguments);
    const Grid grid = app::grid_of(arguments, controller, options);
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
      command.warn(fmt::format("{}: {} without a position left out", file.source,
                               counted(file.lost, "row")));
    program = targets_of_path(file.path, file.source, file.line, controller, options,
                              app::stated_orientation(arguments));
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

constexpr double kSmallestPart = 3e-3;  // m: a part of 3 m in m

// The grid of a box is one of places beside the foot of the arm.
void refuse_positioner(const Robot& controller, const app::MapArguments& arguments) {
  if (!controller.ground_link || arguments.box_mm.empty()) return;
  throw InputError(arguments.controller +
                   ": has a positioner, whose axes a box leaves open; give the places as targets "
                   "with e1_deg and so on");
}

int run(app::Command& command, app::MapArguments& arguments) {
  const auto [robot, controller] = app::read_models(command, arguments);
  app::refuse_other_files(robot, controller, arguments);
  refuse_positioner(controller, arguments);
  app::warn_of_units(command, controller, arguments);
  if (const auto turn = app::stated_orientation(arguments))
    app::warn_of_all(command,
                     {doubt_of_frame("of --orientation", Pose{*turn, Eigen::Vector3d::Zero()})});
  const std::optional<About> about = app::read_about(command, arguments.page);
  const std::optional<Eigen::Vector3d> part = app::part_of(arguments);
  if (part && part->maxCoeff() > 0 && part->maxCoeff() < kSmallestPart)
    command.warn(fmt::format(
        "--part-mm: no side of the part is longer than {:g} mm: is it in m? Give it in mm",
        part->maxCoeff() / kMillimetre));
  const Mapped mapped = map_all(command, robot, controller, arguments);
  const ErrorMap& map = mapped.map;
  const ErrorMapSummary summary = summarize(map, part);
  const ModelPair pair = app::pair_of(robot, controller, arguments);
  app::refuse_other_arm(map.points[summary.best].error.norm(), pair);

  PredictionConditions conditions{
      robot.name,
      controller.name,
      {fmt::format("The controller runs {} and nothing else.", arguments.controller),
       app::assumed_frames(controller, arguments)},
      station_effects(robot, arguments.tool_is_measured)};
  app::warn_of_doubts(command, doubts_of_map(pair, mapped.visits, map, summary), conditions);
  app::warn_of_station(command, conditions.not_applied);
  app::warn_of_all(command, sentences_of_notes(map));
  if (!arguments.plot.empty()) write_output(arguments.plot, error_map_plot(map));
  const Document product = write_error_map_summary(map, summary, conditions, command.provenance());
  if (!arguments.summary.empty()) write_output(arguments.summary, product);
  write_output(command.output, write_error_map(map, joint_names(robot.chain)));
  command.report(error_map_table(map, summary));
  if (arguments.page.is_wanted())
    app::write_report(
        command, arguments.page,
        error_map_page(map, summary, conditions, app::page_head(command, product, about)));
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
  app::MapArguments arguments;
  app::add_map_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
