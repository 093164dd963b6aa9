#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/io/covariance_column.h"
#include "armtrue/kinematics/joint_names.h"
#include "io/context_columns.h"
#include "io/csv_table.h"

namespace armtrue {

/// Where the columns of a file of measured poses stand (armtrue-formats(5)). Of one quantity all
/// columns are there, or none.
struct CampaignColumns {
  std::optional<int> pose, repeat, target, anchor, contact, session;
  std::optional<int> beam, camera, board, corner;
  std::array<std::optional<int>, 2> pixel;  ///< both or none
  std::optional<CsvTable::Quantity> distance;
  std::array<std::optional<CsvTable::Quantity>, 2> profile;  ///< y and z, both or none
  bool has_points = true;
  std::vector<std::optional<CsvTable::Quantity>> q;  ///< one for each joint
  std::array<std::optional<CsvTable::Quantity>, 3> position, abc;
  std::array<std::optional<int>, 4> quaternion;
  std::optional<CsvTable::Quantity> sigma_position, sigma_orientation;
  std::optional<CsvTable::Quantity> sigma_pixel;  ///< of rows that are pixels
  /// Covariances of x, y, z, rx, ry, rz, the upper triangle row by row: each of the blocks of the
  /// position, of the rotation, and between both is there or not.
  std::array<std::optional<CsvTable::Quantity>, 21> covariance;
  std::optional<ContextColumns> context;  ///< of every file
  std::vector<std::string> unknown;       ///< not used
};

/// `source`: the file, for messages. Throws InputError if a column is missing, or if a quantity is
/// there in part or twice.
CampaignColumns find_campaign_columns(const CsvTable& table, const std::vector<JointName>& joints,
                                      const std::string& source);

}  // namespace armtrue
