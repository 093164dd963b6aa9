#pragma once

#include <exception>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/kinematics/joint_names.h"
#include "io/campaign_columns.h"
#include "io/csv_table.h"
#include "io/text_index.h"

namespace armtrue {

/// The indices of the names of a campaign.
struct CampaignIndices {
  TextIndex poses, targets, anchors, contacts, sessions;

  explicit CampaignIndices(Campaign& campaign)
      : poses(campaign.pose_ids),
        targets(campaign.target_names),
        anchors(campaign.anchor_names),
        contacts(campaign.contact_names),
        sessions(campaign.session_names) {}
};

/// The rows of a block of a file, as if it were a file of its own.
struct CampaignPart {
  Campaign rows;
  int first_line = 0;          ///< line of the first row; 0 if there is none
  int blank_line = 0;          ///< line of a blank line after the last row; 0 if there is none
  std::exception_ptr failure;  ///< of the row after the last complete one
};

/// Joins the parts of a campaign in the order of the file. Throws InputError for the first mistake
/// in the file: that of a part, or rows of one pose in different configurations.
class JoinedCampaign {
 public:
  /// All must outlive it. `chain` may be null.
  JoinedCampaign(const CsvTable& table, const std::vector<JointName>& joints,
                 const KinematicChain* chain, const CampaignColumns& columns, Campaign& campaign)
      : table_(table),
        joints_(joints),
        chain_(chain),
        columns_(columns),
        campaign_(campaign),
        indices_(campaign) {}

  void append(const CampaignPart& part);

 private:
  void check_configuration(int pose, const JointVector& q, int line, int row);

  const CsvTable& table_;
  const std::vector<JointName>& joints_;
  const KinematicChain* chain_;
  const CampaignColumns& columns_;
  Campaign& campaign_;
  CampaignIndices indices_;
  std::vector<int> first_row_of_pose_;
  int blank_line_ = 0;  // behind the last row so far
};

}  // namespace armtrue
