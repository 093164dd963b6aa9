#include "armtrue/effects/robot_model.h"

#include <algorithm>
#include <stdexcept>

namespace armtrue {
namespace {

std::vector<int> moved_parameters(const Effect& effect, const Robot& robot) {
  if (!effect.members.empty()) return {};
  if (!is_group(effect.parameter)) {
    const auto index = find_parameter(robot.chain, effect.parameter);
    if (!index || *index > kInstrumentScale)
      throw std::invalid_argument("effect '" + effect.name + "': the robot has no parameter '" +
                                  effect.parameter + "'");
    return {*index};
  }
  const int first = effect.parameter == "base" ? kBaseParameters : kToolParameters;
  // A moment turns a group about the moment's own axis; every other driver may move it any way.
  std::vector<int> parameters;
  for (int i = effect.driver.kind == DriverKind::moment ? 3 : 0; i < 6; ++i)
    parameters.push_back(first + i);
  return parameters;
}

// Names of the values of a shape, as the coefficients are called in files.
std::vector<std::string> value_names(const Shape& shape, int count) {
  if (shape.kind == ShapeKind::harmonic) return {"sin", "cos"};
  if (count == 1) return {"c"};
  std::vector<std::string> names;
  for (int k = 1; k <= count; ++k) names.push_back("c" + std::to_string(k));
  return names;
}

}  // namespace

BoundEffect::BoundEffect(const Effect& effect, const Robot& robot,
                         const std::vector<std::string>& temperature_names)
    : driver_(effect.driver), shape_(effect.shape), parameters_(moved_parameters(effect, robot)) {
  if (!effect.members.empty()) {
    bind_members(effect, robot, temperature_names);
    return;
  }
  const auto fail = [&](const std::string& why) {
    throw std::invalid_argument("effect '" + effect.name + "': " + why);
  };
  if (const std::string why = why_invalid(effect.parameter, driver_, shape_); !why.empty())
    fail(why);
  if (driver_.involves(DriverKind::temperature)) {
    const auto found = std::find(temperature_names.begin(), temperature_names.end(), driver_.where);
    if (found == temperature_names.end())
      fail("nothing here tells the temperature '" + driver_.where +
           "'; measurements tell it in a column temp_" + driver_.where + "_c");
    temperature_ = static_cast<int>(found - temperature_names.begin());
  }
  if (driver_.kind == DriverKind::gravity_torque)
    loads_.emplace_back(robot, link_parameter(driver_.joint, LinkParameter::theta));
  if (driver_.kind == DriverKind::moment)
    for (int parameter : parameters_) loads_.emplace_back(robot, parameter);

  // Without masses a load is a basis of several values, which only a linear law can use.
  int load_values = 1;
  for (const GravityLoad& load : loads_) load_values = std::max(load_values, load.value_count());
  if (load_values > 1 && shape_.kind != ShapeKind::linear)
    fail("the shape '" + to_string(shape_) + "' of a torque needs the robot's masses");
  for (const GravityLoad& load : loads_)
    if (load.value_count() != load_values && load.value_count() != 0)
      fail("the gravity basis differs between the components of '" + effect.parameter + "'");

  needs_frames_ = !loads_.empty();
  needs_jacobian_ = driver_.involves(DriverKind::force);
  const int members = static_cast<int>(parameters_.size());
  const bool is_vector = driver_.kind == DriverKind::moment && members > 1;
  own_values_ = is_vector || needs_jacobian_;
  const int values = std::max(load_values, armtrue::value_count(shape_, driver_.is_pair()));
  const std::vector<std::string> names = value_names(shape_, values);
  value_count_ = own_values_ ? members * values : values;
  coefficient_count_ = is_vector ? values : members * values;
  for (int i = 0; i < members; ++i)
    for (int k = 0; k < values; ++k)
      terms_.push_back(
          {parameters_[i], is_vector ? k : i * values + k, own_values_ ? i * values + k : k});
  if (is_vector || members == 1)
    coefficient_names_ = names;
  else
    for (const char* member : kTwistNames)
      for (const std::string& name : names)
        coefficient_names_.push_back(values == 1 ? member : member + (" " + name));
}

// Terms, values and coefficients of the members, one after the other.
void BoundEffect::bind_members(const Effect& effect, const Robot& robot,
                               const std::vector<std::string>& temperature_names) {
  for (const Effect& member : effect.members) {
    const BoundEffect& bound = members_.emplace_back(member, robot, temperature_names);
    for (Term term : bound.terms_) {
      term.coefficient += coefficient_count_;
      term.value += value_count_;
      terms_.push_back(term);
    }
    for (int parameter : bound.parameters_)
      if (std::ranges::count(parameters_, parameter) == 0) parameters_.push_back(parameter);
    for (const std::string& name : bound.coefficient_names_)
      coefficient_names_.push_back(member.parameter + " " + name);
    coefficient_count_ += bound.coefficient_count_;
    value_count_ += bound.value_count_;
    needs_frames_ |= bound.needs_frames_;
    needs_jacobian_ |= bound.needs_jacobian_;
  }
}

double BoundEffect::driver_value(DriverKind kind, int joint, size_t member, const Context& context,
                                 const ArmFrames* frames, const PoseJacobian* jacobian) const {
  switch (kind) {
    case DriverKind::joint_angle:
      return context.q[joint];
    case DriverKind::motor_torque:
      return context.motor_torque_nm[joint];
    case DriverKind::arrival:
      return context.arrival[joint];
    case DriverKind::time:
      return context.time_s;
    case DriverKind::temperature:
      return context.temperature_c[temperature_];
    case DriverKind::payload:
      return context.payload_kg;
    case DriverKind::force:
      return jacobian->col(parameters_[member]).head<3>().dot(context.force_n);
    case DriverKind::position:
      return 1.0;
    case DriverKind::gravity_torque:
    case DriverKind::moment:
      break;
  }
  double load = 0;
  load_on(member).values(context, *frames, &load);
  return load;
}

void BoundEffect::shape_values(size_t member, const Context& context, const ArmFrames* frames,
                               const PoseJacobian* jacobian, double* out) const {
  if (driver_.is_pair())
    return evaluate_product(shape_, context.q[driver_.joint], context.q[driver_.second_joint], out);
  const bool linear_load = !loads_.empty() && shape_.kind == ShapeKind::linear;
  if (!linear_load)
    return evaluate(
        shape_, driver_value(driver_.kind, driver_.joint, member, context, frames, jacobian), out);
  // Without masses, all values of the basis; none if gravity does no work on this parameter.
  if (load_on(member).value_count() > 0) load_on(member).values(context, *frames, out);
}

void BoundEffect::values(const Context& context, const ArmFrames* frames,
                         const PoseJacobian* jacobian, double* out) const {
  constexpr double kReferenceTemperature = 20;  // deg C, ISO 1
  std::fill(out, out + value_count_, 0.0);
  for (const BoundEffect& member : members_) {
    member.values(context, frames, jacobian, out);
    out += member.value_count_;
  }
  if (!members_.empty()) return;
  const size_t members = own_values_ ? parameters_.size() : 1;
  const auto values = value_count_ / static_cast<int>(members);
  for (size_t i = 0; i < members; ++i) {
    double* const own = out + static_cast<int>(i) * values;
    shape_values(i, context, frames, jacobian, own);
    if (!driver_.factor) continue;
    double factor =
        driver_value(*driver_.factor, driver_.second_joint, i, context, frames, jacobian);
    if (driver_.factor == DriverKind::temperature) factor -= kReferenceTemperature;
    for (int k = 0; k < values; ++k) own[k] *= factor;
  }
}

RobotModel::RobotModel(const Robot& robot, const std::vector<std::string>& temperature_names)
    : chain_(robot.chain), targets_(robot.chain.targets), anchors_(robot.chain.anchors) {
  for (const Effect& effect : robot.effects) {
    if (effect.driver.kind == DriverKind::motor_torque)
      throw std::invalid_argument("effect '" + effect.name +
                                  "' follows a measured motor torque, which nobody knows of a pose "
                                  "that was not measured; let it follow gravity-torque");
    effects_.emplace_back(effect, robot, temperature_names);
    if (effects_.back().coefficient_count() != static_cast<int>(effect.coefficients.size()))
      throw std::invalid_argument("effect '" + effect.name + "' has " +
                                  std::to_string(effect.coefficients.size()) +
                                  " coefficients; its parameter, driver and shape need " +
                                  std::to_string(effects_.back().coefficient_count()));
    auto& values = coefficients_.emplace_back();
    for (const Coefficient& c : effect.coefficients) values.push_back(c.value);
  }
}

Eigen::Matrix<double, kGeometricParameters + 1, 1> RobotModel::offsets(
    const Context& context) const {
  Eigen::Matrix<double, kGeometricParameters + 1, 1> offsets;
  offsets.setZero();
  ArmFrames frames;
  PoseJacobian jacobian;
  bool have_frames = false, have_jacobian = false;
  std::vector<double> values;
  for (size_t e = 0; e < effects_.size(); ++e) {
    const BoundEffect& effect = effects_[e];
    if (effect.needs_frames() && !have_frames) {
      frames = chain_.link_frames(context.q);
      have_frames = true;
    }
    if (effect.needs_jacobian() && !have_jacobian) {
      chain_.pose(context.q, jacobian);
      have_jacobian = true;
    }
    values.resize(effect.value_count());
    effect.values(context, &frames, &jacobian, values.data());
    for (const BoundEffect::Term& term : effect.terms())
      offsets[term.parameter] += coefficients_[e][term.coefficient] * values[term.value];
  }
  return offsets;
}

Pose RobotModel::pose(const Context& context) const {
  if (effects_.empty()) return chain_.pose(context.q);
  const auto all = offsets(context);
  Pose pose = chain_.pose(context.q, all.head<kGeometricParameters>());
  pose.translation *= 1.0 + all[kInstrumentScale];
  return pose;
}

Eigen::Vector3d RobotModel::point(const Context& context, int target) const {
  const Eigen::Vector3d position =
      target < 0 ? Eigen::Vector3d::Zero() : targets_[static_cast<size_t>(target)].position;
  if (effects_.empty()) return chain_.pose(context.q) * position;
  const auto all = offsets(context);
  return (1.0 + all[kInstrumentScale]) *
         (chain_.pose(context.q, all.head<kGeometricParameters>()) * position);
}

double RobotModel::distance(const Context& context, int target, int anchor) const {
  const double scale = effects_.empty() ? 1.0 : 1.0 + offsets(context)[kInstrumentScale];
  const Anchor& from = anchors_[static_cast<size_t>(anchor)];
  return scale * (point(context, target) / scale - from.position).norm() + from.zero;
}

}  // namespace armtrue
