#pragma once

#include <string>
#include <vector>

#include "armtrue/planning/pose_cloud.h"
#include "armtrue/tracing/tracing.h"

namespace armtrue {

/// Two members of a class that a campaign cannot tell apart, one of them taken to be the truth.
struct SeparatedPair {
  Effect truth;  ///< as large as it would have to be to show what the found effect shows
  Effect rival;  ///< fitted to it, with the geometry and all other effects
  std::vector<std::string> readings;  ///< that would tell them where poses do not, in words
  /// False: poses do not tell them. Not even all candidates of the cloud together would reject the
  /// rival in half of the campaigns.
  bool by_poses = true;
  /// Probability that the rival is rejected at 5 % if the truth is the truth: with the given poses
  /// alone, with the planned ones and with as many random ones (mean of some designs) besides.
  double power_given = 0, power_planned = 0, power_random = 0;
};

struct SeparationPlan {
  std::vector<JointVector> poses;  ///< to be visited in this order; empty if no pair is by_poses
  std::vector<SeparatedPair> pairs;
  /// Per axis, that the power is for: the spread of the given readings about the model with what
  /// was found, at least the robot's; the cloud's where too few are given to show it.
  ReadingSigma noise;
};

/// Chooses `count` poses, at most kCloudSize, that best tell apart an effect that was found and
/// those this campaign cannot tell from it.
///
/// What counts of a pair is what is left of the truth, in standard deviations, when geometry, other
/// effects and rival are fitted to it: T-optimality (Atkinson and Fedorov, "The design of
/// experiments for discriminating between two rival models", Biometrika 62, 1975). The smallest
/// over all ordered pairs that poses can tell is made largest, by exchange over the cloud. Its
/// square is the noncentrality of the chi-square with as many degrees of freedom as the truth has
/// independent coefficients by which the likelihood ratio rejects the rival.
///
/// `found` may hold several classes; effects without rivals are fitted along. Readings count as
/// independent. Every planned pose is read once (each target), after the given ones, at their pace,
/// under the load, temperature and motor torques of the last. Of several sessions all count, each
/// with a base of its own; the planned poses continue the last. Throws std::invalid_argument as
/// pose_cloud() does, if an effect is driven by what the given poses do not hold, or its
/// coefficients are not those that this robot needs.
SeparationPlan plan_separation(const Robot& robot, const std::vector<TracedEffect>& found,
                               int count, const CloudOptions& options, const Campaign& given = {});

}  // namespace armtrue
