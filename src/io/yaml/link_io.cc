#include "io/yaml/link_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "armtrue/kinematics/names.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
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

// The travel of a joint. One that slides by itself has both ends: nothing else says how far it
// goes.
void read_travel(YamlMap& map, Link& link) {
  const bool slides = is_prismatic(link);
  const std::string unit = slides ? "_mm" : "_deg";
  const double si = slides ? kMillimetre : kDegree;
  const bool needs_both = slides && link.has_encoder;
  if (needs_both || map.has("min" + unit)) link.min = map.number("min" + unit) * si;
  if (needs_both || map.has("max" + unit)) link.max = map.number("max" + unit) * si;
  if (link.min >= link.max) map.fail("max" + unit, "must be above min" + unit);
}

}  // namespace

// Braces fix the order of evaluation, so that a message names the first wrong number.
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
    texts[k] = number_text(*read_number(fmt::format("{:.12f}", abc[k])) + 0.0);
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

Link read_link(YamlMap& map) {
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
  link.has_encoder = !map.has("follows");
  for (const char* key : {"follows", "coupled"})
    if (map.has(key) && link.joint == JointKind::fixed)
      map.fail(key,
               "is of a joint that moves, and this one is fixed: make it revolute or prismatic");
  if (!link.has_encoder && map.has("coupled"))
    map.fail("coupled",
             "stands beside 'follows'; 'follows' is of a joint without an encoder of its "
             "own, 'coupled' of one with it: keep one");
  read_travel(map, link);
  return link;
}

namespace {

// Keys of a link that follows: with an encoder or without, and where values of others are zero.
const char* key_of_couplings(const Link& link) { return link.has_encoder ? "coupled" : "follows"; }
const char* key_of_zeros(const Link& followed) {
  return is_prismatic(followed) ? "from_mm" : "from_deg";
}

int followed_link(const YamlMap& map, const std::string& name, int own,
                  const KinematicChain& chain) {
  const auto link = find_name(chain.links, name);
  if (!link) map.fail(name, "the robot has no link '" + name + "'");
  if (chain.links[*link].joint == JointKind::fixed)
    map.fail(name, "the link '" + name + "' is fixed: nothing follows it");
  if (*link == own) map.fail(name, "the joint of this link follows itself");
  return *link;
}

}  // namespace

void read_couplings(YamlMap& map, int link, KinematicChain& chain) {
  const Link& own = chain.links[link];
  const char* const key = key_of_couplings(own);
  if (!map.has(key)) return;
  YamlMap entries = map.map(key);
  const size_t first = chain.couplings.size();
  for (const std::string& name : entries.keys()) {
    Coupling coupling{link, followed_link(entries, name, link, chain)};
    coupling.coefficient = entries.number(name) * coefficient_unit(chain, coupling);
    coupling.from = zero_of(chain.links[coupling.followed]);
    chain.couplings.push_back(coupling);
  }
  if (chain.couplings.size() == first)
    map.fail(key, "is empty; it names the links that this one follows, such as {J2: -1}");
  if (chain.couplings.size() > kMaxCouplings)
    map.fail(key, fmt::format("the joints of the robot follow others {} times; at most {} are "
                              "possible",
                              chain.couplings.size(), kMaxCouplings));
  for (const char* zeros : {"from_deg", "from_mm"}) {
    if (!map.has(zeros)) continue;
    YamlMap from = map.map(zeros);
    for (const std::string& name : from.keys()) {
      const int followed = followed_link(from, name, link, chain);
      const auto found =
          std::find_if(chain.couplings.begin() + first, chain.couplings.end(),
                       [&](const Coupling& coupling) { return coupling.followed == followed; });
      if (found == chain.couplings.end())
        from.fail(name, std::string("is not among the links of '") + key + "'");
      const Link& of = chain.links[followed];
      if (zeros != std::string(key_of_zeros(of)))
        from.fail(name, std::string("belongs to '") + key_of_zeros(of) + "'");
      found->from = from.number(name) * (is_prismatic(of) ? kMillimetre : kDegree);
    }
  }
}

namespace {

void add_couplings(const KinematicChain& chain, int link, std::vector<FlowEntry>& entries) {
  std::vector<FlowEntry> coefficients, angles, lengths;
  for (const Coupling& coupling : chain.couplings) {
    if (coupling.follower != link) continue;
    const Link& followed = chain.links[coupling.followed];
    const bool slides = is_prismatic(followed);
    coefficients.emplace_back(followed.name,
                              number_text(coupling.coefficient, coefficient_unit(chain, coupling)));
    if (coupling.from != zero_of(followed))
      (slides ? lengths : angles)
          .emplace_back(followed.name, number_text(coupling.from, slides ? kMillimetre : kDegree));
  }
  if (coefficients.empty()) return;
  entries.emplace_back(key_of_couplings(chain.links[link]), flow_map(coefficients));
  if (!angles.empty()) entries.emplace_back("from_deg", flow_map(angles));
  if (!lengths.empty()) entries.emplace_back("from_mm", flow_map(lengths));
}

}  // namespace

YAML::Node link_node(const KinematicChain& chain, int index) {
  const Link& link = chain.links[index];
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
  add_couplings(chain, index, entries);
  return flow_map(entries);
}

}  // namespace armtrue
