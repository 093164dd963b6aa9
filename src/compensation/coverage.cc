#include "compensation/coverage.h"

#include <algorithm>
#include <cmath>

#include "armtrue/effects/flange_or_tool.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/observation/observation.h"
#include "compensation/program_arm.h"

namespace armtrue {
namespace {

bool is_of_a_link(const KinematicChain& chain, const std::string& name) {
  const auto index = find_parameter(chain, name);
  return index && layout_of(chain).is_of_links(*index);
}

// The robot with the effects that move a program. Of its uncertainty it keeps their rows and those
// of the geometric parameters that `keep` accepts.
template <typename Keep>
Robot part_of(const Robot& robot, bool tool_is_measured, const Keep& keep) {
  Robot part = without_station_effects(robot, tool_is_measured);
  Uncertainty& known = *part.uncertainty;
  known.parameters.clear();
  std::vector<Eigen::Index> rows;
  Eigen::Index row = 0;
  for (const std::string& name : robot.uncertainty->parameters) {
    if (keep(name)) {
      known.parameters.push_back(name);
      rows.push_back(row);
    }
    ++row;
  }
  for (const Effect& effect : robot.effects)
    for (size_t k = 0; k < effect.coefficients.size(); ++k, ++row)
      if (moves_program(effect, tool_is_measured) && row < robot.uncertainty->root.rows())
        rows.push_back(row);
  known.root = Eigen::MatrixXd(robot.uncertainty->root(rows, Eigen::all));
  return part;
}

// Readings at the visits, as far as a prediction needs them.
Campaign readings_at(Campaign visits, const Pose& base) {
  visits.position.assign(visits.q.size(), Eigen::Vector3d::Zero());
  for (Eigen::Vector3d& force : visits.force_n) force = base.rotation * force;
  return visits;
}

// Variances of the positions of all rows by the uncertainty of a robot, the sum over the axes.
std::vector<double> position_variances(const Robot& robot, const Campaign& readings) {
  const Uncertainty& known = *robot.uncertainty;
  std::vector<int> geometric;
  for (const std::string& name : known.parameters)
    geometric.push_back(find_parameter(robot.chain, name).value());
  const ObservationModel model(readings, robot, geometric, {1.0, 1.0});
  const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
  const auto count = std::min<Eigen::Index>(model.unknowns(), known.root.rows());
  Eigen::MatrixXd block(model.row_size(), model.unknowns() + 1);
  Eigen::MatrixXd moved(3, known.root.cols());
  std::vector<double> variances;
  for (int row = 0; row < model.rows(); ++row) {
    at.block(row, block);
    moved.noalias() = block.topLeftCorner(3, count) * known.root.topRows(count);
    variances.push_back(moved.squaredNorm());
  }
  return variances;
}

bool lacks_driver(const Effect& effect, const Campaign& visits) {
  const auto lacks = [&](DriverKind kind) {
    return !missing_column(visits, kind, effect.driver.where).empty();
  };
  return lacks(effect.driver.kind) || (effect.driver.factor && lacks(*effect.driver.factor));
}

// Whether an effect that is not applied may be the arm's all the same.
bool is_doubtful(const Effect& effect, bool tool_is_measured) {
  return !moves_program(effect, tool_is_measured) &&
         (effect.may_be_instrument || is_of_flange_or_tool(effect));
}

// As if what may be the instrument's were the arm's, and what may be the tool's the flange's, as
// far as the visits tell it. Effects of the tool alone are left out.
Robot with_doubtful_effects(Robot robot, const CompensationOptions& options,
                            const Campaign& visits) {
  const auto is_told = [&](const Effect& of_arm) {
    return (moves_program(of_arm, options.tool_is_measured) || is_of_flange_or_tool(of_arm)) &&
           !lacks_driver(of_arm, visits);
  };
  for (Effect& effect : robot.effects) {
    Effect of_arm = effect;
    of_arm.may_be_instrument = false;
    of_arm.mean = 0;
    if (is_doubtful(effect, options.tool_is_measured) && is_told(of_arm)) effect = of_arm;
  }
  std::erase_if(robot.effects, [&](const Effect& effect) {
    return owner_of(effect) == Owner::tool && !is_told(effect);
  });
  return robot;
}

std::vector<double> distances_by_doubtful_effects(const Robot& identified,
                                                  const CompensationOptions& options,
                                                  const Campaign& visits) {
  std::vector<double> distances(visits.q.size(), 0);
  if (std::ranges::none_of(identified.effects, [&](const Effect& effect) {
        return is_doubtful(effect, options.tool_is_measured);
      }))
    return distances;
  const ProgramArm applied(identified, options, options.tool, visits.temperature_names);
  CompensationOptions of_flange = options;
  of_flange.tool_is_measured = true;
  const ProgramArm doubtful(with_doubtful_effects(identified, options, visits), of_flange,
                            options.tool, visits.temperature_names);
  for (int row = 0; row < visits.rows(); ++row) {
    const Context context = visits.context(row);
    distances[row] = difference(applied.pose(context), doubtful.pose(context)).position;
  }
  return distances;
}

}  // namespace

Coverage coverage(const Robot& identified, const CompensationOptions& options,
                  const Campaign& visits) {
  Coverage result;
  if (!identified.uncertainty) return result;
  const Campaign readings = readings_at(visits, identified.chain.base);
  const bool measured = options.tool_is_measured;
  // With base and tool of the calibration, to which the largest variance belongs.
  const Uncertainty& known = *identified.uncertainty;
  const double largest = known.largest_variance_of_point > 0 ? known.largest_variance_of_point
                                                             : known.largest_variance;
  for (double variance : position_variances(
           part_of(identified, measured, [](const std::string&) { return true; }), readings))
    result.leverage.push_back(largest > 0 ? variance / largest : 0);
  Robot arm = part_of(identified, measured, [&](const std::string& name) {
    return is_of_a_link(identified.chain, name);
  });
  arm.chain.tool = options.tool;
  for (double variance : position_variances(arm, readings))
    result.deviation.push_back(std::sqrt(variance));
  result.not_applied = distances_by_doubtful_effects(identified, options, visits);
  return result;
}

}  // namespace armtrue
