#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/diagnosis/sensor_field.h"
#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/joint_names.h"

namespace armtrue {

/// Mistakes in readings, as sentences with numbers and remedies.
struct Findings {
  std::vector<std::string> errors;    ///< proven
  std::vector<std::string> warnings;  ///< likely
  std::string other_arm;   ///< the warning that the robot file may be of another arm; else empty
  bool of_change = false;  ///< a warning is of a change among the readings
  /// The warning of an error of the readings that the arm takes up, so that it may be worse than
  /// the nominal one: all lengths come out wrong alike, as by a wrong scale of the instrument or of
  /// an artefact, or SensorError::is_left. Else empty.
  std::string wrong_readings;
  std::string early_angles;  ///< the warning of find_early_angles(); else empty
  SensorError sensor{};
};

/// Errors: a reading that stands twice, with its time, if repeats have no numbers; one number but 0
/// in place of points of several poses, as instruments mark lost readings; a number that loggers
/// write in place of a temperature, a time or a load that they did not get, see
/// check_lost_values(). Warnings:
/// - 0 in place of points of several poses, which may be a reference point;
/// - readings of one number that stand twice, without a time or at another, if a quarter of the
///   rows are such copies; a quarter of all readings that stands in two sessions;
/// - standard deviations of rows more than 200 times as large as others;
/// - two sessions whose names differ in case or blanks alone;
/// - temperatures that are those of an arm in kelvin, or of an arm or a room in Fahrenheit;
/// - a clock that stands still, or that runs back a few times in rows that are otherwise in its
///   order; a clock that seems to count milliseconds (median gap above 2 h), or minutes or hours
///   (the joints would move faster than 1000 deg/s);
/// - directions of arrival that are nearly all opposite to the moves from row to row.
Findings check_log(const Campaign& campaign);

struct CopiedRows {
  std::vector<int> rows;  ///< ascending; empty if there are no copies
  int row = 0, of = 0;    ///< the first one, and the row whose copy it is
};

/// Rows whose point and orientation another row of their pose, session and channel has to the last
/// digit, whatever its time: copies in place of further visits, which would count as repeats that
/// agree. Of each reading one row stays. Where points have steps of 0.01 mm or more, visits read
/// the same by chance: then only if more do than the agreement of single coordinates explains.
CopiedRows copied_rows(const Campaign& campaign);

/// Units that the numbers contradict, as sentences: joint angles of more than four turns (degrees
/// read as radians), or all within 2 pi deg of zero (radians read as degrees); points more than 50
/// m apart, or within 10 mm while joints turn. A factor of 25.4, and 1000 of a short path, need a
/// robot file: diagnose(). `joints`: those of `q`.
std::vector<std::string> check_units(const Campaign& campaign,
                                     const std::vector<JointName>& joints);

/// Errors: joint values half a turn or more, or 1 m or more, beyond the travel that the robot file
/// states; the first one.
Findings check_travel(const Robot& robot, const Campaign& campaign);

/// Warnings: limits of the joints (min_deg, max_deg) that look like radians, or ten times too large
/// or too small. Nothing for fewer than four joints with limits.
Findings check_limits(const Robot& robot);

}  // namespace armtrue
