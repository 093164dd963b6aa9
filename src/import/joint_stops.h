#pragma once

#include <string>
#include <vector>

#include "armtrue/import/import_io.h"

namespace armtrue {

/// Where the arm stood, one row for each image.
struct JointStops {
  ImportedReadings readings;        ///< their points are zero
  std::vector<std::string> images;  ///< the column `image` of each row; empty without it
  bool has_poses = false;           ///< a column names the poses; otherwise they are numbered
};

/// Reads a table of joint angles as import_readings() does. Throws InputError.
JointStops read_joint_stops(const std::string& joints, const ImportOptions& options);

}  // namespace armtrue
