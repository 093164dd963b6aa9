#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/catalogue.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// One effect among the random effects of an arm or a station. Its coefficients are c = root * u
/// with u ~ N(0, tau^2) of its group: with tau = 1 it moves its parameter by a usual size.
struct RandomEffect {
  Effect effect;         ///< without coefficients
  Eigen::MatrixXd root;  ///< coefficients x random numbers u [SI]
};

/// Random effects with one variance.
struct EffectGroup {
  enum class Owner { arm, station };

  std::string name;  ///< in words: "gravity", "curves of the joints"
  Owner owner = Owner::arm;
  double log_spread = 1;  ///< of the usual sizes: ln tau ~ N(0, log_spread^2)
  std::vector<RandomEffect> effects;
};

/// What an arm and a station can do without a name, in groups. `campaign`: of the effects only
/// those that its columns drive.
std::vector<EffectGroup> effect_groups(const Robot& robot, const Campaign& campaign);

/// The lasting errors of the instrument that the catalogue knows (see is_lasting_of_instrument), of
/// the station, and a strain of the space in which it measures: none of the groups above, because a
/// distortion of space could take the place of most of them. Empty if the catalogue has none.
std::vector<EffectGroup> errors_of_instrument(const Robot& robot, const Campaign& campaign,
                                              const Catalogue& catalogue);

}  // namespace armtrue
