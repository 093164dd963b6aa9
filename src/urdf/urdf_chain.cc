#include "urdf/urdf_chain.h"

#include <fmt/format.h>
#include <urdf_model/model.h>

#include <algorithm>
#include <cmath>
#include <kdl/chain.hpp>
#include <kdl/tree.hpp>
#include <map>
#include <numbers>

#include "armtrue/text/input_error.h"
#include "urdf/urdf_document.h"
#include "urdf/urdf_ends.h"

namespace armtrue {
namespace {

constexpr double kMaxOffset = 100;     // m, of two joints
constexpr double kMaxMagnitude = 1e6;  // of lengths, angles and parts of axes
// Limits of a revolute joint [rad]: further ones are deg, or stand for no limit.
constexpr double kMostTurned = 10 * 2 * std::numbers::pi, kNoLimit = 1000;

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

// Throws InputError for a number that lost its decimal point or a blank.
void check_size(double number, const urdf::Joint& joint, const std::string& file) {
  if (!(std::abs(number) <= kMaxMagnitude))
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
  if (turns && result.min == 0 && result.max == 0) {
    result.limited = false;  // exporters of CAD write it where nobody has entered the travel
    result.lacks_travel = true;
    return;
  }
  if (result.min >= result.max)
    throw InputError(
        fmt::format("{}: the joint '{}' has limits from {} to {} {}; upper must be above lower",
                    file, joint.name, result.min, result.max, turns ? "rad" : "m"));
  const double furthest = std::max(std::abs(result.min), std::abs(result.max));
  constexpr double kLongestRail = 100, kNoRail = 1e5;  // m; more is no limit at all
  if (!turns && furthest > kLongestRail && furthest <= kNoRail)
    throw InputError(fmt::format(
        "{}: the joint '{}' has limits from {} to {} m, which is longer than any rail; write them "
        "in m, not in mm",
        file, joint.name, result.min, result.max));
  if (!turns || furthest <= kMostTurned) return;
  if (furthest < kNoLimit)
    throw InputError(fmt::format(
        "{}: the joint '{}' has limits from {} to {} rad, which is more than ten turns; write them "
        "in rad, not in deg, or make the joint continuous",
        file, joint.name, result.min, result.max));
  result.limited = false;
}

ChainJoint joint_of(const KDL::Segment& segment, const UrdfDocument& document) {
  const urdf::Joint& joint = *document.model().getJoint(segment.getJoint().getName());
  const std::string file = document.place_of_joint(joint.name);
  const urdf::Link& link = *document.model().getLink(segment.getName());
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
  if (joint.mimic && result.moves()) {
    result.has_encoder = false;
    result.follows.push_back(
        {joint.mimic->joint_name, joint.mimic->multiplier, joint.mimic->offset});
    check_size(joint.mimic->multiplier, joint, file);
    check_size(joint.mimic->offset, joint, file);
  }
  if (result.moves()) {
    set_axis(joint, file, result);
    set_limits(joint, file, result);
  }
  check_size(result.origin.translation.norm(), joint, file);
  if (const double away = result.origin.translation.norm(); result.moves() && away > kMaxOffset)
    throw InputError(fmt::format(
        "{}: the joint '{}' stands {:.4g} m from the one before it; a URDF counts in m: divide "
        "lengths in mm by 1000",
        file, joint.name, away));
  if (link.inertial && !result.backwards) {
    result.mass_kg = link.inertial->mass;
    const urdf::Vector3& c = link.inertial->origin.position;
    result.centre = {c.x, c.y, c.z};
  }
  return result;
}

// From child to parent a joint moves by (origin motion(q))^-1 = motion(-q) origin^-1.
void add_joint(ChainJoint joint, const UrdfDocument& document, std::vector<ChainJoint>& joints) {
  if (!joint.backwards || !joint.moves()) {
    joints.push_back(joint);
    return;
  }
  ChainJoint behind;
  behind.name = joint.name + "_origin";
  behind.link = joint.link;
  behind.origin = joint.origin;
  behind.backwards = true;
  joint.link = document.model().getJoint(joint.name)->child_link_name;
  joint.origin = {};
  joint.axis = -joint.axis;
  joints.push_back(joint);
  joints.push_back(behind);
}

// Marks the link on which two arms of one chain stand: there the chain stops leading backwards.
void find_ground(std::vector<ChainJoint>& joints, const UrdfDocument& document) {
  const auto moves_backwards = [](const ChainJoint& joint) {
    return joint.backwards && joint.moves();
  };
  const auto first = std::ranges::find_if(joints, moves_backwards);
  if (first == joints.end()) return;
  const auto ground =
      std::find_if(joints.rbegin(), joints.rend(), [](const auto& one) { return one.backwards; });
  if (std::none_of(joints.rbegin(), ground, [](const auto& one) { return one.moves(); }))
    throw InputError(document.place_of_joint(first->name) + ": the joint '" + first->name +
                     "' lies behind the base; --base names a link before all driven joints, or of "
                     "two arms the tool of one and --tip that of the other");
  ground->is_ground = true;
}

// A motor may stand beside the chain: that of a palletiser's forearm turns a crank at the column,
// and rods pass the motion on. The first joint of the chain that follows it with multiplier 1 or -1
// then gets its encoder; the others follow that joint.
void take_encoders_beside(const UrdfDocument& document, std::vector<ChainJoint>& joints) {
  for (ChainJoint& own : joints) {
    if (own.follows.empty()) continue;
    const ChainMimic mimic = own.follows.front();
    const bool is_on_way =
        std::ranges::find(joints, mimic.joint, &ChainJoint::name) != joints.end();
    const auto motor = document.model().getJoint(mimic.joint);
    if (is_on_way || !motor || motor->mimic || std::abs(mimic.multiplier) != 1) continue;
    ChainJoint limits;
    set_limits(*motor, document.place_of_joint(motor->name), limits);
    // Along its own axis it moves by multiplier * value + offset; along the new one by value +
    // shift.
    own.has_encoder = true;
    own.follows.clear();
    own.axis *= mimic.multiplier;
    own.shift = mimic.multiplier * mimic.offset;
    own.limited = limits.limited;
    own.min = limits.min;
    own.max = limits.max;
    for (ChainJoint& other : joints)
      for (ChainMimic& follows : other.follows)
        if (follows.joint == mimic.joint) {
          follows.joint = own.name;
        } else if (follows.joint == own.name) {
          follows.offset += follows.multiplier * mimic.offset;
          follows.multiplier *= mimic.multiplier;
        }
  }
}

bool stand_together(const Pose& a, const Pose& b) {
  constexpr double kRounding = 1e-5;  // of angles that are written as 3.14159; [rad], [m]
  return a.rotation.isApprox(b.rotation, kRounding) &&
         (a.translation - b.translation).isZero(kRounding);
}

// Links that are fixed to the base, on the chain before its first driven joint or beside it, at
// another pose than the base. Of links at one pose the first counts, those beside the chain before
// those on it: a controller's frame is beside.
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
    if (next.moves() || next.backwards) break;
    frame = frame * next.origin;
    link = next.link;
    on_the_way.emplace_back(link, frame);
  }
  std::vector<Pose> known{Pose{}};
  std::vector<std::string> names;
  for (const auto& links : {beside, on_the_way})
    for (const auto& [name, place] : links) {
      const Pose& at = place;  // clang 14 lets no lambda capture a structured binding
      if (std::ranges::any_of(known, [&](const Pose& one) { return stand_together(one, at); }))
        continue;
      known.push_back(at);
      names.push_back(name);
    }
  return names;
}

// The frames of a link and of all that is fixed to it, by name, from `frame` of the link.
void find_fixed_links(const urdf::Link& link, const Pose& frame,
                      std::map<std::string, Pose>& frames) {
  frames[link.name] = frame;
  for (const auto& child : link.child_links)
    if (is_fixed(*child->parent_joint))
      find_fixed_links(
          *child, frame * from_kdl(kdl_frame(child->parent_joint->parent_to_joint_origin_transform)),
          frames);
}

std::string tool0_elsewhere(const urdf::ModelInterface& model, const UrdfChain& chain) {
  const auto last = std::find_if(chain.joints.rbegin(), chain.joints.rend(),
                                 [](const ChainJoint& joint) { return joint.moves(); });
  if (last == chain.joints.rend()) return "";
  std::map<std::string, Pose> frames;
  find_fixed_links(*model.getLink(last->link), Pose{}, frames);
  const auto tip = frames.find(chain.joints.back().link);
  if (tip == frames.end()) return "";
  for (const auto& [name, frame] : frames)
    if (name.ends_with("tool0")) return stand_together(frame, tip->second) ? "" : name;
  return "";
}

}  // namespace

UrdfChain read_urdf_chain(const std::string& text, const std::string& file, const UrdfEnds& ends) {
  const UrdfDocument document(text, file);
  const urdf::ModelInterface& model = document.model();
  UrdfChain result;
  result.robot = model.getName();
  result.base = ends.base.empty() ? model.getRoot()->name : ends.base;
  require_link(model, result.base, "--base", file);
  if (!ends.tip.empty()) require_link(model, ends.tip, "--tip", file);
  const std::string tip = ends.tip.empty() ? only_end(model, result.base, file) : ends.tip;

  KDL::Tree tree(model.getRoot()->name);
  add_children(*model.getRoot(), tree);
  KDL::Chain way;
  if (!tree.getChain(result.base, tip, way))
    throw InputError(file + ": there is no way from '" + result.base + "' to '" + tip + "'");
  for (const KDL::Segment& segment : way.segments)
    add_joint(joint_of(segment, document), document, result.joints);
  find_ground(result.joints, document);
  take_encoders_beside(document, result.joints);
  result.beside_base = fixed_elsewhere(model, result);
  result.tool0 = tool0_elsewhere(model, result);
  return result;
}

}  // namespace armtrue
