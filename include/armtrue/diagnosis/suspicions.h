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
/// poses are left out. Warnings, the likeliest one: after some row, or in a session, the frame, the
/// tool, the zero of a joint, a constant of the instrument, or the place of a camera or a board is
/// another; the instrument adds a length to all distances; the distances from one anchor have
/// another scale than the others; all links become longer or shorter by one factor; the depth of a
/// camera has another scale than its width; the joint angles were not read at standstill; they are
/// rounded; a link changes by more than arms are made to. Empty if the readings are too few for a calibration, or of more than
/// 16 sessions.
Findings find_suspicions(const Robot& robot, const Campaign& campaign);

/// A change among the readings that explains what a fit leaves: of those of find_suspicions(), what
/// is another one after some row or in a session, a constant of the instrument's range, or the
/// scale of one anchor. An effect that the fit contains explains it no more. Nothing if none
/// explains enough of the residual, or the readings are of more than 16 sessions. `campaign`: that
/// of the fit.
std::optional<std::string> explanation_of_rest(const CalibrationResult& fit,
                                               const Campaign& campaign);

/// Whether a robot file is the result of a calibration: it states standard deviations or an
/// uncertainty.
bool is_calibrated(const Robot& robot);

/// Says that the points are not measured but computed: a nominal robot file, with base and tool
/// placed, predicts them to 0.01 mm (median), as no arm is made, or a calibrated one to a tenth of
/// the noise that it states (0.01 mm at most, 0.001 mm if it states none), as no instrument reads.
/// So does an export of the positions that the controller shows in place of those of the
/// instrument. Nothing for fewer than ten poses, for distances and for touches.
std::optional<std::string> find_computed_points(const Robot& robot, const Campaign& campaign);

/// Says that the orientations of measured points are not measured but computed from the joint
/// angles: the robot file, or a model with other angles, gives them closer than instruments read.
/// To 0.01 mrad that is enough, if the points have noise and the orientations are rounded, as those
/// of a simulation without noise are not. Otherwise the points must contradict them: beside them an
/// arm that is calibrated to both scatters twice as much or more. The frame of the orientations
/// does not matter, nor does the tool. Nothing for fewer than twenty poses of a session.
std::optional<std::string> find_computed_orientations(const Robot& robot, const Campaign& campaign);

/// Makes points of poses: removes the orientations and what rows state of their noise.
void leave_out_orientations(Campaign& campaign);

/// Says that the robot file needs no calibration, as no arm is made: with base and tool placed,
/// its points differ from those of a calibrated arm by no more than noise does, and by less than
/// 0.02 mm for each metre of the arm. So does a file of an arm whose controller corrects its poses
/// by a model of its own, while the joint angles are those of the uncorrected one. Nothing for a
/// robot file that is the result of a calibration, and for distances and touches.
std::optional<std::string> find_needless_calibration(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
