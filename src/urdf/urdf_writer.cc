#include <fmt/format.h>
#include <tinyxml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "armtrue/urdf/urdf_io.h"
#include "urdf/link_frames.h"
#include "urdf/urdf_chain.h"

namespace armtrue {
namespace {

using Eigen::Vector3d;

// Escapes a text for an attribute. One character at a time, because tinyxml takes "&#x" for the
// beginning of a reference and leaves it as it is.
std::string attribute(const std::string& text) {
  std::string result;
  for (const char c : text) TiXmlBase::EncodeString(std::string(1, c), &result);
  return result;
}

std::string origin_xml(const Pose& pose) {
  const Vector3d rpy = roll_pitch_yaw(pose.rotation);
  const Vector3d& t = pose.translation;
  return fmt::format("<origin xyz=\"{} {} {}\" rpy=\"{} {} {}\"/>", number_text(t.x()),
                     number_text(t.y()), number_text(t.z()), number_text(rpy[0]),
                     number_text(rpy[1]), number_text(rpy[2]));
}

std::string link_xml(const std::string& name, const std::string& content = "") {
  if (content.empty()) return fmt::format("  <link name=\"{}\"/>\n", attribute(name));
  return fmt::format("  <link name=\"{}\">\n{}  </link>\n", attribute(name), content);
}

// Merges the bodies of a link into one, without moment of inertia: statics needs none.
std::string inertial_xml(const Robot& robot, int link) {
  double mass = 0;
  Pose centre;
  for (const Body& body : robot.bodies)
    if (body.link == link) {
      mass += body.mass_kg;
      // Running mean: a single body keeps its centre to the last digit.
      centre.translation += (body.mass_kg / mass) * (body.centre - centre.translation);
    }
  if (mass == 0) return "";
  return fmt::format(
      "    <inertial>{}<mass value=\"{}\"/><inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" "
      "iyz=\"0\" izz=\"0\"/></inertial>\n",
      origin_xml(centre), number_text(mass));
}

// The numbers of the robot file, exact, as attributes that other readers ignore.
std::string link_attributes(const Link& link, const std::string& others = "") {
  return fmt::format(
      "    <armtrue alpha_deg=\"{}\" d_mm=\"{}\" theta_deg=\"{}\" r_mm=\"{}\" "
      "beta_deg=\"{}\"{}/>\n",
      number_text(link.alpha, kDegree), number_text(link.d, kMillimetre),
      number_text(link.theta, kDegree), number_text(link.r, kMillimetre),
      number_text(link.beta, kDegree), others);
}

std::string fixed_joint_xml(const std::string& name, const std::string& parent,
                            const std::string& child, const Pose& pose,
                            const std::string& attributes = "") {
  return fmt::format(
      "  <joint name=\"{}\" type=\"fixed\">\n    <parent link=\"{}\"/>\n    <child link=\"{}\"/>\n"
      "    {}\n{}  </joint>\n",
      attribute(name), attribute(parent), attribute(child), origin_xml(pose), attributes);
}

std::string moving_joint_xml(const Link& link, const std::string& parent,
                             const std::string& others = "", const std::string& mimic = "") {
  const bool limited = std::isfinite(link.min) && std::isfinite(link.max);
  return fmt::format(
      "  <joint name=\"joint_{}\" type=\"{}\">\n    <parent link=\"{}\"/>\n    <child "
      "link=\"{}\"/>\n"
      "    {}\n    <axis xyz=\"0 0 {}\"/>\n{}{}{}  </joint>\n",
      attribute(link.name),
      is_prismatic(link) ? "prismatic"
      : limited          ? "revolute"
                         : "continuous",
      attribute(parent), attribute(link.name), origin_xml(link_transform(link)),
      link.sign > 0 ? "1" : "-1",
      limited ? fmt::format("    <limit lower=\"{}\" upper=\"{}\" effort=\"0\" velocity=\"0\"/>\n",
                            number_text(link.min), number_text(link.max))
              : "",
      mimic, link_attributes(link, others));
}

std::vector<const Coupling*> couplings_of(const KinematicChain& chain, int link) {
  std::vector<const Coupling*> own;
  for (const Coupling& coupling : chain.couplings)
    if (coupling.follower == link) own.push_back(&coupling);
  return own;
}

// Whether a link becomes more than one joint in a URDF.
bool is_several_joints(const KinematicChain& chain, int link) {
  return written_mimics(chain, link).size() + (chain.links[link].has_encoder ? 1 : 0) > 1;
}

}  // namespace

// A link becomes a joint for each link that it follows, and one for its own encoder. A mimic joint
// copies the position of one joint, but a followed link that is several joints has the sum of
// theirs: what that link follows is added to the copies of the same joints. Those that the link
// does not follow itself stand behind its couplings.
std::vector<WrittenMimic> written_mimics(const KinematicChain& chain, int link) {
  const std::vector<const Coupling*> couplings = couplings_of(chain, link);
  std::vector<WrittenMimic> mimics;
  for (const Coupling* coupling : couplings) mimics.push_back({coupling->followed});
  const auto copy_of = [&](int followed) -> WrittenMimic& {
    const auto copy = std::ranges::find(mimics, followed, &WrittenMimic::followed);
    return copy != mimics.end() ? *copy : mimics.emplace_back(WrittenMimic{followed});
  };
  const auto add = [&](const auto& self, const Coupling& coupling, double factor,
                       size_t of) -> void {
    const Link& followed = chain.links[coupling.followed];
    factor *= coupling.coefficient;
    mimics[of].offset += factor * followed.sign * (zero_of(followed) - coupling.from);
    const bool is_sum = is_several_joints(chain, coupling.followed);
    if (followed.has_encoder || !is_sum) copy_of(coupling.followed).multiplier += factor;
    if (is_sum)
      for (const Coupling* beneath : couplings_of(chain, coupling.followed))
        self(self, *beneath, factor, of);
  };
  for (size_t k = 0; k < couplings.size(); ++k) add(add, *couplings[k], 1, k);
  return mimics;
}

namespace {

// The part of a sum of joints that copies `followed`. The sum has the travel, the part has none;
// but a URDF demands limits of a prismatic joint: those within which the copy stays.
void set_travel_of_copy(const Link& followed, const WrittenMimic& mimic, Link& part) {
  constexpr double kUnlimited = std::numeric_limits<double>::infinity();
  constexpr double kNoRail = 1e6;  // m; readers take it for no limit
  part.min = -kUnlimited;
  part.max = kUnlimited;
  if (!is_prismatic(part)) return;
  const auto [low, high] = std::minmax({mimic.multiplier * followed.min + mimic.offset,
                                        mimic.multiplier * followed.max + mimic.offset});
  const bool is_known = std::isfinite(low) && std::isfinite(high) && low < high;
  part.min = is_known ? low : -kNoRail;
  part.max = is_known ? high : kNoRail;
}

// What a mimic does not say of a coupling.
std::string coupling_attributes(const Link& followed, const Coupling& coupling,
                                const WrittenMimic& mimic) {
  std::string text;
  if (zero_of(followed) != coupling.from)
    text = fmt::format(" {}=\"{}\"", is_prismatic(followed) ? "from_mm" : "from_deg",
                       number_text(coupling.from, is_prismatic(followed) ? kMillimetre : kDegree));
  if (mimic.multiplier != coupling.coefficient)
    text += fmt::format(" coefficient=\"{}\"", number_text(coupling.coefficient));
  return text;
}

// Adds the joints of a link that follows others, one behind the other on its axis.
void add_following_joints(const KinematicChain& chain, int index, std::string parent,
                          std::string& links, std::string& joints) {
  const Link& own = chain.links[index];
  const std::vector<const Coupling*> couplings = couplings_of(chain, index);
  const std::vector<WrittenMimic> mimics = written_mimics(chain, index);
  Link part = own;
  std::string others;
  const auto goes_on = [&](const std::string& name) {
    parent = name;
    part.alpha = part.d = part.theta = part.r = part.beta = 0;
    others = " same_axis=\"1\"";
  };
  for (size_t k = 0; k < mimics.size(); ++k) {
    const WrittenMimic& mimic = mimics[k];
    const Link& followed = chain.links[mimic.followed];
    const bool is_last = k + 1 == mimics.size() && !own.has_encoder;
    part.name = is_last ? own.name : own.name + "_follows_" + followed.name;
    if (is_several_joints(chain, index)) set_travel_of_copy(followed, mimic, part);
    joints += moving_joint_xml(
        part, parent,
        others + (k < couplings.size() ? coupling_attributes(followed, *couplings[k], mimic)
                                       : " of_followed=\"1\""),
        fmt::format("    <mimic joint=\"joint_{}\" multiplier=\"{}\" offset=\"{}\"/>\n",
                    attribute(followed.name), number_text(mimic.multiplier),
                    number_text(mimic.offset)));
    if (!is_last) links += link_xml(part.name);
    goes_on(part.name);
  }
  if (!own.has_encoder) return;
  part.name = own.name;
  part.min = own.min;
  part.max = own.max;
  joints += moving_joint_xml(part, parent, others);
}

}  // namespace

std::string write_urdf(const Robot& robot) {
  std::string xml = "<?xml version=\"1.0\"?>\n<robot name=\"" + attribute(robot.name) + "\">\n";
  xml += link_xml("world") + link_xml("base_link");
  for (int j = 0; j < link_count(robot.chain); ++j)
    xml += link_xml(robot.chain.links[j].name, inertial_xml(robot, j));
  xml += link_xml("tool");
  xml += fixed_joint_xml("base", "world", "base_link", robot.chain.base);
  std::string parent = "base_link", links, joints;
  for (int j = 0; j < link_count(robot.chain); ++j) {
    const Link& link = robot.chain.links[j];
    if (!couplings_of(robot.chain, j).empty())
      add_following_joints(robot.chain, j, parent, links, joints);
    else
      joints += link.joint != JointKind::fixed
                    ? moving_joint_xml(link, parent)
                    : fixed_joint_xml("joint_" + link.name, parent, link.name, link_transform(link),
                                      link_attributes(link));
    parent = link.name;
  }
  xml += links + joints;
  xml += fixed_joint_xml("tool_mount", parent, "tool", robot.chain.tool);
  return xml + "</robot>\n";
}

std::vector<std::string> lost_in_urdf(const Robot& robot) {
  std::vector<std::string> lost;
  if (!robot.sessions.empty()) lost.emplace_back("sessions");
  if (!robot.chain.targets.empty()) lost.emplace_back("targets");
  if (!robot.chain.anchors.empty()) lost.emplace_back("anchors");
  std::set<std::string> kinds;
  for (const Contact& contact : robot.chain.contacts)
    kinds.insert(contact.kind == ContactKind::camera  ? "cameras"
                 : contact.kind == ContactKind::board ? "boards"
                 : contact.kind == ContactKind::beam  ? "beams"
                                                      : "contacts");
  lost.insert(lost.end(), kinds.begin(), kinds.end());
  if (robot.gravity != Vector3d(0, 0, -9.81)) lost.emplace_back("gravity_m_s2");
  if (robot.floor != 0) lost.emplace_back("floor_mm");
  if (robot.identify != std::vector<std::string>{"auto"}) lost.emplace_back("identify");
  if (!robot.identify_per_session.empty()) lost.emplace_back("identify_per_session");
  if (robot.noise.position > 0 || robot.noise.orientation > 0 || robot.noise.pixel > 0)
    lost.emplace_back("noise");
  if (!robot.priors.empty()) lost.emplace_back("priors");
  if (!robot.std.empty()) lost.emplace_back("std");
  if (!robot.effects.empty()) lost.emplace_back("effects");
  if (robot.instrument) lost.emplace_back("instrument_mm");
  if (robot.uncertainty) lost.emplace_back("uncertainty");
  for (int j = 0; j < link_count(robot.chain); ++j) {
    const Link& link = robot.chain.links[j];
    if (!link.has_encoder && is_several_joints(robot.chain, j) && std::isfinite(link.max))
      lost.push_back("travel of " + link.name);
  }
  // A revolute joint of a URDF has both limits, a continuous one has none.
  for (const Link& link : robot.chain.links)
    if (std::isfinite(link.min) != std::isfinite(link.max))
      lost.emplace_back((std::isfinite(link.min) ? "min_deg of " : "max_deg of ") + link.name);
  return lost;
}

}  // namespace armtrue
