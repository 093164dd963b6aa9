#include "armtrue/effects/driver.h"

#include <charconv>

#include "armtrue/kinematics/chain.h"

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
    {DriverKind::time, "time", "s", false},
    {DriverKind::temperature, "temperature", "K", false},
    {DriverKind::payload, "payload", "kg", false},
    {DriverKind::force, "force", "N m", false},
    {DriverKind::moment, "moment", "N m", false},
    {DriverKind::position, "position", "", false},
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
  return whole && number >= 1 && number <= kJoints ? number - 1 : -1;
}

}  // namespace

std::string to_string(const Driver& driver) {
  std::string text(word(driver.kind).text);
  if (driver.kind == DriverKind::temperature) return text + " " + driver.where;
  if (driver.joint >= 0) text += " " + std::to_string(driver.joint + 1);
  if (driver.second_joint >= 0) text += "," + std::to_string(driver.second_joint + 1);
  return text;
}

std::optional<Driver> parse_driver(std::string_view text) {
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

std::string unit_of(const Driver& driver) { return std::string(word(driver.kind).unit); }

}  // namespace armtrue
