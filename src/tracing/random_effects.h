#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/search/effect_groups.h"
#include "armtrue/tracing/loop.h"

namespace armtrue {

/// Random effects are applied from this gain on: odds of 3000 to 1.
inline constexpr double kMinGain = 16;

/// Posterior of the random numbers u of the random effects, about its mean.
struct RandomNumbers {
  /// The coefficients of an effect: root * u.segment(first, root.cols()).
  struct Part {
    Eigen::Index first = 0;
    Eigen::MatrixXd root;
    /// Numbers that the readings do not determine are zero in `root`; they add silent * N(0, I) to
    /// the coefficients.
    Eigen::MatrixXd silent;
  };

  Eigen::MatrixXd precision;     ///< of u, p x p
  std::vector<Part> of_lasting;  ///< of each lasting effect
  /// d b / d u: derivatives of the unknowns b of the fit by u, unknowns x p.
  Eigen::MatrixXd of_unknowns;
};

/// Random effects of an arm and its station beside a fit: the posterior mean of the effects of
/// effect_groups(), each named kRemainder.
struct RandomEffects {
  /// Effects of the arm or the instrument that the pose alone determines.
  std::vector<Effect> lasting;
  /// Effects of time, arrival or temperature: they belong to this campaign alone.
  std::vector<Effect> of_campaign;
  RandomNumbers numbers;
  std::vector<GroupShare> groups;
  bool joints_err = false;  ///< from pose to pose more than the readings of a pose differ
  double determined = 0;  ///< number of random numbers that the readings determine
  double gain = 0;      ///< twice the rise of the restricted log likelihood over no such effect
  double evidence = 0;  ///< twice the log likelihood; of fits with one law of readings comparable
};

/// A linear mixed model r = X b + Z u + e (Henderson 1975): X the unknowns of the fit with their
/// priors, Z u the random effects in their groups, e the noise of readings and, common to the
/// readings of a pose, an error of each joint. The variances are
/// those of the highest restricted likelihood. No effects if that rises by less than 8. `law`: the
/// fit whose weights and noise count; its campaign is that of `fit`.
RandomEffects random_effects(const CalibrationResult& fit, const Campaign& campaign,
                             const std::vector<EffectGroup>& groups, const CalibrationResult& law);

/// The fit with these effects fixed after its own, and all else refitted. RandomEffects::determined
/// is added to its determined numbers.
CalibrationResult beside(const CalibrationResult& fit, const Campaign& campaign,
                         const RandomEffects& random);

/// The campaign with the order of its visits as time, if it has no time.
Campaign in_order_of_visits(Campaign campaign);

}  // namespace armtrue
