#include "diagnosis/scale_check.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "armtrue/kinematics/parameters.h"

namespace armtrue {

std::optional<std::string> find_scale_of_anchor(const PlainFit& fit) {
  constexpr double kShareThatMatters = 0.25, kClearFall = 20, kLeastScale = 1e-3;
  const Campaign& readings = fit.readings;
  if (!readings.has_distances() || readings.anchor_names.size() < 2) return std::nullopt;
  const KinematicChain& chain = fit.result.robot.chain;
  const FitEquations equations = fit_equations(fit, {layout_of(chain).instrument_scale});
  const double whole = equations.residual.squaredNorm();
  const auto poses =
      static_cast<double>(std::set<int>(readings.pose.begin(), readings.pose.end()).size());
  const auto anchors = static_cast<double>(readings.anchor_names.size());
  std::optional<std::string> found;
  double best = kClearFall;
  for (size_t anchor = 0; anchor < readings.anchor_names.size(); ++anchor) {
    Eigen::VectorXd column = equations.columns.col(0);
    for (int row = 0; row < readings.rows(); ++row)
      if (readings.anchor[row] != static_cast<int>(anchor) ||
          readings.kind(row) != ReadingKind::distance)
        column.segment(row * equations.row_size, equations.row_size).setZero();
    column -= equations.basis * (equations.basis.transpose() * column);
    const double size = column.squaredNorm(), slope = column.dot(equations.residual);
    if (!(size > 0) || std::abs(slope) < kLeastScale * size) continue;
    const double share = std::min(1 - 1e-12, slope * slope / (size * whole));
    const double fall = -poses * std::log(1 - share) - std::log(poses) - 2 * std::log(anchors);
    if (share < kShareThatMatters || fall <= best) continue;
    best = fall;
    found = fmt::format(
        "the distances from anchor {} are too {} by {:.2g} %, those from the others are not: check "
        "the scale of that instrument (its drum, its unit)",
        readings.anchor_names[anchor], slope > 0 ? "long" : "short", 100 * std::abs(slope) / size);
  }
  return found;
}

std::optional<std::string> find_scale_of_links(const PlainFit& fit, const Robot& nominal) {
  constexpr double kLeastScale = 2e-3, kMostLeft = 0.1;
  constexpr int kFewestLengths = 3;
  const std::vector<int>& kept = fit.result.set.kept;
  double product = 0, square = 0, changed = 0;
  int lengths = 0;
  for (size_t i = 0; i < kept.size(); ++i) {
    const int parameter = kept[i];
    if (!layout_of(nominal.chain).is_of_links(parameter) ||
        parameter_unit(nominal.chain, parameter) != ParameterUnit::metre)
      continue;
    const int link = link_of_parameter(parameter);
    const Link& of = nominal.chain.links[static_cast<size_t>(link)];
    const double length =
        parameter == link_parameter(link, LinkParameter::d) ? of.d : of.r;
    const double change = fit.result.change[static_cast<Eigen::Index>(i)];
    product += length * change;
    square += length * length;
    changed += change * change;
    lengths += length != 0;
  }
  if (lengths < kFewestLengths) return std::nullopt;
  const double scale = product / square;
  const double left = changed - scale * product;
  if (std::abs(scale) < kLeastScale || left > kMostLeft * changed) return std::nullopt;
  return fmt::format(
      "the links come out {} by {:.2g} % alike, as no arm is made: check the scale and the unit of "
      "the instrument, or the lengths of the robot file",
      scale > 0 ? "longer" : "shorter", 100 * std::abs(scale));
}

}  // namespace armtrue
