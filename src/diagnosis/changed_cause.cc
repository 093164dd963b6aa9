#include "diagnosis/changed_cause.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

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
                          const ChangedPart& part, bool of_images) {
  const bool is_length = parameter_unit(chain, cause.parameter) == ParameterUnit::metre;
  const std::string& name = chain.links[link_of_parameter(cause.parameter)].name;
  const double size = std::abs(value) / (is_length ? kMillimetre : kDegree);
  const std::string_view unit = is_length ? "mm" : "deg";
  if (of_images)
    return fmt::format(
        "{} the zero of {} moved by {:.3g} {}: was the arm mastered, or a motor exchanged? Then "
        "calibrate the parts by themselves",
        part.words, name, size, unit);
  return fmt::format(
      "{} the zero of {} is {:.3g} {} away from that in the others: was the arm mastered, or a "
      "motor exchanged? Then {}write identify_per_session: [{}] into the robot file",
      part.words, name, size, unit, part.session.empty() ? "" : "give " + part.session + ", and ",
      parameter_name(chain, cause.parameter));
}

std::string describe_contact(const Cause& cause, const Eigen::VectorXd& value,
                             const KinematicChain& chain, const ChangedPart& part) {
  const Contact& contact =
      chain.contacts[(cause.parameter - first_contact_parameter(chain)) / kParametersOfContact];
  const std::string_view kind = contact.kind == ContactKind::camera ? "camera" : "board";
  return fmt::format(
      "{0} the {1} '{2}' moved by {3:.3g} mm and {4:.3g} mrad: was it knocked? Then give it another "
      "name from there on (column '{1}'), and an entry under '{1}s' of the robot file",
      part.words, kind, contact.name, value.head<3>().norm() / kMillimetre,
      value.tail<3>().norm() / kMilliradian);
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
  const bool of_images = fit.readings.has_pixels_only();
  for (int number = 0; of_images && number < std::ssize(robot.chain.contacts); ++number)
    if (is_of_images(robot.chain.contacts[number].kind))
      causes.add(Cause::Kind::contact,
                 first_contact_parameter(robot.chain) + kParametersOfContact * number,
                 kParametersPerPose);
  if (with_base && !of_images)
    causes.add(Cause::Kind::base, kFirstBaseParameter, kParametersPerPose);
  if (fit.readings.target_names.size() < 2 && !of_images)
    causes.add(Cause::Kind::tool, layout.tool,
               fit.readings.has_orientation() ? kParametersPerPose : kPoint);
  // A zero that is not identified is one of base or tool: the likelier cause.
  for (const int parameter : fit.result.set.kept)
    if (is_zero_offset(robot.chain, parameter) && std::ranges::find(own, parameter) == own.end())
      causes.add(Cause::Kind::zero, parameter, 1);
  if (of_images) return causes;
  causes.add(Cause::Kind::scale, layout.instrument_scale, 1);
  if (!fit.readings.reads_one_number()) causes.add(Cause::Kind::range, layout.instrument_range, 1);
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
      return describe_zero(cause, value[0], robot.chain, part, fit.readings.has_pixels_only());
    case Cause::Kind::scale:
      return fmt::format(
          "{} the instrument reads lengths {:.2g} % {} than in the others: check its scale, its "
          "unit and its correction for the air",
          part.words, 100 * std::abs(value[0]), value[0] > 0 ? "longer" : "shorter");
    case Cause::Kind::contact:
      return describe_contact(cause, value, robot.chain, part);
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
