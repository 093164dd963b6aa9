#include "armtrue/effects/catalogue.h"

#include "armtrue/kinematics/joint_names.h"

namespace armtrue {
namespace {

// "target" and "anchor.zero" stand for each target and each anchor; others for themselves.
std::vector<std::string> named(const std::string& parameter, const KinematicChain& chain) {
  std::vector<std::string> names;
  if (parameter == "target")
    for (const Target& target : chain.targets) names.push_back("target " + target.name);
  else if (parameter.starts_with("anchor."))
    for (const Anchor& anchor : chain.anchors)
      names.push_back("anchor " + anchor.name + parameter.substr(parameter.find('.')));
  else
    names.push_back(parameter);
  return names;
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
    return number < static_cast<int>(of_arm.size()) ? of_arm[static_cast<size_t>(number)] : -1;
  };
  const auto add = [&](const std::string& parameter, int joint) {
    Effect effect{entry.name, parameter, entry.driver, entry.shape, {}};
    if (!entry.family.empty()) effect.family = Family{entry.family, entry.typical};
    int& of_driver = effect.driver.factor && effect.driver.joint < 0 ? effect.driver.second_joint
                                                                     : effect.driver.joint;
    if (entry.driver_joint == CatalogueEntry::Joint::own) of_driver = joint;
    if (entry.driver_joint == CatalogueEntry::Joint::previous) of_driver = joint - 1;
    if (entry.driver_joint == CatalogueEntry::Joint::fixed) {
      of_driver = in_chain(of_driver);
      if (effect.driver.second_joint >= 0 && &of_driver != &effect.driver.second_joint &&
          (effect.driver.second_joint = in_chain(effect.driver.second_joint)) < 0)
        return;
    }
    const bool needs_joint = entry.driver_joint != CatalogueEntry::Joint::none;
    if (needs_joint && of_driver < 0) return;
    // A travel has no cycles per turn, because its pitch is not stated.
    if (effect.shape.kind == ShapeKind::harmonic && is_travel(effect.driver, robot.chain)) return;
    effects.push_back(std::move(effect));
  };
  // An effect on theta of a revolute joint acts on r of a prismatic one.
  const auto of_joint = [&](int joint) {
    const Link& link = joint_link(robot.chain, joint);
    return link.name + "." +
           (entry.parameter == "theta" && is_prismatic(link) ? "r" : entry.parameter);
  };
  if (entry.of_every_joint)
    for (int joint = 0; joint < joints; ++joint) add(of_joint(joint), joint);
  else if (entry.joints.empty())
    for (const std::string& parameter : named(entry.parameter, robot.chain)) add(parameter, -1);
  for (int number : entry.joints)
    if (const int joint = in_chain(number); joint >= 0) add(of_joint(joint), joint);
  return effects;
}

}  // namespace armtrue
