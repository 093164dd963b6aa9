#include "armtrue/effects/catalogue.h"

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

}  // namespace

std::vector<Effect> expand(const CatalogueEntry& entry, const Robot& robot) {
  std::vector<Effect> effects;
  const auto add = [&](const std::string& parameter, int joint) {
    Effect effect{entry.name, parameter, entry.driver, entry.shape, {}};
    if (!entry.family.empty()) effect.family = Family{entry.family, entry.typical};
    int& of_driver = effect.driver.factor && effect.driver.joint < 0 ? effect.driver.second_joint
                                                                     : effect.driver.joint;
    if (entry.driver_joint == CatalogueEntry::Joint::own) of_driver = joint;
    if (entry.driver_joint == CatalogueEntry::Joint::previous) of_driver = joint - 1;
    const bool needs_joint = entry.driver_joint != CatalogueEntry::Joint::none;
    if (!needs_joint || of_driver >= 0) effects.push_back(std::move(effect));
  };
  if (entry.joints.empty())
    for (const std::string& parameter : named(entry.parameter, robot.chain)) add(parameter, -1);
  for (int joint : entry.joints) add(robot.chain.links[joint].name + "." + entry.parameter, joint);
  return effects;
}

}  // namespace armtrue
