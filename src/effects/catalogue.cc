#include "armtrue/effects/catalogue.h"

namespace armtrue {

std::vector<Effect> expand(const CatalogueEntry& entry, const Robot& robot) {
  std::vector<Effect> effects;
  const auto add = [&](const std::string& parameter, int joint) {
    Effect effect{entry.name, parameter, entry.driver, entry.shape, {}};
    if (!entry.family.empty()) effect.family = Family{entry.family, entry.typical};
    if (entry.driver_joint == CatalogueEntry::Joint::own) effect.driver.joint = joint;
    if (entry.driver_joint == CatalogueEntry::Joint::previous) effect.driver.joint = joint - 1;
    const bool needs_joint = entry.driver_joint != CatalogueEntry::Joint::none;
    if (!needs_joint || effect.driver.joint >= 0) effects.push_back(std::move(effect));
  };
  if (entry.joints.empty()) add(entry.parameter, -1);
  for (int joint : entry.joints) add(robot.chain.links[joint].name + "." + entry.parameter, joint);
  return effects;
}

}  // namespace armtrue
