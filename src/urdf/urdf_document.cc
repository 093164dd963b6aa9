#include "urdf/urdf_document.h"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>

#include "armtrue/text/input_error.h"
#include "armtrue/text/xml_tags.h"
#include "urdf/xml_bounds.h"

namespace armtrue {
namespace {

constexpr size_t kMaxJointsOfFile = 2000;  // a whole cell; the search of the chain is recursive

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

// urdfdom accepts a link with two parents. It leaves out links in a cycle and leaks their memory.
// So this check comes before urdfdom.
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
                     ": is no valid URDF: the element cannot be read; correct it (urdfdom says \"" + first + "\")");
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
  for (std::optional<XmlTag> tag = next_tag(text, 0); tag; tag = next_tag(text, tag->end)) {
    const std::string_view own = std::string_view(text).substr(tag->begin, tag->end - tag->begin);
    const bool is_macro =
        tag->name.starts_with("xacro:") || own.find("${") != own.npos || own.find("$(") != own.npos;
    if (!is_macro) continue;
    throw InputError(fmt::format(
        "{0}:{1}: contains xacro macros that are not expanded; write 'xacro {0} > robot.urdf' and "
        "take robot.urdf",
        file, 1 + std::count(text.begin(), text.begin() + tag->begin, '\n')));
  }
}

}  // namespace

UrdfDocument::UrdfDocument(const std::string& text, const std::string& file) : file_(file) {
  check_xml_bounds(text, file);
  refuse_xacro(text, file);
  document_.Parse(text.c_str());
  const TiXmlElement* const robot = document_.FirstChildElement("robot");
  if (robot) {
    require_tree(*robot, file);
    check_masses(*robot, file);
  }
  model_ = parse_strictly(text, robot, file);
}

std::string UrdfDocument::place_of_joint(const std::string& joint) const {
  return place_in(document_.FirstChildElement("robot"), file_,
                  [&](const TiXmlElement& one, const std::string& name) {
                    return one.ValueStr() == "joint" && name == joint;
                  });
}

}  // namespace armtrue
