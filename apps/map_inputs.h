#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/compensation/map_places.h"
#include "program_arguments.h"
#include "report_arguments.h"

namespace armtrue::app {

/// What map-errors is asked for.
struct MapArguments : ProgramArguments {
  std::string targets, path, summary, plot;
  ReportArguments page;
  std::vector<double> box_mm, grid, orientation, part_mm;
  std::optional<double> step_mm;
};

void add_map_options(Command& command, MapArguments& arguments);

/// --orientation; nothing without it.
std::optional<Eigen::Matrix3d> stated_orientation(const MapArguments& arguments);

/// The grid of --box-mm, with --grid or --step-mm, in that orientation or the one at --start.
Grid grid_of(const MapArguments& arguments, const Robot& controller,
             const CompensationOptions& options);

/// --part-mm [m]; nothing without it. Throws a mistake in the arguments if it does not fit.
std::optional<Eigen::Vector3d> part_of(const MapArguments& arguments);

}  // namespace armtrue::app
