#pragma once

#include <string>
#include <vector>

#include "io/import/table_reader.h"

namespace armtrue {

/// Joint angles for one row of the points.
struct JointMatch {
  int point_row = 0;
  int joint_row = 0;  ///< whose further columns hold for the point
  JointVector q;      ///< [rad]
};

struct JointMatches {
  std::vector<JointMatch> rows;  ///< in the order of the points
  std::string how;               ///< for people: by id, by order, by time
  std::vector<std::string> warnings;
};

/// Joins points and joint angles: by the column of poses, by the order of the rows, or by time. By
/// time the joint angles are those between the two samples about the point, and only points are
/// taken at which the joints stand still. Throws InputError where rows cannot be told apart.
JointMatches match_joints(const TableReader& points, const TableReader& joints,
                          const ImportOptions& options);

}  // namespace armtrue
