#pragma once

#include <string>

#include "armtrue/campaign/stated_covariance.h"
#include "import/table_reader.h"

namespace armtrue {

/// Of a covariance of position and rotation, row by row.
inline constexpr int kCovarianceEntries = 36;

/// Throws InputError if only some of the 36 columns of a covariance, the quantities cov0 to cov35,
/// stand in the table.
void require_whole_covariance(const PlainTable& table, const ColumnMapping& mapping);

/// Name of the column of measured poses in which a quantity cov0 to cov35 is written.
std::string our_covariance_column(const std::string& quantity);

/// The covariance of a row, as geometry_msgs/PoseWithCovariance writes it: 6 x 6 numbers row by
/// row, position [m] and rotation about the axes of the frame [rad]. Throws InputError if it is not
/// symmetric.
PoseCovariance covariance_of(const TableReader& reader, int r);

/// Which blocks of the covariances of the table are not zero in every row. ROS writes zeros where
/// nothing is known.
StatedBlocks known_blocks(const TableReader& reader);

/// Adds the covariance of the next row to the campaign, of which `r` is the row in the table.
/// Throws InputError if it is not positive definite.
void add_covariance(const TableReader& reader, int r, const PoseCovariance& covariance,
                    const StatedBlocks& blocks, Campaign& campaign);

}  // namespace armtrue
