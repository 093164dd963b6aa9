#include "io/yaml/link_io.h"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

const char* joint_word(JointKind kind) {
  switch (kind) {
    case JointKind::revolute:
      return "revolute";
    case JointKind::prismatic:
      return "prismatic";
    case JointKind::fixed:
      break;
  }
  return "fixed";
}

JointKind read_joint_kind(YamlMap& map) {
  const std::string joint = map.text("joint");
  for (JointKind kind : {JointKind::revolute, JointKind::prismatic, JointKind::fixed})
    if (joint == joint_word(kind)) return kind;
  map.fail("joint", "'" + joint + "' is none of revolute, prismatic and fixed");
}

// The travel of a joint. One that slides has both ends: nothing else says how far it goes.
void read_travel(YamlMap& map, Link& link) {
  const bool slides = is_prismatic(link);
  const std::string unit = slides ? "_mm" : "_deg";
  const double si = slides ? kMillimetre : kDegree;
  if (slides || map.has("min" + unit)) link.min = map.number("min" + unit) * si;
  if (slides || map.has("max" + unit)) link.max = map.number("max" + unit) * si;
  if (link.min >= link.max) map.fail("max" + unit, "must be above min" + unit);
}

}  // namespace

// In braces the numbers are read in their order, so that a message names the first that is wrong.
Eigen::Vector3d read_position(YamlMap& map) {
  return kMillimetre * Eigen::Vector3d{map.number("x_mm"), map.number("y_mm"), map.number("z_mm")};
}

Eigen::Matrix3d read_rotation(YamlMap& map) {
  const Eigen::Vector3d abc =
      kDegree * Eigen::Vector3d{map.number("a_deg"), map.number("b_deg"), map.number("c_deg")};
  return rotation_from_abc(abc[0], abc[1], abc[2]);
}

// A rotation holds its angles to 1e-15 rad; digits below 1e-12 deg are rounding errors.
std::array<NumberText, 3> rotation_texts(const Eigen::Matrix3d& rotation) {
  std::array<NumberText, 3> texts;
  const Eigen::Vector3d abc = abc_from_rotation(rotation) / kDegree;
  for (int k = 0; k < 3; ++k)
    texts[static_cast<size_t>(k)] = number_text(*read_number(fmt::format("{:.12f}", abc[k])) + 0.0);
  return texts;
}

Pose read_pose(YamlMap map) {
  Pose pose;
  pose.translation = read_position(map);
  pose.rotation = read_rotation(map);
  map.finish();
  return pose;
}

YAML::Node pose_node(const Pose& pose) {
  const auto [a, b, c] = rotation_texts(pose.rotation);
  return flow_map({{"x_mm", number_text(pose.translation.x(), kMillimetre)},
                   {"y_mm", number_text(pose.translation.y(), kMillimetre)},
                   {"z_mm", number_text(pose.translation.z(), kMillimetre)},
                   {"a_deg", a},
                   {"b_deg", b},
                   {"c_deg", c}});
}

Link read_link(YamlMap map) {
  Link link;
  link.name = map.name("name");
  if (link.name.empty()) map.fail("name", "is empty; parameters are named after links");
  link.joint = read_joint_kind(map);
  link.alpha = map.number("alpha_deg") * kDegree;
  link.d = map.number("d_mm") * kMillimetre;
  link.theta = map.number("theta_deg") * kDegree;
  link.r = map.number("r_mm") * kMillimetre;
  link.beta = map.number("beta_deg", 0) * kDegree;
  link.sign = map.number("sign", 1);
  if (link.sign != 1 && link.sign != -1) map.fail("sign", "must be 1 or -1");
  read_travel(map, link);
  map.finish();
  return link;
}

YAML::Node link_node(const Link& link) {
  std::vector<FlowEntry> entries{
      {"name", link.name},
      {"joint", joint_word(link.joint)},
      {"alpha_deg", number_text(link.alpha, kDegree)},
      {"d_mm", number_text(link.d, kMillimetre)},
      {"theta_deg", number_text(link.theta, kDegree)},
      {"r_mm", number_text(link.r, kMillimetre)},
      {"beta_deg", number_text(link.beta, kDegree)}};
  if (link.joint != JointKind::fixed) {
    const std::string unit = is_prismatic(link) ? "_mm" : "_deg";
    const double si = is_prismatic(link) ? kMillimetre : kDegree;
    entries.emplace_back("sign", number_text(link.sign));
    if (std::isfinite(link.min)) entries.emplace_back("min" + unit, number_text(link.min, si));
    if (std::isfinite(link.max)) entries.emplace_back("max" + unit, number_text(link.max, si));
  }
  return flow_map(entries);
}

}  // namespace armtrue
