#include "armtrue/io/urdf_io.h"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <tinyxml.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <optional>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"

namespace armtrue {
namespace {

using Eigen::Vector3d;

Pose link_transform(const Link& link) {
  using Eigen::AngleAxisd;
  const Eigen::Matrix3d before =
      (AngleAxisd(link.beta, Vector3d::UnitY()) * AngleAxisd(link.alpha, Vector3d::UnitX()))
          .toRotationMatrix();
  Pose pose;
  pose.rotation = before * AngleAxisd(link.theta, Vector3d::UnitZ()).toRotationMatrix();
  pose.translation = before * Vector3d(link.d, 0, link.r);
  return pose;
}

// Escapes a text for an attribute. One character at a time, because tinyxml takes "&#x" for the
// beginning of a reference and leaves it as it is.
std::string attribute(const std::string& text) {
  std::string result;
  for (const char c : text) TiXmlBase::EncodeString(std::string(1, c), &result);
  return result;
}

// URDF's roll, pitch and yaw are KUKA's C, B and A.
std::string origin_xml(const Pose& pose) {
  const Vector3d abc = abc_from_rotation(pose.rotation);
  const Vector3d& t = pose.translation;
  return fmt::format("<origin xyz=\"{} {} {}\" rpy=\"{} {} {}\"/>", number_text(t.x()),
                     number_text(t.y()), number_text(t.z()), number_text(abc[2]),
                     number_text(abc[1]), number_text(abc[0]));
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
std::string link_attributes(const Link& link) {
  return fmt::format(
      "    <armtrue alpha_deg=\"{}\" d_mm=\"{}\" theta_deg=\"{}\" r_mm=\"{}\" beta_deg=\"{}\"/>\n",
      number_text(link.alpha, kDegree), number_text(link.d, kMillimetre),
      number_text(link.theta, kDegree), number_text(link.r, kMillimetre),
      number_text(link.beta, kDegree));
}

std::string fixed_joint_xml(const std::string& name, const std::string& parent,
                            const std::string& child, const Pose& pose,
                            const std::string& attributes = "") {
  return fmt::format(
      "  <joint name=\"{}\" type=\"fixed\">\n    <parent link=\"{}\"/>\n    <child link=\"{}\"/>\n"
      "    {}\n{}  </joint>\n",
      attribute(name), attribute(parent), attribute(child), origin_xml(pose), attributes);
}

std::string revolute_joint_xml(const Link& link, const std::string& parent) {
  const bool limited = std::isfinite(link.min) && std::isfinite(link.max);
  return fmt::format(
      "  <joint name=\"joint_{}\" type=\"{}\">\n    <parent link=\"{}\"/>\n    <child "
      "link=\"{}\"/>\n"
      "    {}\n    <axis xyz=\"0 0 {}\"/>\n{}{}  </joint>\n",
      attribute(link.name), limited ? "revolute" : "continuous", attribute(parent),
      attribute(link.name), origin_xml(link_transform(link)), link.sign > 0 ? "1" : "-1",
      limited ? fmt::format("    <limit lower=\"{}\" upper=\"{}\" effort=\"0\" velocity=\"0\"/>\n",
                            number_text(link.min), number_text(link.max))
              : "",
      link_attributes(link));
}

Pose pose_of(const urdf::Pose& pose) {
  Pose result;
  result.rotation =
      Eigen::Quaterniond(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z)
          .toRotationMatrix();
  result.translation = {pose.position.x, pose.position.y, pose.position.z};
  return result;
}

// One joint of the chain as urdfdom has it.
struct ChainJoint {
  urdf::JointConstSharedPtr joint;
  urdf::LinkConstSharedPtr child;
};

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

// urdfdom skips elements that it cannot read. A skipped mass would change the predictions, so its
// messages become errors.
urdf::ModelInterfaceSharedPtr parse_strictly(const std::string& text, const std::string& file) {
  const Complaints complaints;
  urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(text);
  if (!complaints.first().empty())
    throw InputError(file + ": is no valid URDF: " + complaints.first());
  if (!model || !model->getRoot())
    throw InputError(file + ": is no valid URDF: it has no root link");
  return model;
}

// urdfdom accepts a negative mass, and does not name the link of a mass that is no number.
void check_masses(const std::string& text, const std::string& file) {
  TiXmlDocument document;
  document.Parse(text.c_str());
  const TiXmlElement* const robot = document.FirstChildElement("robot");
  if (!robot) return;
  for (const TiXmlElement* link = robot->FirstChildElement("link"); link;
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

std::vector<ChainJoint> serial_chain(const urdf::ModelInterface& model, const std::string& file) {
  std::vector<ChainJoint> chain;
  urdf::LinkConstSharedPtr link = model.getRoot();
  while (!link->child_joints.empty()) {
    if (link->child_joints.size() > 1)
      throw InputError(file + ": the link '" + link->name +
                       "' branches; armtrue needs one serial chain from base to tool");
    const urdf::JointConstSharedPtr joint = link->child_joints.front();
    link = model.getLink(joint->child_link_name);
    chain.push_back({joint, link});
  }
  return chain;
}

bool is_driven(const urdf::Joint& joint) {
  return joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS;
}

// The exact link entries that write_urdf left, by joint name.
std::map<std::string, Link> exact_links(const std::string& text) {
  std::map<std::string, Link> links;
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
    links[name] = link;
  }
  return links;
}

bool agree(const Pose& a, const Pose& b) {
  return (a.translation - b.translation).norm() < 1e-9 && (a.rotation - b.rotation).norm() < 1e-9;
}

void copy_joint(const ChainJoint& from, const std::string& file, Link& link) {
  link.name = from.child->name;
  if (from.joint->limits && from.joint->type == urdf::Joint::REVOLUTE) {
    link.min = from.joint->limits->lower;
    link.max = from.joint->limits->upper;
    if (link.min >= link.max)
      throw InputError(
          fmt::format("{}: the joint '{}' has limits from {} to {} rad; upper must be above lower",
                      file, from.joint->name, link.min, link.max));
  }
}

void copy_mass(const ChainJoint& from, int link, const Pose& link_from_urdf, Robot& robot) {
  if (!from.child->inertial || from.child->inertial->mass <= 0) return;
  const urdf::Vector3& c = from.child->inertial->origin.position;
  robot.bodies.push_back(
      {link, from.child->inertial->mass, link_from_urdf * Vector3d(c.x, c.y, c.z)});
}

// Reads world, base_link, A1..A6, spindle and tool in the order of write_urdf.
std::optional<Robot> as_written(const std::vector<ChainJoint>& chain, const std::string& text,
                                const std::string& file) {
  if (chain.size() != kLinks + 2) return std::nullopt;
  const std::map<std::string, Link> exact = exact_links(text);
  Robot robot;
  robot.chain.base = pose_of(chain.front().joint->parent_to_joint_origin_transform);
  robot.chain.tool = pose_of(chain.back().joint->parent_to_joint_origin_transform);
  for (int j = 0; j < kLinks; ++j) {
    const ChainJoint& joint = chain[static_cast<size_t>(j) + 1];
    const auto found = exact.find(joint.joint->name);
    if (found == exact.end() || is_driven(*joint.joint) != (j < kJoints)) return std::nullopt;
    Link& link = robot.chain.links[j];
    link = found->second;
    if (!agree(link_transform(link), pose_of(joint.joint->parent_to_joint_origin_transform)))
      return std::nullopt;  // somebody changed the origin: that counts
    copy_joint(joint, file, link);
    if (j < kJoints) {
      const urdf::Vector3& axis = joint.joint->axis;
      if (axis.x != 0 || axis.y != 0 || axis.z == 0) return std::nullopt;
      link.sign = axis.z < 0 ? -1 : 1;
    }
    copy_mass(joint, j, Pose{}, robot);
  }
  return robot;
}

struct Axis {
  Vector3d point, direction;
};

// The frame on axis `own` whose x is the common normal towards `next`.
Pose frame_towards(const Axis& own, const Axis& next, const Pose& previous) {
  const Vector3d normal = own.direction.cross(next.direction);
  const Vector3d between = next.point - own.point;
  Vector3d x, origin;
  if (normal.norm() > 1e-9) {
    x = normal.normalized();
    // Feet of the common normal.
    const Vector3d across = next.direction.cross(x);
    origin = own.point + own.direction * (between.dot(across) / own.direction.dot(across));
  } else {
    const Vector3d offset = between - own.direction * between.dot(own.direction);
    // Coincident or parallel axes have many normals: take the one through the previous frame.
    x = offset.norm() > 1e-9
            ? Vector3d(offset.normalized())
            : Vector3d((previous.rotation.col(0) -
                        own.direction * own.direction.dot(previous.rotation.col(0)))
                           .normalized());
    origin = own.point + own.direction * own.direction.dot(previous.translation - own.point);
  }
  Pose frame;
  frame.rotation << x, own.direction.cross(x), own.direction;
  frame.translation = origin;
  return frame;
}

// Modified Denavit-Hartenberg parameters between frames whose x_{j-1} is the normal to z_j.
Link link_between(const Pose& previous, const Pose& frame) {
  const Pose relative = inverse(previous) * frame;
  Link link;
  const Vector3d z = relative.rotation.col(2);
  link.alpha = std::atan2(-z.y(), z.z());
  link.d = relative.translation.x();
  link.theta = std::atan2(-relative.rotation(0, 1), relative.rotation(0, 0));
  link.r = relative.translation.dot(z);
  return link;
}

Robot from_axes(const std::vector<ChainJoint>& chain, const std::string& file) {
  std::vector<Axis> axes;
  std::vector<const ChainJoint*> driven;
  std::vector<Pose> urdf_frames;  // of every joint's child link, at zero
  std::vector<int> link_of;       // driven joints before and at each joint
  Pose frame;
  for (const ChainJoint& joint : chain) {
    frame = frame * pose_of(joint.joint->parent_to_joint_origin_transform);
    if (is_driven(*joint.joint)) {
      const urdf::Vector3& a = joint.joint->axis;
      if (a.x == 0 && a.y == 0 && a.z == 0)
        throw InputError(file + ": the joint '" + joint.joint->name +
                         "' has the axis 0 0 0, which points nowhere; correct it");
      axes.push_back({frame.translation, (frame.rotation * Vector3d(a.x, a.y, a.z)).normalized()});
      driven.push_back(&joint);
    } else if (joint.joint->type != urdf::Joint::FIXED) {
      throw InputError(
          file + ": the joint '" + joint.joint->name +
          "' is neither revolute nor fixed; armtrue knows arms of six revolute joints");
    }
    urdf_frames.push_back(frame);
    link_of.push_back(static_cast<int>(driven.size()) - 1);
  }
  if (driven.size() != kJoints)
    throw InputError(file + ": has " + std::to_string(driven.size()) +
                     " revolute joints; armtrue knows arms of six");
  Robot robot;
  // R_0 stands at the foot of the common normal on axis 1, so that link 1 needs no beta.
  const Axis vertical{Vector3d::Zero(), Vector3d::UnitZ()};
  Pose previous = frame_towards(vertical, axes.front(), Pose{});
  robot.chain.base = previous;
  std::vector<Pose> frames;
  for (int j = 0; j < kJoints; ++j) {
    const Pose next = j + 1 < kJoints ? frame_towards(axes[j], axes[j + 1], previous)
                                      : Pose{[&] {
                                               const Vector3d z = axes[j].direction;
                                               Vector3d x = previous.rotation.col(0);
                                               x = (x - z * z.dot(x)).normalized();
                                               Eigen::Matrix3d r;
                                               r << x, z.cross(x), z;
                                               return r;
                                             }(),
                                             axes[j].point};
    Link& link = robot.chain.links[j];
    link = link_between(previous, next);
    copy_joint(*driven[j], file, link);
    frames.push_back(next);
    previous = next;
  }
  robot.chain.links[kLinks - 1].name = "flange";
  robot.chain.tool = inverse(previous) * frame;
  for (size_t k = 0; k < chain.size(); ++k)
    if (link_of[k] >= 0)
      copy_mass(chain[k], link_of[k], inverse(frames[link_of[k]]) * urdf_frames[k], robot);
  return robot;
}

}  // namespace

std::string write_urdf(const Robot& robot) {
  std::string xml = "<?xml version=\"1.0\"?>\n<robot name=\"" + attribute(robot.name) + "\">\n";
  xml += link_xml("world") + link_xml("base_link");
  for (int j = 0; j < kLinks; ++j)
    xml += link_xml(robot.chain.links[j].name, inertial_xml(robot, j));
  xml += link_xml("tool");
  xml += fixed_joint_xml("base", "world", "base_link", robot.chain.base);
  std::string parent = "base_link";
  for (int j = 0; j < kLinks; ++j) {
    const Link& link = robot.chain.links[j];
    xml += j < kJoints ? revolute_joint_xml(link, parent)
                       : fixed_joint_xml("joint_" + link.name, parent, link.name,
                                         link_transform(link), link_attributes(link));
    parent = link.name;
  }
  xml += fixed_joint_xml("tool_mount", parent, "tool", robot.chain.tool);
  return xml + "</robot>\n";
}

std::vector<std::string> lost_in_urdf(const Robot& robot) {
  std::vector<std::string> lost;
  if (!robot.sessions.empty()) lost.emplace_back("sessions");
  if (!robot.chain.targets.empty()) lost.emplace_back("targets");
  if (!robot.chain.anchors.empty()) lost.emplace_back("anchors");
  if (robot.gravity != Vector3d(0, 0, -9.81)) lost.emplace_back("gravity_m_s2");
  if (robot.identify != std::vector<std::string>{"auto"}) lost.emplace_back("identify");
  if (!robot.identify_per_session.empty()) lost.emplace_back("identify_per_session");
  if (robot.noise.position > 0 || robot.noise.orientation > 0) lost.emplace_back("noise");
  if (!robot.priors.empty()) lost.emplace_back("priors");
  if (!robot.std.empty()) lost.emplace_back("std");
  if (!robot.effects.empty()) lost.emplace_back("effects");
  return lost;
}

Robot parse_urdf(const std::string& text, const std::string& file) {
  check_masses(text, file);
  const urdf::ModelInterfaceSharedPtr model = parse_strictly(text, file);
  const std::vector<ChainJoint> chain = serial_chain(*model, file);
  std::optional<Robot> written = as_written(chain, text, file);
  Robot robot = written ? std::move(*written) : from_axes(chain, file);
  robot.name = model->getName();
  return robot;
}

}  // namespace armtrue
