#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// The rows of each session, in the order of the file; sessions without rows are left out. All rows
/// where the campaign names no sessions.
std::vector<std::vector<int>> rows_by_session(const Campaign& campaign);

/// Throws std::invalid_argument if a session of `held_out` has no reading in `training`, from which
/// alone it can be learnt where its instrument stood.
void require_known_sessions(const Campaign& training, const Campaign& held_out);

/// The robot as it was at one row: with what the row's session has of its own, or as it is if the
/// robot does not know the session.
Robot robot_at_row(const Robot& robot, const Campaign& campaign, int row);

/// The readings as an instrument that never moved would have given them: points, orientations and
/// forces of each session that the robot knows, moved from its own R_A to that of
/// `robot.chain.base`. Distances are the same in both.
Campaign in_common_frame(Campaign campaign, const Robot& robot);

/// What each session has for itself: the base, then the zero offsets of
/// `robot.identify_per_session`. Throws std::invalid_argument for a name that is no zero offset.
std::vector<int> own_parameters(const Robot& robot);

/// The name of the session of a row; empty where the campaign names none.
std::string session_name(const Campaign& campaign, int row);

/// The R_A of `robot.chain.base` from that of a session; the identity if the robot does not know
/// it.
Pose common_from_session(const Robot& robot, const std::string& session);

}  // namespace armtrue
