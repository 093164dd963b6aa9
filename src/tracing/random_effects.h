#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/search/effect_groups.h"
#include "armtrue/tracing/loop.h"

namespace armtrue {

/// Random effects are worth to be applied from this gain on: odds of 3000 to 1.
inline constexpr double kMinGain = 16;

/// The random numbers u behind random effects, given the readings: normal about their mean.
struct RandomNumbers {
  /// Where the coefficients of an effect come from: root * u.segment(first, root.cols()).
  struct Part {
    Eigen::Index first = 0;
    Eigen::MatrixXd root;
    /// Numbers of which the readings say nothing are taken as zero: the coefficients are uncertain
    /// by silent * N(0, I) besides.
    Eigen::MatrixXd silent;
  };

  Eigen::MatrixXd precision;     ///< of u, p x p
  std::vector<Part> of_lasting;  ///< of each lasting effect
  /// d b / d u: by how much the unknowns b of the fit follow u, unknowns x p.
  Eigen::MatrixXd of_unknowns;
};

/// What an arm and its station do beside a fit, without a name: the posterior mean of the effects
/// of effect_groups(), each called `kRemainder`.
struct RandomEffects {
  /// What the arm does, or the instrument errs, at a pose, whatever went before.
  std::vector<Effect> lasting;
  /// What follows time, an arrival or a temperature: it is of this campaign alone.
  std::vector<Effect> of_campaign;
  RandomNumbers numbers;
  std::vector<GroupShare> groups;
  double determined = 0;  ///< how many of their numbers the readings determine
  double gain = 0;      ///< twice the rise of the restricted log likelihood over no such effect
  double evidence = 0;  ///< twice the log likelihood; of fits with one law of readings comparable
};

/// A linear mixed model r = X b + Z u + e (Henderson 1975): X the unknowns of the fit with their
/// priors, Z u the random effects in their groups, e the noise of readings, which all readings of a
/// pose share in part: each joint comes to a pose with an error of its own. The variances are
/// those of the highest restricted likelihood. Without an effect if that rises by less than 8.
/// `law`: the fit whose weights and noise count; its campaign is that of `fit`.
RandomEffects random_effects(const CalibrationResult& fit, const Campaign& campaign,
                             const std::vector<EffectGroup>& groups, const CalibrationResult& law);

/// The fit with these effects behind its own, as they are, and all else fitted again. What the
/// readings determine of them counts among the numbers that it determines.
CalibrationResult beside(const CalibrationResult& fit, const Campaign& campaign,
                         const RandomEffects& random);

/// The campaign with the order of its visits as time, if it has no time.
Campaign in_order_of_visits(Campaign campaign);

}  // namespace armtrue
