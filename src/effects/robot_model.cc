#include "armtrue/effects/robot_model.h"

#include <optional>
#include <stdexcept>
#include <utility>

#include "armtrue/effects/line_of_sight.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/names.h"

namespace armtrue {

using Eigen::Vector3d;

namespace {

constexpr double kReferenceTemperature = 20;  // deg C, ISO 1

// The parameters that an effect moves: of arm.scale itself and all lengths, none of a whole family.
std::vector<int> moved_parameters(const Effect& effect, const Robot& robot) {
  if (!effect.members.empty()) return {};
  const auto first = first_parameter(robot.chain, effect.parameter);
  if (!first)
    throw std::invalid_argument("effect '" + effect.name + "': the robot has no parameter '" +
                                to_string(effect.parameter) + "'");
  if (is_arm_scale(effect.parameter)) {
    std::vector<int> parameters = lengths_of_arm(robot);
    parameters.insert(parameters.begin(), *first);
    return parameters;
  }
  const int size = group_size(effect.parameter);
  // A moment turns a group about the moment's own axis; every other driver may move it any way.
  std::vector<int> parameters;
  for (int i = size == 6 && effect.driver.kind == DriverKind::moment ? 3 : 0; i < size; ++i)
    parameters.push_back(*first + i);
  return parameters;
}

// From where the driver `range` counts: a wire from its anchor, a line of sight from the instrument.
Vector3d origin_of_range(const Effect& effect, const Robot& robot) {
  if (effect.parameter.owner == Owner::anchor)
    for (const Anchor& anchor : robot.chain.anchors)
      if (anchor.name == effect.parameter.of) return anchor.position;
  return instrument_place(robot);
}

// The robot with nothing but 1 kg at the measured frame.
Robot with_unit_weight(Robot robot) {
  robot.bodies = {{link_count(robot.chain) - 1, 1.0, robot.chain.tool.translation}};
  return robot;
}

}  // namespace

BoundEffect::BoundEffect(const Effect& effect, const Robot& robot,
                         const std::vector<std::string>& temperature_names)
    : driver_(effect.driver),
      shape_(effect.shape),
      measured_(effect.driver_range),
      base_(robot.chain.base),
      tool_(robot.chain.tool),
      instrument_(origin_of_range(effect, robot)),
      up_(upwards(robot)),
      gravity_(robot.gravity.normalized()),
      ground_(robot.ground_link.value_or(-1)),
      parameters_(moved_parameters(effect, robot)) {
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
    const auto found = find_name(temperature_names, driver_.where);
    if (!found)
      fail("nothing here tells the temperature '" + driver_.where +
           "'; measurements tell it in a column temp_" + driver_.where + "_c");
    temperature_ = *found;
  }
  const bool by_vertical = driver_.kind == DriverKind::azimuth ||
                           driver_.kind == DriverKind::elevation ||
                           is_instrument_parameter(effect.parameter, InstrumentParameter::elevation) ||
                           is_instrument_parameter(effect.parameter, InstrumentParameter::azimuth);
  if (robot.ground_link && by_vertical)
    fail("the vertical turns in the frame of the part, so that azimuth and elevation mean nothing");
  const int joints = joint_count(robot.chain);
  if (std::max(driver_.joint, driver_.second_joint) >= joints)
    fail("'" + to_string(driver_) + "' is about joint " +
         std::to_string(std::max(driver_.joint, driver_.second_joint) + 1) +
         ", and the robot has " + std::to_string(joints));
  needs_jacobian_ = driver_.involves(DriverKind::force);
  if (is_arm_scale(effect.parameter))
    for (int k : parameters_) factors_.push_back(parameter_value(robot.chain, k).value_or(1));
  set_terms(bind_loads(effect, robot));
}

// The torques of gravity that the effect needs. Returns the number of values of one.
int BoundEffect::bind_loads(const Effect& effect, const Robot& robot) {
  const auto fail = [&](const std::string& why) {
    throw std::invalid_argument("effect '" + effect.name + "': " + why);
  };
  for (const auto& [kind, joint] : {std::pair(std::optional(driver_.kind), driver_.joint),
                                    std::pair(driver_.factor, driver_.second_joint)}) {
    if (kind == DriverKind::gravity_torque)
      loads_.emplace_back(robot, zero_offset(robot.chain, joint));
    if (kind == DriverKind::tool_weight && is_of_positioner(robot, zero_offset(robot.chain, joint)))
      fail("joint " + joint_names(robot.chain)[joint].words +
           " belongs to the positioner, which does not " + "carry the tool");
    if (kind == DriverKind::tool_weight)
      loads_.emplace_back(with_unit_weight(robot), zero_offset(robot.chain, joint));
  }
  if (driver_.kind == DriverKind::moment)
    for (int parameter : parameters_) loads_.emplace_back(robot, parameter);

  // Without masses a load is a basis of several values, which only a linear law can use.
  int load_values = 1;
  for (const GravityLoad& load : loads_) load_values = std::max(load_values, load.value_count());
  if (load_values > 1 && shape_.kind != ShapeKind::linear)
    fail("the shape '" + to_string(shape_) + "' of a torque needs the robot's masses");
  if (load_values > 1 && driver_.factor == DriverKind::gravity_torque)
    fail("a torque of gravity as a factor needs the robot's masses");

  if (driver_.kind == DriverKind::gravity_direction) load_values = 3;
  needs_frames_ = !loads_.empty() || driver_.kind == DriverKind::gravity_direction ||
                  driver_.kind == DriverKind::range ||
                  driver_.kind == DriverKind::azimuth || driver_.kind == DriverKind::elevation ||
                  driver_.kind == DriverKind::incidence || driver_.kind == DriverKind::place;
  return load_values;
}

void BoundEffect::set_terms(int load_values) {
  const int members = static_cast<int>(parameters_.size());
  const bool is_vector = driver_.kind == DriverKind::moment && members > 1;
  const bool has_common = is_vector || !factors_.empty();
  own_values_ = has_common || needs_jacobian_;
  const int values = std::max(load_values, armtrue::value_count(shape_, driver_.is_pair()));
  const std::vector<std::string> names = value_names(shape_, values);
  value_count_ = own_values_ ? members * values : values;
  coefficient_count_ = has_common ? values : members * values;
  for (int i = 0; i < members; ++i)
    for (int k = 0; k < values; ++k)
      terms_.push_back(
          {parameters_[i], has_common ? k : i * values + k, own_values_ ? i * values + k : k});
  if (has_common || members == 1)
    coefficient_names_ = names;
  else
    for (int i = 0; i < members; ++i)
      for (const std::string& name : names)
        coefficient_names_.push_back(values == 1 ? kTwistNames[i] : kTwistNames[i] + (" " + name));
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
      coefficient_names_.push_back(to_string(member.parameter) + " " + name);
    coefficient_count_ += bound.coefficient_count_;
    value_count_ += bound.value_count_;
    needs_frames_ |= bound.needs_frames_;
    needs_jacobian_ |= bound.needs_jacobian_;
  }
}

double BoundEffect::driver_value(DriverKind kind, int joint, size_t member, const Context& context,
                                 const ArmFrames* frames, const PoseJacobian* jacobian) const {
  const auto as_measured = [&](double value) {
    return measured_ ? std::clamp(value, (*measured_)[0], (*measured_)[1]) : value;
  };
  switch (kind) {
    case DriverKind::joint_angle:
      return as_measured(context.q[joint]);
    case DriverKind::motor_torque:
      return context.motor_torque_nm[joint];
    case DriverKind::arrival:
      return context.arrival[joint];
    case DriverKind::stroke:
      return context.stroke[joint];
    case DriverKind::time:
      return as_measured(context.time_s);
    case DriverKind::session: {
      const std::vector<std::string>& known = driver_.sessions;
      const auto found = std::ranges::find(known, context.session);
      return static_cast<double>(std::min(found - known.begin(), std::ssize(known) - 1));
    }
    case DriverKind::temperature:
      return as_measured(context.temperature_c[temperature_]);
    case DriverKind::payload:
      return context.payload_kg;
    case DriverKind::force:
      return jacobian->col(parameters_[member]).head<3>().dot(context.force_n);
    case DriverKind::constant:
      return 1.0;
    case DriverKind::range:
    case DriverKind::azimuth:
    case DriverKind::elevation:
    case DriverKind::incidence:
      return sight_value(kind, base_ * frames->back() * tool_);
    case DriverKind::tool_weight: {
      Context unloaded = context;
      unloaded.payload_kg = 0;
      double torque = 0;
      loads_.front().values(unloaded, *frames, &torque);
      return torque;
    }
    case DriverKind::gravity_torque:
    case DriverKind::gravity_direction:
    case DriverKind::moment:
    case DriverKind::place:
      break;
  }
  double load = 0;
  load_on(member).values(context, *frames, &load);
  return load;
}

double BoundEffect::factor_value(size_t member, const Context& context, const ArmFrames* frames,
                                 const PoseJacobian* jacobian) const {
  const double value =
      driver_value(*driver_.factor, driver_.second_joint, member, context, frames, jacobian);
  return driver_.factor == DriverKind::temperature ? value - kReferenceTemperature : value;
}

double BoundEffect::sight_value(DriverKind kind, const Pose& measured) const {
  const LineOfSight sight(instrument_, up_, measured.translation);
  if (kind == DriverKind::range) return sight.range();
  if (kind == DriverKind::azimuth) return sight.azimuth();
  if (kind == DriverKind::elevation) return sight.elevation();
  return sight.incidence(measured.rotation.col(2));
}

void BoundEffect::shape_values(size_t member, const Context& context, const ArmFrames* frames,
                               const PoseJacobian* jacobian, double* out) const {
  if (driver_.is_pair())
    return evaluate_product(shape_, context.q[driver_.joint], context.q[driver_.second_joint], out);
  if (driver_.kind == DriverKind::place)
    return evaluate_polynomial(shape_, frames->back() * tool_.translation, out);
  if (driver_.kind == DriverKind::gravity_direction) {
    const Eigen::Vector3d down =
        ground_ < 0 ? gravity_ : Vector3d((*frames)[ground_].rotation * gravity_);
    const Eigen::Vector3d direction = frames->back().rotation.transpose() * down;
    for (int axis = 0; axis < 3; ++axis) evaluate(shape_, direction[axis], out + axis);
    return;
  }
  const bool linear_load =
      (driver_.kind == DriverKind::gravity_torque || driver_.kind == DriverKind::moment) &&
      shape_.kind == ShapeKind::linear;
  if (!linear_load) {
    double x = driver_value(driver_.kind, driver_.joint, member, context, frames, jacobian);
    // What warms up has not begun to before its time.
    if (driver_.kind == DriverKind::time && shape_.kind == ShapeKind::exponential)
      x = std::max(x, shape_.at);
    return evaluate(shape_, x, out);
  }
  // Without masses, all values of the basis; none if gravity does no work on this parameter.
  if (load_on(member).value_count() > 0) load_on(member).values(context, *frames, out);
}

void BoundEffect::values(const Context& context, const ArmFrames* frames,
                         const PoseJacobian* jacobian, double* out) const {
  std::fill(out, out + value_count_, 0.0);
  for (const BoundEffect& member : members_) {
    member.values(context, frames, jacobian, out);
    out += member.value_count_;
  }
  if (!members_.empty()) return;
  const int members = own_values_ ? static_cast<int>(parameters_.size()) : 1;
  const int values = value_count_ / members;
  for (int i = 0; i < members; ++i) {
    double* const own = out + i * values;
    shape_values(i, context, frames, jacobian, own);
    if (!driver_.factor && factors_.empty()) continue;
    double factor = factors_.empty() ? 1 : factors_[i];
    if (driver_.factor) factor *= factor_value(i, context, frames, jacobian);
    for (int k = 0; k < values; ++k) own[k] *= factor;
  }
}

RobotModel::RobotModel(const Robot& robot, const std::vector<std::string>& temperature_names)
    : chain_(robot.chain),
      targets_(robot.chain.targets),
      anchors_(robot.chain.anchors),
      instrument_(instrument_place(robot)),
      up_(upwards(robot)),
      layout_(layout_of(robot.chain)),
      parameters_(parameter_count(robot.chain)) {
  for (const Effect& effect : robot.effects) {
    if (effect.driver.kind == DriverKind::motor_torque)
      throw std::invalid_argument("effect '" + effect.name +
                                  "' follows a measured motor torque, which is not known at a pose "
                                  "that was not measured; let it follow gravity-torque");
    effects_.emplace_back(effect, robot, temperature_names);
    if (effects_.back().coefficient_count() != std::ssize(effect.coefficients))
      throw std::invalid_argument("effect '" + effect.name + "' has " +
                                  std::to_string(effect.coefficients.size()) +
                                  " coefficients; its parameter, driver and shape need " +
                                  std::to_string(effects_.back().coefficient_count()));
    auto& values = coefficients_.emplace_back();
    for (const Coefficient& c : effect.coefficients) values.push_back(c.value);
  }
}

Eigen::VectorXd RobotModel::offsets(const Context& context) const {
  Eigen::VectorXd offsets = Eigen::VectorXd::Zero(parameters_);
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

Vector3d RobotModel::read(const Vector3d& point, const Eigen::VectorXd& offsets) const {
  const Vector3d errors = offsets.segment<3>(layout_.instrument_range);
  const LineOfSight sight(instrument_, up_, point);
  return (1.0 + offsets[layout_.instrument_scale]) * point + sight.derivatives() * errors;
}

Pose RobotModel::pose(const Context& context) const {
  if (effects_.empty()) return chain_.pose(context.q);
  const Eigen::VectorXd all = offsets(context);
  Pose pose = chain_.pose(context.q, all.head(layout_.geometric));
  pose.translation = read(pose.translation, all);
  return pose;
}

// Position of the target; `offsets` is empty without effects.
Vector3d RobotModel::place(const Context& context, int target,
                           const Eigen::VectorXd& offsets) const {
  const Vector3d position = target < 0 ? Vector3d::Zero() : targets_[target].position;
  if (offsets.size() == 0) return chain_.pose(context.q) * position;
  const Vector3d moved =
      target < 0 ? position : position + offsets.segment<3>(layout_.targets + 3 * target);
  return chain_.pose(context.q, offsets.head(layout_.geometric)) * moved;
}

Vector3d RobotModel::point(const Context& context, int target) const {
  if (effects_.empty()) return place(context, target, {});
  const Eigen::VectorXd all = offsets(context);
  return read(place(context, target, all), all);
}

double RobotModel::distance(const Context& context, int target, int anchor) const {
  const Anchor& from = anchors_[anchor];
  if (effects_.empty()) return (place(context, target, {}) - from.position).norm() + from.zero;
  const Eigen::VectorXd all = offsets(context);
  const Eigen::Vector4d moved = all.segment<4>(layout_.targets + 3 * targets_.size() + 4 * anchor);
  return (1.0 + all[layout_.instrument_scale]) *
             (place(context, target, all) - from.position - moved.head<3>()).norm() +
         from.zero + moved[3];
}

}  // namespace armtrue
