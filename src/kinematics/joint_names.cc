#include "armtrue/kinematics/joint_names.h"

#include <string_view>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

// "E1" to "E6".
bool is_external(std::string_view name) {
  return name.size() == 2 && name[0] == 'E' && name[1] >= '1' && name[1] <= '6';
}

std::string_view number_at_end(std::string_view name) {
  const size_t before = name.find_last_not_of("0123456789");
  return before == std::string_view::npos ? name : name.substr(before + 1);
}

}  // namespace

double JointName::si() const { return is_length ? kMillimetre : kDegree; }

std::vector<JointName> joint_names(const KinematicChain& chain) {
  std::vector<JointName> names;
  int of_arm = 0;
  for (const Link& link : chain.links) {
    if (!is_driven(link)) continue;
    JointName& name = names.emplace_back();
    const bool external = is_external(link.name);
    name.axis = external ? link.name : std::to_string(++of_arm);
    name.column = external ? "e" + link.name.substr(1) : "q" + name.axis;
    name.is_length = is_prismatic(link);
    const bool says_number = external || link.name.empty() || number_at_end(link.name) == name.axis;
    name.words = says_number ? name.axis : name.axis + " (" + link.name + ")";
  }
  return names;
}

const std::vector<JointName>& six_axis_names() {
  static const std::vector<JointName> names = [] {
    KinematicChain arm;
    arm.links = six_axis_links();
    return joint_names(arm);
  }();
  return names;
}

std::string encoder_columns(const KinematicChain& chain) {
  const std::vector<JointName> names = joint_names(chain);
  // A run of joints of the arm with one unit is named by its ends.
  const auto continues = [&](size_t k) {
    return k + 1 < names.size() && names[k].column[0] == 'q' && names[k + 1].column[0] == 'q' &&
           names[k].is_length == names[k + 1].is_length;
  };
  std::string text;
  for (size_t k = 0; k < names.size(); ++k) {
    text += (text.empty() ? "" : ", ") + names[k].encoder();
    if (!continues(k)) continue;
    while (continues(k)) ++k;
    text += " to " + names[k].encoder();
  }
  return text;
}

}  // namespace armtrue
