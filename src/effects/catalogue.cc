#include "armtrue/effects/catalogue.h"

#include "armtrue/kinematics/joint_names.h"

namespace armtrue {
namespace {

// The parameters of each target, anchor or contact that a parameter of a catalogue stands for; any
// other parameter alone.
std::vector<Parameter> of_each(const Parameter& parameter, const KinematicChain& chain) {
  if (!parameter.of_each) return {parameter};
  std::vector<Parameter> all;
  const auto add = [&](const auto& owners) {
    for (const auto& owner : owners)
      all.emplace_back(parameter.owner, owner.name, parameter.component);
  };
  if (parameter.owner == Owner::target) add(chain.targets);
  if (parameter.owner == Owner::anchor) add(chain.anchors);
  if (parameter.owner == Owner::contact) add(chain.contacts);
  return all;
}

// The joints that are no external axes.
std::vector<int> joints_of_arm(const KinematicChain& chain) {
  std::vector<int> joints;
  int joint = 0;
  for (const JointName& name : joint_names(chain)) {
    if (!name.is_external()) joints.push_back(joint);
    ++joint;
  }
  return joints;
}

}  // namespace

std::vector<Effect> expand(const CatalogueEntry& entry, const Robot& robot) {
  std::vector<Effect> effects;
  const std::vector<int> of_arm = joints_of_arm(robot.chain);
  const int joints = joint_count(robot.chain);
  // A number in the catalogue counts the joints of the arm.
  const auto in_chain = [&](int number) {
    return number < std::ssize(of_arm) ? of_arm[number] : -1;
  };
  const std::vector<JointName> axes = joint_names(robot.chain);
  // Puts the name of a joint in the place of a letter; false if there is no such joint.
  const auto put = [&](std::string& text, const char* letter, int joint) {
    const size_t at = text.find(letter);
    if (at == std::string::npos) return true;
    if (joint < 0 || joint >= joints) return false;
    text.replace(at, 3, axes[joint].axis);
    return true;
  };
  const auto add = [&](const Parameter& parameter, int joint) {
    Effect effect{entry.name, parameter, entry.driver, entry.shape, {}};
    int& of_driver = effect.driver.factor && effect.driver.joint < 0 ? effect.driver.second_joint
                                                                     : effect.driver.joint;
    if (entry.driver_joint == CatalogueEntry::Joint::own) of_driver = joint;
    if (entry.driver_joint == CatalogueEntry::Joint::previous) of_driver = joint - 1;
    if (entry.driver_joint == CatalogueEntry::Joint::next)
      of_driver = joint + 1 < joints ? joint + 1 : -1;
    if (entry.driver_joint == CatalogueEntry::Joint::fixed) {
      of_driver = in_chain(of_driver);
      if (effect.driver.second_joint >= 0 && &of_driver != &effect.driver.second_joint &&
          (effect.driver.second_joint = in_chain(effect.driver.second_joint)) < 0)
        return;
    }
    const bool needs_joint = entry.driver_joint != CatalogueEntry::Joint::none;
    if (needs_joint && of_driver < 0) return;
    if (std::string family = entry.family; !family.empty()) {
      if (!put(family, "{j}", joint) || !put(family, "{k}", of_driver) ||
          !put(family, "{n}", joint < 0 ? -1 : joint + 1))
        return;
      effect.family = Family{family, entry.typical};
    }
    // A travel has no cycles per turn, because its pitch is not stated.
    if (effect.shape.kind == ShapeKind::harmonic && is_travel(effect.driver, robot.chain)) return;
    effects.push_back(std::move(effect));
  };
  // An effect on theta of a revolute joint acts on r of a prismatic one.
  const auto of_joint = [&](int joint) {
    const Link& link = joint_link(robot.chain, joint);
    const bool slides =
        is_link_parameter(entry.parameter, LinkParameter::theta) && is_prismatic(link);
    return Parameter(Owner::link, link.name,
                     slides ? static_cast<int>(LinkParameter::r) : entry.parameter.component);
  };
  if (entry.of_every_joint)
    for (int joint = 0; joint < joints; ++joint) add(of_joint(joint), joint);
  else if (entry.joints.empty())
    for (const Parameter& parameter : of_each(entry.parameter, robot.chain)) add(parameter, -1);
  for (int number : entry.joints)
    if (const int joint = in_chain(number); joint >= 0) add(of_joint(joint), joint);
  return effects;
}

}  // namespace armtrue
