#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// The rows of each session, in the order of the file; sessions without rows are left out. All rows
/// where the campaign names no sessions.
std::vector<std::vector<int>> rows_by_session(const Campaign& campaign);

/// Throws std::invalid_argument if a session of `held_out` has no reading in `training`: only those
/// show the place of its instrument. Also throws for a contact without a reading in `training`.
void require_known_sessions(const Campaign& training, const Campaign& held_out);

/// The robot at one row: with the base and the zero offsets of the row's session, or unchanged if
/// the robot does not know the session.
Robot robot_at_row(const Robot& robot, const Campaign& campaign, int row);

/// Sets the base, the zero offsets and their standard deviations to those of a session.
void move_to(const Session& session, Robot& robot);

/// The readings of all sessions in one R_A, that of `robot.chain.base`: transforms the points,
/// orientations and forces of each session that the robot knows from the session's own R_A.
/// Distances do not depend on the frame; coordinates stay along the axes of their own R_A.
Campaign in_common_frame(Campaign campaign, const Robot& robot);

/// The parameters of which each session has its own value: the base, then the zero offsets of
/// `robot.identify_per_session`. Throws std::invalid_argument for a name that is no zero offset.
std::vector<int> own_parameters(const Robot& robot);

/// Whether each session has its own value of the parameter, or of the group.
bool is_of_each_session(const Parameter& parameter, const Robot& robot);

/// The name of the session of a row; empty if the campaign has no sessions.
std::string session_name(const Campaign& campaign, int row);

/// The R_A of `robot.chain.base` from that of a session; the identity if the robot does not know
/// it.
Pose common_from_session(const Robot& robot, const std::string& session);

}  // namespace armtrue
