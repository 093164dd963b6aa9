#include "armtrue/effects/driver.h"

#include <charconv>

namespace armtrue {
namespace {

struct Word {
  DriverKind kind;
  std::string_view text;
  std::string_view unit;
  bool has_joint;
};

constexpr Word kWords[] = {
    {DriverKind::joint_angle, "joint-angle", "rad", true},
    {DriverKind::gravity_torque, "gravity-torque", "N m", true},
    {DriverKind::motor_torque, "motor-torque", "N m", true},
    {DriverKind::arrival, "arrival", "", true},
    {DriverKind::stroke, "stroke", "rad", true},
    {DriverKind::time, "time", "s", false},
    {DriverKind::temperature, "temperature", "K", false},
    {DriverKind::payload, "payload", "kg", false},
    {DriverKind::force, "force", "N m", false},
    {DriverKind::moment, "moment", "N m", false},
    {DriverKind::constant, "position", "", false},
    {DriverKind::tool_weight, "tool-weight", "N m", true},
    {DriverKind::range, "range", "m", false},
    {DriverKind::azimuth, "azimuth", "rad", false},
    {DriverKind::elevation, "elevation", "rad", false},
    {DriverKind::incidence, "incidence", "rad", false},
    {DriverKind::place, "place", "m", false},
    {DriverKind::gravity_direction, "gravity-direction", "", false},
    {DriverKind::session, "session", "", false},
};

const Word& word(DriverKind kind) {
  for (const Word& candidate : kWords)
    if (candidate.kind == kind) return candidate;
  return kWords[0];
}

// "3" -> 2; -1 if it is no joint.
int parse_joint(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = error == std::errc{} && end == text.data() + text.size();
  return whole && number >= 1 && number <= kMaxJoints ? number - 1 : -1;
}

constexpr std::string_view kTimes = " * ";

// "joint-angle 3" times "arrival 3".
std::optional<Driver> product(std::optional<Driver> first, const std::optional<Driver>& second) {
  if (!first || !second || first->second_joint >= 0 || second->factor ||
      first->kind == second->kind)
    return std::nullopt;
  switch (second->kind) {
    case DriverKind::arrival:
    case DriverKind::time:
    case DriverKind::temperature:
    case DriverKind::payload:
    case DriverKind::force:
      break;
    case DriverKind::gravity_torque:
    case DriverKind::tool_weight:
      if (!first->follows_course()) return std::nullopt;
      break;
    default:
      return std::nullopt;
  }
  first->factor = second->kind;
  first->second_joint = second->joint;
  if (second->kind == DriverKind::temperature) first->where = second->where;
  return first;
}

}  // namespace

bool is_angle_or_travel(DriverKind kind) {
  return kind == DriverKind::joint_angle || kind == DriverKind::stroke ||
         kind == DriverKind::azimuth || kind == DriverKind::elevation ||
         kind == DriverKind::incidence;
}

std::string to_string(const Driver& driver) {
  if (driver.factor) {
    Driver first = driver;
    first.factor.reset();
    first.second_joint = -1;
    return to_string(first) + std::string(kTimes) +
           to_string(Driver{*driver.factor, driver.second_joint, -1, driver.where});
  }
  std::string text(word(driver.kind).text);
  if (driver.kind == DriverKind::temperature) return text + " " + driver.where;
  if (driver.joint >= 0) text += " " + std::to_string(driver.joint + 1);
  if (driver.second_joint >= 0) text += "," + std::to_string(driver.second_joint + 1);
  return text;
}

std::optional<Driver> parse_driver(std::string_view text) {
  if (const size_t times = text.find(kTimes); times != std::string_view::npos)
    return product(parse_driver(text.substr(0, times)),
                   parse_driver(text.substr(times + kTimes.size())));
  const size_t space = text.find(' ');
  const std::string_view name = text.substr(0, space);
  const std::string_view rest =
      space == std::string_view::npos ? std::string_view{} : text.substr(space + 1);
  for (const Word& candidate : kWords) {
    if (candidate.text != name) continue;
    Driver driver;
    driver.kind = candidate.kind;
    if (candidate.kind == DriverKind::temperature) {
      if (rest.empty()) return std::nullopt;
      driver.where = rest;
      return driver;
    }
    if (!candidate.has_joint) return rest.empty() ? std::optional(driver) : std::nullopt;
    const size_t comma = rest.find(',');
    driver.joint = parse_joint(rest.substr(0, comma));
    if (driver.joint < 0) return std::nullopt;
    if (comma != std::string_view::npos) {
      driver.second_joint = parse_joint(rest.substr(comma + 1));
      if (driver.second_joint < 0 || candidate.kind != DriverKind::joint_angle) return std::nullopt;
    }
    return driver;
  }
  return std::nullopt;
}

bool is_travel(const Driver& driver, const KinematicChain& chain) {
  return (driver.kind == DriverKind::joint_angle || driver.kind == DriverKind::stroke) &&
         joint_unit(chain, driver.joint) == ParameterUnit::metre;
}

bool is_length(const Driver& driver, const KinematicChain& chain) {
  return driver.kind == DriverKind::range || is_travel(driver, chain);
}

std::string unit_of(const KinematicChain& chain, DriverKind kind, int joint,
                    ParameterUnit parameter) {
  if (joint >= 0 && joint_unit(chain, joint) == ParameterUnit::metre) {
    const std::string_view unit = word(kind).unit;
    if (unit == "rad") return "m";
    if (unit == "N m") return "N";
  }
  // Work per unit of the parameter.
  const bool is_generalised_force = kind == DriverKind::force || kind == DriverKind::moment;
  if (is_generalised_force && parameter == ParameterUnit::metre) return "N";
  return std::string(word(kind).unit);
}

}  // namespace armtrue
