#pragma once

#include <optional>
#include <string>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/diagnosis/log_check.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Mistakes in the readings that a calibration of the geometry shows. Errors: a link changes by
/// more than the error of any real arm, however small the residuals are and whether or not gross
/// poses are left out. Either, if it explains nearly all: joints move with others, as by the gears
/// of a wrist, which the robot file does not say. Warnings, the likeliest one: after some row, or
/// in a session, the frame, the tool, the zero of a joint, a constant of the instrument, or the
/// place of a camera or a board changes; the instrument adds a length to all distances; the
/// distances from one anchor have another scale than the others; all links become longer or shorter
/// by one factor; the depth of a camera has another scale than its width; gravity has another
/// direction than in the robot file; the joint angles were not read at standstill; joint angles or
/// readings are rounded; a link changes by more than the tolerances of arms. Empty if the readings
/// are too few for a calibration, or of more than 16 sessions.
Findings find_suspicions(const Robot& robot, const Campaign& campaign);

/// A change among the readings that explains the residual of a fit: one of those that
/// find_suspicions() looks for after some row or in a session, a constant of the instrument's
/// range, or the scale of one anchor. Effects that the fit contains are taken off first. Nothing if
/// none explains enough of the residual, or the readings are of more than 16 sessions. `campaign`:
/// that of the fit.
std::optional<std::string> explanation_of_rest(const CalibrationResult& fit,
                                               const Campaign& campaign);

/// Whether a robot file is the result of a calibration: it states standard deviations or an
/// uncertainty.
bool is_calibrated(const Robot& robot);

/// Says that the points are not measured but computed: a nominal robot file, with base and tool
/// placed, predicts them to 0.01 mm (median), closer than arms are made, or a calibrated one to a
/// tenth of its stated noise (0.01 mm at most, 0.001 mm if it states none), closer than instruments
/// read. The likely cause is an export of the controller's positions in place of the instrument's.
/// Nothing for fewer than ten poses, for distances and for touches.
std::optional<std::string> find_computed_points(const Robot& robot, const Campaign& campaign);

/// Says that the orientations of measured points are not measured but computed from the joint
/// angles: the robot file, or a model with other angles, gives them closer than instruments read.
/// If closer than 0.01 mrad, that is enough where the points have noise and the orientations are
/// rounded, unlike those of a simulation without noise. Otherwise the points must contradict them:
/// about an arm calibrated to both, the points scatter at least twice as much. The frame of the
/// orientations does not matter, nor does the tool. Nothing for fewer than twenty poses of a
/// session. Where a part of the rows is computed, twenty poses or more, those of the robot file
/// alone are found: the others then lie at least five times as far from it, and their points do
/// not.
std::optional<std::string> find_computed_orientations(const Robot& robot, const Campaign& campaign);

/// Removes the orientations, and what rows state of their noise: poses become points.
void leave_out_orientations(Campaign& campaign);

/// Says that the robot file is more exact than arms are made: with base and tool placed, its points
/// differ from those of a calibrated arm by no more than noise does, and by less than 0.02 mm for
/// each metre of the arm. The likely cause is a controller that corrects poses by its own model,
/// and joint angles from before this correction. Nothing for a robot file that is the result of a
/// calibration, and for distances and touches.
std::optional<std::string> find_needless_calibration(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
