#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/catalogue.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// A random effect of an arm or a station. Its coefficients are c = root * u with u ~ N(0, tau^2
/// I), tau that of its group: with tau = 1 it moves its parameter by a usual size.
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

/// The random effects of an arm and a station, in groups: what they do without a known cause. Only
/// effects that the columns of `campaign` drive.
std::vector<EffectGroup> effect_groups(const Robot& robot, const Campaign& campaign);

/// A group of the campaign: each of these parameters walks at random in time. Empty if the campaign
/// has no time.
EffectGroup random_walk(const Robot& robot, const Campaign& campaign,
                        const std::vector<Parameter>& parameters);

/// Groups of the station: the lasting errors of the instrument that the catalogue knows (see
/// is_lasting_of_instrument), and a strain of the space in which it measures. They are not in
/// effect_groups(), because a distortion of space could imitate most of those. Empty if the
/// catalogue has none.
std::vector<EffectGroup> errors_of_instrument(const Robot& robot, const Campaign& campaign,
                                              const Catalogue& catalogue);

}  // namespace armtrue
