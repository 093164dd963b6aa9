#include "urdf/urdf_chain.h"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tinyxml.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <kdl/chain.hpp>
#include <kdl/tree.hpp>
#include <map>
#include <numbers>
#include <optional>

#include "armtrue/text/input_error.h"
#include "urdf/xml_bounds.h"
#include "urdf/xml_tags.h"

namespace armtrue {
namespace {

constexpr size_t kMostLinksNamed = 12;  // in a message
constexpr double kLargest = 1e6;        // of lengths, angles and parts of axes
// Limits of a revolute joint [rad]: further ones are deg, or stand for no limit.
constexpr double kMostTurned = 10 * 2 * std::numbers::pi, kNoLimit = 1000;
constexpr size_t kMaxJointsOfFile = 2000;  // a whole cell; the way through is searched recursively

// Collects the messages of urdfdom instead of printing them.
class Complaints : public console_bridge::OutputHandler {
 public:
  Complaints() { console_bridge::useOutputHandler(this); }
  ~Complaints() override { console_bridge::restorePreviousOutputHandler(); }
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;
  void log(const std::string& text, console_bridge::LogLevel level, const char* /*file*/,
           int /*line*/) override {
    if (level == console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first_.empty()) first_ = text;
  }
  const std::string& first() const { return first_; }

 private:
  std::string first_;
};

std::string link_attribute(const TiXmlElement& joint, const char* side) {
  const TiXmlElement* const end = joint.FirstChildElement(side);
  const char* const link = end ? end->Attribute("link") : nullptr;
  return link ? link : "";
}

// urdfdom lets a link have two parents, and leaves out links in a circle, which hold each other in
// its memory for ever. So this comes before it.
void require_tree(const TiXmlElement& robot, const std::string& file) {
  std::map<std::string, const TiXmlElement*> joint_before;  // of a link
  const auto name_of = [](const TiXmlElement& joint) {
    const char* const name = joint.Attribute("name");
    return std::string(name ? name : "");
  };
  for (const TiXmlElement* joint = robot.FirstChildElement("joint"); joint;
       joint = joint->NextSiblingElement("joint")) {
    const std::string child = link_attribute(*joint, "child");
    if (const auto [other, is_new] = joint_before.emplace(child, joint); !is_new && !child.empty())
      throw InputError(fmt::format(
          "{}:{}: the link '{}' is the child of '{}' and of '{}', but a URDF is a tree; of a "
          "closed chain leave out one of these joints",
          file, joint->Row(), child, name_of(*other->second), name_of(*joint)));
  }
  if (joint_before.size() > kMaxJointsOfFile)
    throw InputError(fmt::format("{}: has {} joints; at most {} are read", file,
                                 joint_before.size(), kMaxJointsOfFile));
  for (const auto& [link, joint] : joint_before) {
    auto before = joint_before.find(link_attribute(*joint, "parent"));
    for (size_t joints = 1; before != joint_before.end(); ++joints) {
      if (joints > joint_before.size())
        throw InputError(fmt::format(
            "{}:{}: the joints that lead to the link '{}' form a circle; correct their parents",
            file, joint->Row(), link));
      before = joint_before.find(link_attribute(*before->second, "parent"));
    }
  }
}

// The file and, if it is found, the line of the last element of the robot for which `is_it`.
template <typename IsIt>
std::string place_in(const TiXmlElement* robot, const std::string& file, const IsIt& is_it) {
  int line = 0;
  for (const TiXmlElement* one = robot ? robot->FirstChildElement() : nullptr; one;
       one = one->NextSiblingElement())
    if (const char* const name = one->Attribute("name"); name && is_it(*one, std::string(name)))
      line = one->Row();
  return line > 0 ? file + ":" + std::to_string(line) : file;
}

std::string place_of_joint(const TiXmlElement* robot, const std::string& file,
                           const std::string& joint) {
  return place_in(robot, file, [&](const TiXmlElement& one, const std::string& name) {
    return one.ValueStr() == "joint" && name == joint;
  });
}

// urdfdom skips elements that it cannot read. A skipped mass would change the predictions, so its
// messages become errors.
urdf::ModelInterfaceSharedPtr parse_strictly(const std::string& text, const TiXmlElement* robot,
                                             const std::string& file) {
  const Complaints complaints;
  urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(text);
  if (const std::string& first = complaints.first(); !first.empty())
    throw InputError(place_in(robot, file,
                              [&](const TiXmlElement&, const std::string& name) {
                                return first.find("[" + name + "]") != std::string::npos ||
                                       first.find("'" + name + "'") != std::string::npos;
                              }) +
                     ": is no valid URDF: " + first + "; correct it");
  if (!model || !model->getRoot())
    throw InputError(file + ": is no valid URDF: it has no root link; state one");
  return model;
}

// urdfdom accepts a negative mass, and does not name the link of a mass that is no number.
void check_masses(const TiXmlElement& robot, const std::string& file) {
  for (const TiXmlElement* link = robot.FirstChildElement("link"); link;
       link = link->NextSiblingElement("link")) {
    const TiXmlElement* const inertial = link->FirstChildElement("inertial");
    const TiXmlElement* const mass = inertial ? inertial->FirstChildElement("mass") : nullptr;
    const char* const value = mass ? mass->Attribute("value") : nullptr;
    if (!value) continue;
    char* end = nullptr;
    const double number = std::strtod(value, &end);
    if (end == value || *end != '\0' || !std::isfinite(number) || number < 0)
      throw InputError(fmt::format(
          "{}:{}: the mass '{}' of the link '{}' is no number from zero up; correct or remove it",
          file, mass->Row(), value, link->Attribute("name") ? link->Attribute("name") : ""));
  }
}

// What xacro expands stands in names of elements or in attributes. An expanded document keeps the
// comments of its source, whatever they hold.
void refuse_xacro(const std::string& text, const std::string& file) {
  for (size_t at = 0; const std::optional<XmlTag> tag = next_tag(text, at); at = tag->end) {
    const std::string_view own = std::string_view(text).substr(tag->begin, tag->end - tag->begin);
    const bool is_macro =
        tag->name.starts_with("xacro:") || own.find("${") != own.npos || own.find("$(") != own.npos;
    if (!is_macro) continue;
    throw InputError(fmt::format(
        "{0}:{1}: contains xacro macros that are not expanded; write 'xacro {0} > robot.urdf' and "
        "take robot.urdf",
        file, 1 + std::count(text.begin(), text.begin() + static_cast<long>(tag->begin), '\n')));
  }
}

bool is_fixed(const urdf::Joint& joint) { return joint.type == urdf::Joint::FIXED; }

// How many joints of the branch behind a joint move by themselves; those that follow another
// (mimic) do not.
int independent_joints(const urdf::Joint& joint, const urdf::ModelInterface& model) {
  int count = !is_fixed(joint) && !joint.mimic ? 1 : 0;
  for (const auto& next : model.getLink(joint.child_link_name)->child_joints)
    count += independent_joints(*next, model);
  return count;
}

bool moves(const urdf::Joint& joint, const urdf::ModelInterface& model);

// Whether a joint behind the link is not fixed.
bool carries_joints(const urdf::Link& link, const urdf::ModelInterface& model) {
  return std::ranges::any_of(link.child_joints,
                             [&](const auto& joint) { return moves(*joint, model); });
}

// Whether a link of the branch behind a joint moves against the link in front of it.
bool moves(const urdf::Joint& joint, const urdf::ModelInterface& model) {
  return !is_fixed(joint) || carries_joints(*model.getLink(joint.child_link_name), model);
}

// Links behind `link` that end a branch.
void find_ends(const urdf::Link& link, std::vector<std::string>& ends) {
  if (link.child_links.empty()) ends.push_back(link.name);
  for (const auto& child : link.child_links) find_ends(*child, ends);
}

std::string some_of(const std::vector<std::string>& names) {
  if (names.size() <= kMostLinksNamed) return fmt::format("{}", fmt::join(names, ", "));
  return fmt::format("{}, ... ({} in all)",
                     fmt::join(names.begin(), names.begin() + kMostLinksNamed, ", "), names.size());
}

// Where the arm goes on behind a link: along the only branch that moves, or else any. Beside two
// joints and more of an arm, branches whose joints follow others are its drives and springs.
std::vector<urdf::JointSharedPtr> ways_behind(const urdf::Link& link,
                                              const urdf::ModelInterface& model) {
  std::vector<urdf::JointSharedPtr> ways, own;
  std::ranges::copy_if(link.child_joints, std::back_inserter(ways),
                       [&](const auto& joint) { return moves(*joint, model); });
  std::ranges::copy_if(ways, std::back_inserter(own),
                       [&](const auto& joint) { return independent_joints(*joint, model) > 0; });
  if (own.size() == 1 && independent_joints(*own.front(), model) > 1) return own;
  return ways.empty() ? link.child_joints : ways;
}

// Descriptions after ROS-Industrial have a flange for grippers, whose x points out, and the flange
// as the controller shows it, tool0.
const std::string& likely_end(const std::vector<std::string>& ends) {
  const auto tool0 =
      std::ranges::find_if(ends, [](const std::string& name) { return name.ends_with("tool0"); });
  return tool0 != ends.end() ? *tool0 : ends.front();
}

// Fingers move and follow each other, and no arm goes on behind them.
bool is_gripper(const std::vector<urdf::JointSharedPtr>& ways, const urdf::ModelInterface& model) {
  return std::ranges::all_of(ways, [&](const auto& joint) {
    return moves(*joint, model) && independent_joints(*joint, model) <= 1;
  });
}

// The end of the arm where nobody names it: along the branch with driven joints, and on as long as
// one link follows the other.
std::string only_end(const urdf::ModelInterface& model, const std::string& base,
                     const std::string& file) {
  urdf::LinkConstSharedPtr link = model.getLink(base);
  // The frame of a controller often stands beside the arm: the way goes back first.
  while (link->parent_joint && is_fixed(*link->parent_joint) && !carries_joints(*link, model))
    link = model.getLink(link->parent_joint->parent_link_name);
  while (!link->child_joints.empty()) {
    const std::vector<urdf::JointSharedPtr> ways = ways_behind(*link, model);
    if (ways.size() > 1) {
      std::vector<std::string> ends;
      for (const auto& way : ways) find_ends(*model.getLink(way->child_link_name), ends);
      throw InputError(fmt::format(
          "{}: the link '{}' branches; name the link where the arm ends: --tip {} (ends are {})",
          file, link->name, is_gripper(ways, model) ? link->name : likely_end(ends),
          some_of(ends)));
    }
    link = model.getLink(ways.front()->child_link_name);
  }
  return link->name;
}

void require_link(const urdf::ModelInterface& model, const std::string& name, const char* option,
                  const std::string& file) {
  if (model.getLink(name)) return;
  std::vector<std::string> names;
  for (const auto& link : model.links_) names.push_back(link.first);
  throw InputError(fmt::format("{}: has no link '{}' for {}; its links are {}", file, name, option,
                               some_of(names)));
}

KDL::Frame kdl_frame(const urdf::Pose& pose) {
  const urdf::Rotation& r = pose.rotation;
  return {KDL::Rotation::Quaternion(r.x, r.y, r.z, r.w),
          KDL::Vector(pose.position.x, pose.position.y, pose.position.z)};
}

KDL::Joint kdl_joint(const urdf::Joint& joint, const KDL::Frame& origin) {
  const KDL::Vector axis(joint.axis.x, joint.axis.y, joint.axis.z);
  switch (joint.type) {
    case urdf::Joint::REVOLUTE:
    case urdf::Joint::CONTINUOUS:
      return {joint.name, origin.p, origin.M * axis, KDL::Joint::RotAxis};
    case urdf::Joint::PRISMATIC:
      return {joint.name, origin.p, origin.M * axis, KDL::Joint::TransAxis};
    default:
      return KDL::Joint(joint.name, KDL::Joint::Fixed);
  }
}

void add_children(const urdf::Link& link, KDL::Tree& tree) {
  for (const auto& child : link.child_links) {
    const KDL::Frame origin = kdl_frame(child->parent_joint->parent_to_joint_origin_transform);
    tree.addSegment(KDL::Segment(child->name, kdl_joint(*child->parent_joint, origin), origin),
                    link.name);
    add_children(*child, tree);
  }
}

Pose from_kdl(const KDL::Frame& frame) {
  Pose pose;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) pose.rotation(row, column) = frame.M(row, column);
  pose.translation = {frame.p.x(), frame.p.y(), frame.p.z()};
  return pose;
}

// A number that lost its point or its blank is no length of an arm.
void check_size(double number, const urdf::Joint& joint, const std::string& file) {
  if (!(std::abs(number) <= kLargest))
    throw InputError(
        fmt::format("{}: the joint '{}' has a number of {:.4g} (m or rad), which is "
                    "larger than anything real; correct it",
                    file, joint.name, number));
}

void set_axis(const urdf::Joint& joint, const std::string& file, ChainJoint& result) {
  result.axis = {joint.axis.x, joint.axis.y, joint.axis.z};
  if (!(result.axis.norm() > 0))
    throw InputError(file + ": the joint '" + joint.name +
                     "' has the axis 0 0 0, which points nowhere; correct it");
  check_size(result.axis.norm(), joint, file);
  result.axis.normalize();
}

void set_limits(const urdf::Joint& joint, const std::string& file, ChainJoint& result) {
  const bool limited = joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::PRISMATIC;
  if (!joint.limits || !limited) return;
  result.limited = true;
  result.min = joint.limits->lower;
  result.max = joint.limits->upper;
  check_size(result.min, joint, file);
  check_size(result.max, joint, file);
  const bool turns = joint.type == urdf::Joint::REVOLUTE;
  if (result.min >= result.max)
    throw InputError(
        fmt::format("{}: the joint '{}' has limits from {} to {} {}; upper must be above lower",
                    file, joint.name, result.min, result.max, turns ? "rad" : "m"));
  const double furthest = std::max(std::abs(result.min), std::abs(result.max));
  if (!turns || furthest <= kMostTurned) return;
  if (furthest < kNoLimit)
    throw InputError(fmt::format(
        "{}: the joint '{}' has limits from {} to {} rad, which is more than ten turns; write them "
        "in rad, not in deg, or make the joint continuous",
        file, joint.name, result.min, result.max));
  result.limited = false;
}

ChainJoint joint_of(const KDL::Segment& segment, const urdf::ModelInterface& model,
                    const TiXmlElement* robot, const std::string& name_of_file) {
  const urdf::Joint& joint = *model.getJoint(segment.getJoint().getName());
  const std::string file = place_of_joint(robot, name_of_file, joint.name);
  const urdf::Link& link = *model.getLink(segment.getName());
  ChainJoint result;
  result.name = joint.name;
  result.link = link.name;
  result.origin = from_kdl(segment.pose(0));
  result.backwards = joint.child_link_name != link.name;
  if (joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS)
    result.kind = ChainJoint::Kind::revolute;
  else if (joint.type == urdf::Joint::PRISMATIC)
    result.kind = ChainJoint::Kind::prismatic;
  else if (!is_fixed(joint))
    result.kind = ChainJoint::Kind::other;
  if (joint.mimic)
    throw InputError(fmt::format(
        "{}: the joint '{}' follows '{}' (mimic), but each joint of a chain moves by itself; "
        "--base and --tip name links between which no joint follows another",
        file, joint.name, joint.mimic->joint_name));
  if (result.kind != ChainJoint::Kind::fixed && result.backwards)
    throw InputError(file + ": the joint '" + joint.name +
                     "' lies behind the base; --base names a link before all driven joints");
  if (result.is_driven()) {
    set_axis(joint, file, result);
    set_limits(joint, file, result);
  }
  check_size(result.origin.translation.norm(), joint, file);
  if (link.inertial && !result.backwards) {
    result.mass_kg = link.inertial->mass;
    const urdf::Vector3& c = link.inertial->origin.position;
    result.centre = {c.x, c.y, c.z};
  }
  return result;
}

bool stand_together(const Pose& a, const Pose& b) {
  constexpr double kRounding = 1e-5;  // of angles that are written as 3.14159; [rad], [m]
  return a.rotation.isApprox(b.rotation, kRounding) &&
         (a.translation - b.translation).isZero(kRounding);
}

// Links that stand fixed beside the way or on it, before its first driven joint, but not where the
// base does. Of links that stand together the first counts, and one beside the way before one on
// it: a controller's frame stands beside.
std::vector<std::string> fixed_elsewhere(const urdf::ModelInterface& model,
                                         const UrdfChain& chain) {
  std::vector<std::pair<std::string, Pose>> beside, on_the_way;
  std::string link = chain.base;
  Pose frame;
  for (const ChainJoint& next : chain.joints) {
    for (const auto& joint : model.getLink(link)->child_joints)
      if (joint->name != next.name && !moves(*joint, model))
        beside.emplace_back(joint->child_link_name,
                            frame * from_kdl(kdl_frame(joint->parent_to_joint_origin_transform)));
    if (next.is_driven() || next.backwards) break;
    frame = frame * next.origin;
    link = next.link;
    on_the_way.emplace_back(link, frame);
  }
  std::vector<Pose> known{Pose{}};
  std::vector<std::string> names;
  for (const auto& links : {beside, on_the_way})
    for (const auto& [name, at] : links) {
      if (std::ranges::any_of(known, [&](const Pose& one) { return stand_together(one, at); }))
        continue;
      known.push_back(at);
      names.push_back(name);
    }
  return names;
}

}  // namespace

UrdfChain read_urdf_chain(const std::string& text, const std::string& file, const UrdfEnds& ends) {
  check_xml_bounds(text, file);
  refuse_xacro(text, file);
  TiXmlDocument document;
  document.Parse(text.c_str());
  const TiXmlElement* const robot = document.FirstChildElement("robot");
  if (robot) {
    require_tree(*robot, file);
    check_masses(*robot, file);
  }
  const urdf::ModelInterfaceSharedPtr model = parse_strictly(text, robot, file);
  UrdfChain result;
  result.robot = model->getName();
  result.base = ends.base.empty() ? model->getRoot()->name : ends.base;
  require_link(*model, result.base, "--base", file);
  if (!ends.tip.empty()) require_link(*model, ends.tip, "--tip", file);
  const std::string tip = ends.tip.empty() ? only_end(*model, result.base, file) : ends.tip;

  KDL::Tree tree(model->getRoot()->name);
  add_children(*model->getRoot(), tree);
  KDL::Chain way;
  if (!tree.getChain(result.base, tip, way))
    throw InputError(file + ": there is no way from '" + result.base + "' to '" + tip + "'");
  for (const KDL::Segment& segment : way.segments)
    result.joints.push_back(joint_of(segment, *model, robot, file));
  result.beside_base = fixed_elsewhere(*model, result);
  return result;
}

}  // namespace armtrue
