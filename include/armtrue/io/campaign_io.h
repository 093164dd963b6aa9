#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/campaign/turns.h"
#include "armtrue/kinematics/joint_names.h"

namespace armtrue {

struct CampaignFile {
  Campaign campaign;
  std::string sha256;
  std::vector<std::string> unknown_columns;  ///< not used; the command warns of them
  std::vector<MovedByTurns> moved_by_turns;  ///< likewise; `first` is a row of the campaign
};

/// Reads measured poses from a file, or from standard input for "-"; armtrue-formats(5) names the
/// columns. Directions of arrival that the file does not state follow from the previous row.
/// `joints`: those of the robot. Throws InputError for a missing or malformed column, a replicate
/// at other joint angles, a repeat that occurs twice, or a file without a measured row.
CampaignFile read_campaign(const std::string& path,
                           const std::vector<JointName>& joints = six_axis_names());

/// The same for a known robot: angles counted within one turn are moved into the travel of their
/// joint, see move_into_travel().
CampaignFile read_campaign(const std::string& path, const KinematicChain& chain);

/// The same columns as text: those of points, distances, touches, beams, profiles and pixels as far
/// as rows read them; `repeat`, `t_s`, orientation (as A, B, C), covariances, target, anchor,
/// arrival, session, payload and temperatures where the campaign has them. The campaign is one
/// before bind_touches() and points_to_coordinates(). Readings of a gauge, forces, strokes and
/// motor torques are not written.
std::string write_campaign(const Campaign& campaign,
                           const std::vector<JointName>& joints = six_axis_names());

}  // namespace armtrue
