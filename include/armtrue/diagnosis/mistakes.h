#pragma once

#include <optional>
#include <string>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/diagnosis/log_check.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// All checks for mistakes before readings are used: check_travel(), diagnose(), find_suspicions(),
/// scattered_poses(). The first error ends the check, because it causes others: Findings::errors
/// has at most one sentence. The diagnosis calibrates the robot.
Findings find_mistakes(const Robot& robot, const Campaign& campaign);

/// Why a mean position error of a calibrated arm [m] cannot be an error of an arm; empty if it can.
/// `noise`: of a coordinate [m].
std::string beyond_any_arm(const Robot& robot, double error, double noise);
/// The same for the errors of the robot on the readings of a campaign.
std::string beyond_any_arm(const Robot& robot, const Campaign& campaign,
                           const Evaluation& evaluation);
/// The same without the rows of blunders (ascending), unless they are more than kMaxBlunders.
std::string beyond_any_arm(const Robot& robot, const Campaign& campaign,
                           const Evaluation& evaluation, const std::vector<int>& blunders);
/// The same for a robot whose file may be nominal: a nominal one may err by up to kImplausibleMiss.
/// `given`: the robot of the file; `robot`: as fitted and evaluated.
std::string beyond_arm(const Robot& given, const Robot& robot, const Campaign& campaign,
                       const Evaluation& evaluation);

/// A reading that stands in two campaigns, by its row in each.
struct SharedReading {
  int training, test;
};
/// The first reading of `test` whose joint angles and numbers are those of one of `training`: a
/// model that was fitted to it is not tested by it. Where a row is one number (distance, pixel,
/// ...), some are alike by chance: then more than half of the rows of a pose must be, and more
/// poses than chance makes.
std::optional<SharedReading> shared_reading(const Campaign& training, const Campaign& test);

/// A sentence with file, line and remedy if a reading stands in both; else empty.
std::string why_not_apart(const Campaign& training, const Campaign& test);

/// Poses of a test at the joint values of training poses, to 0.1 deg or 1.7 mm, whatever their
/// names. They are repeats: their readings share the errors of the arm there, and say nothing of
/// unseen poses.
struct RepeatedPoses {
  int repeated = 0, of = 0;
  std::string test, training;  ///< names of the first
};
RepeatedPoses repeated_poses(const Campaign& training, const Campaign& test);
/// A sentence with remedy if there are repeated_poses(); else empty.
std::string repeats_in_words(const Campaign& training, const Campaign& test);

}  // namespace armtrue
