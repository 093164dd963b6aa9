#include <fmt/format.h>
#include <tinyxml.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "armtrue/io/link_names.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "armtrue/text/utf8.h"
#include "armtrue/urdf/urdf_io.h"
#include "urdf/link_frames.h"
#include "urdf/urdf_chain.h"
#include "urdf/xml_bounds.h"

namespace armtrue {
namespace {

using Eigen::Vector3d;

// A link entry that write_urdf left. A link that follows several others is several joints on one
// axis, all but the first without lengths.
struct ExactLink {
  Link link;
  bool on_same_axis = false;
  std::optional<double> from, coefficient;  // see Coupling
  bool is_of_followed = false;              // it copies what a link that it follows does
};

// The exact link entries that write_urdf left, by joint name.
std::map<std::string, ExactLink> exact_links(const std::string& text) {
  std::map<std::string, ExactLink> links;
  TiXmlDocument document;
  document.Parse(text.c_str());
  const TiXmlElement* robot = document.FirstChildElement("robot");
  if (!robot) return links;
  for (const TiXmlElement* joint = robot->FirstChildElement("joint"); joint;
       joint = joint->NextSiblingElement("joint")) {
    const TiXmlElement* own = joint->FirstChildElement("armtrue");
    const char* name = joint->Attribute("name");
    if (!own || !name) continue;
    const auto value = [&](const char* key, double unit) {
      const char* number = own->Attribute(key);
      return number ? std::strtod(number, nullptr) * unit : 0.0;
    };
    Link link;
    link.alpha = value("alpha_deg", kDegree);
    link.d = value("d_mm", kMillimetre);
    link.theta = value("theta_deg", kDegree);
    link.r = value("r_mm", kMillimetre);
    link.beta = value("beta_deg", kDegree);
    ExactLink& exact = links[name];
    exact.link = link;
    exact.on_same_axis = own->Attribute("same_axis");
    if (own->Attribute("from_deg")) exact.from = value("from_deg", kDegree);
    if (own->Attribute("from_mm")) exact.from = value("from_mm", kMillimetre);
    exact.is_of_followed = own->Attribute("of_followed");
    if (own->Attribute("coefficient")) exact.coefficient = value("coefficient", 1);
  }
  return links;
}

bool agree(const Pose& a, const Pose& b) {
  return (a.translation - b.translation).norm() < 1e-9 && (a.rotation - b.rotation).norm() < 1e-9;
}

JointKind kind_of(const ChainJoint& joint) {
  if (joint.kind == ChainJoint::Kind::revolute) return JointKind::revolute;
  return joint.kind == ChainJoint::Kind::prismatic ? JointKind::prismatic : JointKind::fixed;
}

void copy_joint(const ChainJoint& from, Link& link) {
  link.name = from.link;
  link.joint = kind_of(from);
  link.has_encoder = from.has_encoder;
  if (!from.limited) return;
  link.min = from.min;
  link.max = from.max;
}

void copy_mass(const ChainJoint& from, int link, const Pose& link_from_urdf, Robot& robot) {
  if (from.mass_kg > 0) robot.bodies.push_back({link, from.mass_kg, link_from_urdf * from.centre});
}

// Whether the chain leads from `world` to `tool` of write_urdf: both ends are fixed, and the joints
// between them have exact entries. Not so where --tip names a link within the arm.
bool is_own_document(const std::vector<ChainJoint>& chain,
                     const std::map<std::string, ExactLink>& exact) {
  if (chain.size() < 3 || chain.size() > kMaxLinks + 2) return false;
  const auto is_fixed_end = [&](const ChainJoint& joint) {
    return joint.kind == ChainJoint::Kind::fixed && !exact.contains(joint.name);
  };
  return is_fixed_end(chain.front()) && is_fixed_end(chain.back()) &&
         std::all_of(chain.begin() + 1, chain.end() - 1,
                     [&](const ChainJoint& joint) { return exact.contains(joint.name); });
}

// How the links of write_urdf follow each other; false if one follows a joint that is not among
// them, or itself. `link_of`: by joint. A screw of a SCARA follows a joint behind it.
bool add_written_couplings(const std::vector<ChainJoint>& joints,
                           const std::map<std::string, ExactLink>& exact,
                           const std::map<std::string, int>& link_of, KinematicChain& chain) {
  for (const ChainJoint& joint : joints)
    for (const ChainMimic& mimic : joint.follows) {
      const auto followed = link_of.find(mimic.joint);
      if (followed == link_of.end()) return false;
      const ExactLink& entry = exact.at(joint.name);
      if (entry.is_of_followed) continue;
      const double zero = zero_of(std::as_const(chain.links[followed->second]));
      chain.couplings.push_back({link_of.at(joint.name), followed->second,
                                 entry.coefficient.value_or(mimic.multiplier),
                                 entry.from.value_or(zero)});
    }
  try {
    coupling_order(chain);
  } catch (const std::invalid_argument&) {
    return false;  // of which the caller's other way says so
  }
  return true;
}

// Whether the joints follow others as write_urdf would have them. `link_of`: by joint.
bool has_mimics_of(const std::vector<ChainJoint>& joints, const KinematicChain& chain,
                   const std::map<std::string, int>& link_of) {
  constexpr double kSame = 1e-9;  // [rad], [m]
  std::map<int, size_t> places;   // of the next mimic of each link
  for (const ChainJoint& joint : joints)
    for (const ChainMimic& mimic : joint.follows) {
      const int link = link_of.at(joint.name);
      const std::vector<WrittenMimic> all = written_mimics(chain, link);
      const size_t place = places[link]++;
      if (place >= all.size()) return false;
      const WrittenMimic& written = all[place];
      if (link_of.at(mimic.joint) != written.followed ||
          std::abs(mimic.multiplier - written.multiplier) > kSame ||
          std::abs(mimic.offset - written.offset) > kSame)
        return false;
    }
  return true;
}

// Reads world, base_link, the links and tool in the order of write_urdf.
std::optional<Robot> as_written(const std::vector<ChainJoint>& chain,
                                const std::map<std::string, ExactLink>& exact) {
  if (!is_own_document(chain, exact)) return std::nullopt;
  Robot robot;
  robot.chain.base = chain.front().origin;
  robot.chain.tool = chain.back().origin;
  std::map<std::string, int> link_of;  // by joint
  for (size_t j = 0; j + 2 < chain.size(); ++j) {
    const ChainJoint& joint = chain[j + 1];
    const ExactLink& entry = exact.at(joint.name);
    if (joint.kind == ChainJoint::Kind::other) return std::nullopt;
    std::vector<Link>& links = robot.chain.links;
    const bool goes_on = entry.on_same_axis && !links.empty();
    if (!agree(link_transform(entry.link), joint.origin))
      return std::nullopt;  // somebody changed the origin: that counts
    if (!goes_on) links.push_back(entry.link);
    Link& link = links.back();
    copy_joint(joint, link);
    if (joint.moves()) {
      if (joint.axis.x() != 0 || joint.axis.y() != 0) return std::nullopt;
      link.sign = joint.axis.z() < 0 ? -1 : 1;
    }
    link_of[joint.name] = link_count(robot.chain) - 1;
    copy_mass(joint, link_of[joint.name], Pose{}, robot);
  }
  if (!add_written_couplings(chain, exact, link_of, robot.chain)) return std::nullopt;
  if (joint_count(robot.chain) < 1 || joint_count(robot.chain) > kMaxJoints) return std::nullopt;
  if (!has_mimics_of(chain, robot.chain, link_of)) return std::nullopt;  // changed: that counts
  return robot;
}

// R_0 in the frame of --base, with its axes; or the ground of two arms in the frame of its link.
// alpha and beta of link 1 turn z to the first axis, d and r lead to a point of the axis along the
// turned x and z. What is left along the turned y, mostly 0, is the shift of R_0.
Pose foot_of(const JointAxis& first) {
  constexpr double kRounding = 1e-12;  // [m], of pi in a double
  const Vector3d y = rotation_before(link_along(first.direction)).col(1);
  const double left = y.dot(first.point);
  Pose foot;
  if (std::abs(left) > kRounding) foot.translation = left * y;
  return foot;
}

void require_arm(const std::vector<ChainJoint>& chain, const std::string& file) {
  int driven = 0;
  for (const ChainJoint& joint : chain) {
    if (joint.kind == ChainJoint::Kind::other)
      throw InputError(file + ": the joint '" + joint.name +
                       "' is neither revolute, prismatic nor fixed; --base and --tip name links "
                       "between which there is no such joint");
    if (joint.kind == ChainJoint::Kind::prismatic && !joint.limited && joint.has_encoder)
      throw InputError(file + ": the prismatic joint '" + joint.name +
                       "' has no limit; add <limit lower=... upper=...>, in m");
    driven += joint.is_driven();
    for (const ChainMimic& mimic : joint.follows) {
      const auto leader = std::ranges::find(chain, mimic.joint, &ChainJoint::name);
      if (leader == chain.end() || !leader->moves())
        throw InputError(fmt::format(
            "{}: the joint '{}' follows '{}' (mimic) by {}, which {}; --base and --tip name links "
            "between which both stand",
            file, joint.name, mimic.joint, mimic.multiplier,
            leader == chain.end() ? "does not stand between base and tip" : "does not move"));
    }
  }
  if (driven < 1 || driven > kMaxJoints)
    throw InputError(
        fmt::format("{}: has {} (revolute or prismatic) from base to tip; armtrue "
                    "knows arms of 1 to {}; --base and --tip name other ends",
                    file, counted(driven, "driven joint"), kMaxJoints));
}

// Parameters are named after links, so each link needs a name of its own: that of the link in the
// URDF, or of its joint. A rail, for one, moves a link called base_link.
void name_links(const std::vector<const ChainJoint*>& moving, std::vector<Link>& links) {
  const auto is_free = [&](const std::string& name, size_t count) {
    return !is_reserved_link_name(name) && name != links.back().name &&
           std::none_of(links.begin(), links.begin() + count,
                        [&](const Link& link) { return link.name == name; });
  };
  for (size_t j = 0; j < moving.size(); ++j) {
    std::string name = moving[j]->link;
    if (!is_free(name, j)) name = moving[j]->name;
    while (!is_free(name, j)) name += '_';
    links[j].name = name;
  }
}

// Whether the second joint turns about the axis of the first, or against it: 1, -1; 0 if not.
int turns_on_same_axis(const ChainJoint& first, const ChainJoint& second) {
  constexpr double kSame = 1e-9;  // [m], of unit vectors
  if (first.kind != ChainJoint::Kind::revolute || second.kind != ChainJoint::Kind::revolute)
    return 0;
  const Vector3d axis = second.origin.rotation * second.axis, &own = first.axis;
  if (own.cross(axis).norm() > kSame || own.cross(second.origin.translation).norm() > kSame)
    return 0;
  return own.dot(axis) < 0 ? -1 : 1;
}

// A mimic follows one joint, so a joint that follows several stands in a URDF as several joints on
// one axis: they become one again. Not where another joint follows one of them, or where a body
// moves with the first alone.
std::vector<ChainJoint> with_axes_merged(const std::vector<ChainJoint>& chain) {
  const auto is_followed = [&](const ChainJoint& joint) {
    return std::ranges::any_of(chain, [&](const ChainJoint& other) {
      return std::ranges::find(other.follows, joint.name, &ChainMimic::joint) !=
             other.follows.end();
    });
  };
  std::vector<ChainJoint> merged;
  for (const ChainJoint& next : chain) {
    if (merged.empty() || (merged.back().follows.empty() && next.follows.empty())) {
      merged.push_back(next);
      continue;
    }
    ChainJoint& last = merged.back();
    const int turn = turns_on_same_axis(last, next);
    if (turn == 0 || (last.is_driven() && next.is_driven()) || last.mass_kg > 0 ||
        is_followed(last) || is_followed(next)) {
      merged.push_back(next);
      continue;
    }
    ChainJoint both = last.is_driven() ? last : next;
    both.origin = last.origin * next.origin;
    both.axis = last.is_driven() ? Vector3d(turn * next.axis) : next.axis;
    both.mass_kg = next.mass_kg;
    both.centre = next.centre;
    both.follows.clear();
    // In the direction of `both`.
    const double of_last = last.is_driven() ? 1 : turn, of_next = last.is_driven() ? turn : 1;
    const auto add = [&](const std::vector<ChainMimic>& follows, double direction) {
      for (const ChainMimic& mimic : follows)
        both.follows.push_back(
            {mimic.joint, direction * mimic.multiplier, direction * mimic.offset});
    };
    add(last.follows, of_last);
    add(next.follows, of_next);
    both.shift = of_last * last.shift + of_next * next.shift;
    both.has_encoder = last.is_driven() || next.is_driven();
    if (!both.has_encoder) both.limited = false;  // each has its own, their sum none
    last = both;
  }
  return merged;
}

// How the links of the joints that move, in their order, follow each other.
void add_couplings(const std::vector<const ChainJoint*>& moving, KinematicChain& chain) {
  std::vector<double> offsets(moving.size(), 0.0);
  for (int j = 0; j < std::ssize(moving); ++j) {
    offsets[j] = moving[j]->shift;
    for (const ChainMimic& mimic : moving[j]->follows) {
      const auto leader = std::ranges::find(moving, mimic.joint,
                                            [](const ChainJoint* joint) { return joint->name; });
      const auto followed = static_cast<int>(leader - moving.begin());
      chain.couplings.push_back(
          {j, followed, mimic.multiplier, zero_of(std::as_const(chain.links[followed]))});
      offsets[j] += mimic.offset;
    }
  }
  for (size_t j = 0; j < moving.size(); ++j)
    if (offsets[j] != 0) zero_of(chain.links[j]) += chain.links[j].sign * offsets[j];
}

// The ground between two arms, placed as R_0 before the axis that follows; its z axis counts as the
// axis of a joint.
void place_ground(size_t ground, std::vector<JointAxis>& axes, Pose& frame) {
  const Pose back = inverse(frame);
  frame = frame * foot_of({back * axes[ground + 1].point,
                           Vector3d(back.rotation * axes[ground + 1].direction)});
  axes[ground].point = frame.translation;
}

Robot from_axes(const std::vector<ChainJoint>& joints, const std::string& file) {
  require_arm(joints, file);
  const std::vector<ChainJoint> chain = with_axes_merged(joints);
  Robot robot;
  std::vector<JointAxis> axes;
  std::vector<const ChainJoint*> moving;  // and the ground
  std::vector<Pose> urdf_frames;          // of the link behind every joint, at zero
  std::vector<int> link_of;               // of `moving`, the last before or at each joint
  Pose frame, ground;
  for (const ChainJoint& joint : chain) {
    frame = frame * joint.origin;
    if (joint.is_ground) {
      ground = frame;
      robot.ground_link = static_cast<int>(moving.size());
    }
    if (joint.moves() || joint.is_ground) {
      const Vector3d axis = joint.is_ground ? Vector3d(Vector3d::UnitZ()) : joint.axis;
      axes.push_back({frame.translation, frame.rotation * axis});
      moving.push_back(&joint);
    }
    urdf_frames.push_back(frame);
    link_of.push_back(static_cast<int>(moving.size()) - 1);
  }
  if (robot.ground_link) place_ground(*robot.ground_link, axes, ground);
  Pose previous = foot_of(axes.front());
  robot.chain.base = previous;
  // Programs state the flange, so the last link ends in the tip. The z axis of the tip follows the
  // last axis as that of another joint would; the frame on it is the tip itself.
  const JointAxis tip{frame.translation, frame.rotation.col(2)};
  std::vector<Pose> frames;
  robot.chain.links.resize(axes.size() + 1);
  for (size_t j = 0; j < axes.size(); ++j) {
    const Pose next = moving[j]->is_ground  ? ground
                      : j + 1 < axes.size() ? frame_towards(axes[j], axes[j + 1], previous)
                                            : frame_towards(axes[j], tip, frame);
    robot.chain.links[j] = link_between(previous, next);
    copy_joint(*moving[j], robot.chain.links[j]);
    frames.push_back(next);
    previous = next;
  }
  robot.chain.links.back() = link_between(previous, frame);
  robot.chain.links.back().name = "flange";
  name_links(moving, robot.chain.links);
  robot.chain.links.back().joint = JointKind::fixed;
  add_couplings(moving, robot.chain);
  for (size_t k = 0; k < chain.size(); ++k)
    if (const size_t link = link_of[k]; link_of[k] >= 0 && !moving[link]->is_ground) {
      copy_mass(chain[k], link_of[k], inverse(frames[link]) * urdf_frames[k], robot);
    }
  return robot;
}

}  // namespace

Robot robot_of(const UrdfChain& chain, const std::string& text, const std::string& file) {
  const std::map<std::string, ExactLink> exact = exact_links(text);
  Robot robot;
  if (std::optional<Robot> written = as_written(chain.joints, exact)) {
    robot = std::move(*written);
  } else if (is_own_document(chain.joints, exact)) {
    // Somebody changed an origin. R_0, the last link and the measured frame stay what they were.
    robot = from_axes({chain.joints.begin() + 1, chain.joints.end() - 1}, file);
    robot.chain.base = chain.joints.front().origin * robot.chain.base;
    robot.chain.tool = chain.joints.back().origin;
  } else {
    robot = from_axes(chain.joints, file);
  }
  robot.name = chain.robot;
  return robot;
}

Robot with_frames_of_axes(const Robot& robot) {
  std::vector<ChainJoint> joints;
  for (const Link& link : robot.chain.links) {
    ChainJoint& joint = joints.emplace_back();
    joint.name = joint.link = link.name;
    if (link.joint == JointKind::revolute) joint.kind = ChainJoint::Kind::revolute;
    if (link.joint == JointKind::prismatic) joint.kind = ChainJoint::Kind::prismatic;
    joint.origin = link_transform(link);
    joint.axis.z() = link.sign;
    joint.limited = std::isfinite(link.min) && std::isfinite(link.max);
    joint.min = link.min;
    joint.max = link.max;
  }
  joints.emplace_back().origin = robot.chain.tool;
  return from_axes(joints, robot.name);
}

Robot parse_urdf(const std::string& text, const std::string& file, const UrdfEnds& ends) {
  const std::string utf8 = as_utf8(text);
  return robot_of(read_urdf_chain(utf8, file, ends), utf8, file);
}

std::vector<std::string> frames_beside_base(const std::string& text, const std::string& file,
                                            const UrdfEnds& ends) {
  const UrdfChain chain = read_urdf_chain(text, file, ends);
  if (as_written(chain.joints, exact_links(text))) return {};
  return chain.beside_base;
}

Vector3d foot_beside_base(const std::string& text, const std::string& file, const UrdfEnds& ends) {
  const UrdfChain chain = read_urdf_chain(text, file, ends);
  if (is_own_document(chain.joints, exact_links(text))) return Vector3d::Zero();
  return from_axes(chain.joints, file).chain.base.translation;
}

std::string tool0_beside_tip(const std::string& text, const std::string& file,
                             const UrdfEnds& ends) {
  return read_urdf_chain(text, file, ends).tool0;
}

std::vector<std::string> links_without_travel(const std::string& text, const std::string& file,
                                              const UrdfEnds& ends) {
  std::vector<std::string> links;
  for (const ChainJoint& joint : read_urdf_chain(text, file, ends).joints)
    if (joint.lacks_travel) links.push_back(joint.link);
  return links;
}

std::map<std::string, std::string> urdf_joint_of_link(const std::string& text,
                                                      const std::string& file) {
  check_xml_bounds(text, file);
  TiXmlDocument document;
  document.Parse(text.c_str());
  const TiXmlElement* const robot = document.FirstChildElement("robot");
  if (document.Error() || !robot)
    throw InputError(file + ": is no URDF; give the robot_description, expanded from xacro");
  std::map<std::string, std::string> joints;
  for (const TiXmlElement* joint = robot->FirstChildElement("joint"); joint;
       joint = joint->NextSiblingElement("joint")) {
    const TiXmlElement* const child = joint->FirstChildElement("child");
    const char* const link = child ? child->Attribute("link") : nullptr;
    const char* const name = joint->Attribute("name");
    if (link && name) joints[link] = name;
  }
  return joints;
}

}  // namespace armtrue
