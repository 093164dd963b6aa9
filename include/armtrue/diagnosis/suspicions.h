#pragma once

#include "armtrue/campaign/campaign.h"
#include "armtrue/diagnosis/log_check.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// What a calibration of the geometry shows of the readings of one set-up. Errors: a link would
/// change by more than an arm can be off, with whatever small error. Warnings: from some place on the
/// readings lie in another frame; the distances from one anchor have another scale than the others;
/// all links come out longer or shorter by one factor. Nothing if the campaign or the robot has
/// several sessions.
LogFindings find_suspicions(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
