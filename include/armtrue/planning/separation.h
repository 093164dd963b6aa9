#pragma once

#include <string>
#include <vector>

#include "armtrue/planning/pose_cloud.h"
#include "armtrue/search/trace.h"

namespace armtrue {

/// Two effects that a campaign cannot separate. `truth` is assumed to be the true one.
struct SeparatedPair {
  Effect truth;  ///< of the size at which it explains what the found effect explains
  Effect rival;  ///< fitted to the readings of `truth`, with the geometry and all other effects
  std::vector<std::string> readings;  ///< in words: readings that would separate them if poses
                                      ///< cannot
  /// Whether poses can separate them: with all candidates of the cloud the power is above 0.5.
  bool by_poses = true;
  /// Power: probability that the rival is rejected at 5 % if `truth` is true. With the given poses
  /// alone, with the planned poses added, and with as many random poses added (mean of designs).
  double power_given = 0, power_planned = 0, power_random = 0;
};

/// The result of plan_separation().
struct SeparationPlan {
  std::vector<PlannedPose> poses;  ///< to be visited in this order; empty if no pair is by_poses
  std::vector<SeparatedPair> pairs;
  /// Noise per axis for which the power is computed: the spread of the given readings about the
  /// model with the found effects, at least the noise of the robot file. That of the cloud if too
  /// few readings are given.
  ReadingSigma noise;
};

/// Chooses `count` poses, at most kCloudSize, that best separate a found effect from those that
/// this campaign cannot distinguish from it.
///
/// T-optimality (Atkinson and Fedorov, "The design of experiments for discriminating between two
/// rival models", Biometrika 62, 1975). For a pair,
///     lambda = min over x of |y_truth - A x|^2,
/// y_truth: whitened readings of the truth; A: whitened columns of geometry, other effects and
/// rival. The exchange search over the cloud maximises the smallest lambda of all ordered pairs
/// that poses can separate. The likelihood ratio then rejects the rival with the power
///     P(chi'^2(k, lambda) > chi^2_0.95(k)),
/// chi'^2: non-central chi-square; k: independent coefficients of the truth.
///
/// `found` may hold several classes; effects without rivals are fitted too. Readings are taken as
/// independent. Every planned pose is read once (each target), after the given ones, with the same
/// time between visits, and with the load, temperature and motor torques of the last given pose.
/// All sessions count, each with its own base; the planned poses continue the last. Throws
/// std::invalid_argument as pose_cloud() does, if the given poses lack the driver of an effect, or
/// if the coefficients of an effect are not those that this robot needs.
SeparationPlan plan_separation(const Robot& robot, const std::vector<TracedEffect>& found,
                               int count, const CloudOptions& options, const Campaign& given = {});

/// A sentence for each set of effects that no poses separate, with the readings that do. A set
/// starts from a pair and takes in every effect that no poses separate from any of its members.
std::vector<std::string> inseparable_in_words(const SeparationPlan& plan);

}  // namespace armtrue
