#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"

namespace armtrue {

struct CampaignFile {
  Campaign campaign;
  std::string sha256;
  std::vector<std::string> unknown_columns;  ///< not used; worth one word to the user
};

/// Reads measured poses (the measurements contract) from a file, or from standard input for "-".
/// Directions of arrival that the file does not state are taken from the previous row.
/// Throws InputError: a missing or malformed column, a replicate at other joint angles, a repeat
/// that stands twice, no measured row at all.
CampaignFile read_campaign(const std::string& path);

/// The same columns as text; `repeat`, `t_s`, orientation (as A, B, C), target, anchor and arrival
/// where the campaign has them.
std::string write_campaign(const Campaign& campaign);

/// One commanded configuration.
struct JointTarget {
  std::string pose;
  JointVector q;
  int line = 0;  ///< of its file
};

/// Reads `pose,q1_deg..q6_deg`. Throws InputError, also for an id that is missing or stands twice.
std::vector<JointTarget> read_joint_targets(const std::string& path);
std::string write_joint_targets(const std::vector<JointTarget>& targets);

/// The residuals of a campaign, one for each row.
struct Residuals {
  const Campaign& campaign;
  std::vector<Eigen::Matrix<double, 6, 1>> of_row;  ///< as in Evaluation [m, rad]
  std::vector<std::string> split;                   ///< of each row: training, held-out or all
};

/// Measured minus model, in R_A; of a distance in the column dl_mm. One campaign after another.
std::string write_residuals(const std::vector<Residuals>& campaigns);

}  // namespace armtrue
