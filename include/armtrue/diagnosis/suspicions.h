#pragma once

#include "armtrue/campaign/campaign.h"
#include "armtrue/diagnosis/log_check.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Mistakes in the readings of one set-up that a calibration of the geometry shows. Errors: a link
/// changes by more than the error of any real arm, however small the residuals are and whether or
/// not gross poses are left out. Warnings: after some row the readings are in another frame, or the
/// tool is another; the distances from one anchor have another scale than the others; all links
/// become longer or shorter by one factor; the joint angles are rounded. Empty if the campaign or
/// the robot has several sessions.
LogFindings find_suspicions(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
