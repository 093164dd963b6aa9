#include "diagnosis/changed_cause.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "armtrue/campaign/sessions.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

std::string describe_base(const Eigen::VectorXd& value, const PlainFit& fit,
                          const ChangedPart& part) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : fit.readings.position) middle += point / fit.readings.rows();
  const Eigen::Vector3d turned = value.tail<3>();
  const Eigen::Vector3d moved =
      value.head<3>() + turned.cross(middle - fit.result.robot.chain.base.translation);
  return moved_frame_in_words(moved.norm(), turned.norm(), part);
}

std::string describe_tool(const Eigen::VectorXd& value, const ChangedPart& part) {
  const bool is_pose = value.size() > 3;
  return moved_tool_in_words(value.head<3>().norm(),
                             is_pose ? std::optional(value.tail<3>().norm()) : std::nullopt, part);
}

std::string describe_zero(const Cause& cause, double value, const KinematicChain& chain,
                          const ChangedPart& part) {
  const bool is_length = parameter_unit(chain, cause.parameter) == ParameterUnit::metre;
  return fmt::format(
      "{} the zero of {} is {:.3g} {} away from that in the others: was the arm mastered, or a "
      "motor exchanged? Then {}write identify_per_session: [{}] into the robot file",
      part.words, chain.links[link_of_parameter(cause.parameter)].name,
      std::abs(value) / (is_length ? kMillimetre : kDegree), is_length ? "mm" : "deg",
      part.session.empty() ? "" : "give " + part.session + ", and ",
      parameter_name(chain, cause.parameter));
}

}  // namespace

void Causes::add(Cause::Kind kind, int parameter, int count) {
  all.push_back({kind, static_cast<int>(parameters.size()), count, parameter});
  for (int k = 0; k < count; ++k) parameters.push_back(parameter + k);
}

Causes possible_causes(const PlainFit& fit, bool with_base) {
  constexpr int kPoint = 3;
  const Robot& robot = fit.result.robot;
  const ParameterLayout layout = layout_of(robot.chain);
  const std::vector<int> own = own_parameters(robot);
  Causes causes;
  if (with_base) causes.add(Cause::Kind::base, kFirstBaseParameter, kParametersPerPose);
  if (fit.readings.target_names.size() < 2)
    causes.add(Cause::Kind::tool, layout.tool,
               fit.readings.has_orientation() ? kParametersPerPose : kPoint);
  // A zero that is not identified is one of base or tool: the likelier cause.
  for (const int parameter : fit.result.set.kept)
    if (is_zero_offset(robot.chain, parameter) && std::ranges::find(own, parameter) == own.end())
      causes.add(Cause::Kind::zero, parameter, 1);
  causes.add(Cause::Kind::scale, layout.instrument_scale, 1);
  if (!fit.readings.has_distances()) causes.add(Cause::Kind::range, layout.instrument_range, 1);
  return causes;
}

std::string moved_frame_in_words(double moved, double turned, const ChangedPart& part) {
  return fmt::format(
      "{} the readings lie in another frame, {:.3g} mm and {:.3g} mrad away: was the instrument "
      "moved? Then give {}",
      part.words, moved / kMillimetre, turned / kMilliradian, part.session);
}

std::string moved_tool_in_words(double moved, std::optional<double> turned,
                                const ChangedPart& part) {
  return fmt::format(
      "{} the reflector is elsewhere on the tool, {:.3g} mm{} away: was the tool changed or the "
      "reflector seated anew? Then give a column 'target' with another name there, or calibrate "
      "the parts by themselves",
      part.words, moved / kMillimetre,
      turned ? fmt::format(" and {:.3g} mrad", *turned / kMilliradian) : "");
}

std::string describe_change(const Cause& cause, const Eigen::VectorXd& value, const PlainFit& fit,
                            const ChangedPart& part) {
  const Robot& robot = fit.result.robot;
  switch (cause.kind) {
    case Cause::Kind::base:
      return describe_base(value, fit, part);
    case Cause::Kind::tool:
      return describe_tool(value, part);
    case Cause::Kind::zero:
      return describe_zero(cause, value[0], robot.chain, part);
    case Cause::Kind::scale:
      return fmt::format(
          "{} the instrument reads lengths {:.2g} % {} than in the others: check its scale, its "
          "unit and its correction for the air",
          part.words, 100 * std::abs(value[0]), value[0] > 0 ? "longer" : "shorter");
    case Cause::Kind::range:
      break;
  }
  return fmt::format(
      "{} the points lie {:.3g} mm too {} the place of the instrument, {}: check the constant of "
      "its reflector, and correct the readings",
      part.words, std::abs(value[0]) / kMillimetre, value[0] > 0 ? "far from" : "near to",
      robot.instrument ? "instrument_mm of the robot file" : "the origin of R_A");
}

}  // namespace armtrue
