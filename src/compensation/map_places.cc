#include "armtrue/compensation/map_places.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"

namespace armtrue {
namespace {

constexpr double kDefaultSteps = 20;  // along the longest side of a box
constexpr double kMostPoints = 2e6;   // of a grid: 1 GB
constexpr double kStepsAlike = 1e-9;  // of a step: rounding adds no point
constexpr double kFarthestApart = 10 * kMillimetre;
constexpr double kNoError = 1e-9;  // [m], [rad]

void refuse_other_joints(const Path& path, Eigen::Index sample, const Pose& tcp,
                         const std::string& place, const std::string& columns) {
  const double apart = (tcp.translation - path.position.col(sample)).norm();
  if (apart > kFarthestApart)
    throw InputError(fmt::format(
        "{}: its joint angles put the tool {:.4g} mm away from its position; they belong to "
        "another robot, base or tool: correct --controller, --base or --tool, or take the columns "
        "{} out",
        place, apart / kMillimetre, columns));
}

}  // namespace

Grid grid_of_box(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                 const GridSpacing& spacing) {
  Grid grid{low, high};
  const Eigen::Vector3d side = high - low;
  const double step = spacing.step.value_or(std::max(side.maxCoeff() / kDefaultSteps, kNoError));
  double points = 1;
  std::array<double, 3> count{};
  for (int axis = 0; axis < 3; ++axis) {
    count[axis] =
        spacing.count ? (*spacing.count)[axis] : std::ceil(side[axis] / step - kStepsAlike) + 1;
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
  for (int axis = 0; axis < 3; ++axis) grid.count[axis] = static_cast<int>(count[axis]);
  return grid;
}

Pose tcp_in_program(const Robot& controller, const CompensationOptions& options,
                    const JointVector& q) {
  KinematicChain chain = controller.chain;
  chain.base = {};
  chain.tool = options.tool;
  return inverse(options.base) * ChainEvaluator(chain).pose(q);
}

Program targets_of_path(const Path& path, const std::string& source, const std::vector<int>& lines,
                        const Robot& controller, const CompensationOptions& options,
                        const std::optional<Eigen::Matrix3d>& orientation) {
  if (path.has_orientation() && orientation)
    throw InputError(source +
                     ": states its orientation, and --orientation is given too; leave that out");
  if (!path.has_orientation() && !orientation && !options.start && !path.has_joints())
    throw InputError(source +
                     ": states neither an orientation (a_deg, b_deg, c_deg) nor joint angles; give "
                     "--orientation a,b,c, or --start with joint angles near its first sample");
  Program program;
  Campaign& visits = program.visits;
  visits.source = source;
  visits.line = lines;
  for (Eigen::Index i = 0; i < path.samples(); ++i) {
    visits.pose.push_back(static_cast<int>(i));
    visits.pose_ids.push_back(std::to_string(i + 1));
    visits.q.emplace_back(path.has_joints() ? JointVector(path.q.col(i))
                                            : JointVector::Zero(joint_count(controller.chain)));
    if (path.has_force()) visits.force_n.emplace_back(path.force.col(i));
    Pose tcp;
    if (path.has_joints()) {
      tcp = tcp_in_program(controller, options, visits.q.back());
      refuse_other_joints(path, i, tcp, fmt::format("{}:{}", source, lines[i]),
                          encoder_columns(controller.chain));
    } else if (options.start) {
      tcp = tcp_in_program(controller, options, *options.start);
    }
    if (path.has_orientation())
      tcp.rotation =
          rotation_from_abc(path.orientation(0, i), path.orientation(1, i), path.orientation(2, i));
    else if (orientation)
      tcp.rotation = *orientation;
    tcp.translation = path.position.col(i);
    program.poses.push_back(tcp);
    program.hinted.push_back(path.has_joints());
  }
  return program;
}

std::vector<std::string> doubts_of_map(const ModelPair& pair, const Campaign& visits,
                                       const ErrorMap& map, const ErrorMapSummary& summary) {
  std::vector<std::string> found = doubts_of_models(pair, visits, "the errors");
  std::vector<std::string> moving;
  for (const Effect& effect : pair.robot.effects)
    if (effect.driver.involves(DriverKind::arrival) || effect.driver.involves(DriverKind::stroke))
      moving.push_back(fmt::format("{} ({} follows {})", effect.name, to_string(effect.parameter),
                                   to_string(effect.driver)));
  if (map.grid && !moving.empty())
    found.push_back(fmt::format(
        "in a box no joint arrives from anywhere, so {} counts as 0; --targets or --path show it",
        fmt::join(moving, ", ")));
  if (std::max(summary.before.max, summary.turn.max) < kNoError)
    found.push_back("the controller already runs the model of " + pair.robot_name +
                    ": every error is 0");
  return found;
}

std::vector<std::string> sentences_of_notes(const ErrorMap& map) {
  constexpr size_t kMostNamed = 5;
  std::vector<std::string> sentences;
  for (CommandNote note : map_notes()) {
    const int count = count_of(map, note);
    if (count == 0) continue;
    std::vector<std::string> names;
    for (size_t k = 0; k < map.points.size() && !map.grid && names.size() <= kMostNamed; ++k)
      if (map.points[k].has(note))
        names.push_back(names.size() < kMostNamed ? map.names[k] : "...");
    sentences.push_back(
        fmt::format("{} of {} points: {}{}", count, map.points.size(), to_string(note),
                    names.empty() ? "" : fmt::format(" ({})", fmt::join(names, ", "))));
  }
  return sentences;
}

}  // namespace armtrue
