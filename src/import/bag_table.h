#pragma once

#include <string>

#include "import/plain_table.h"

namespace armtrue {

/// Which messages of a recording become a table.
struct BagSelection {
  bool of_joints = false;  ///< joint states; otherwise poses, points or transforms
  std::string topic;       ///< empty: the only one of such a type
  std::string body;        ///< child frame of transforms; empty: the only one
};

/// The messages of one topic of a recording (see is_bag()) as rows in the order of time, with the
/// columns that the presets plotjuggler-joints and plotjuggler-poses know. The number of a row is
/// that of its message. Times are those of the headers, or of the recorder where all these are 0.
/// Throws InputError.
PlainTable read_bag_table(const std::string& path, const BagSelection& selection);

}  // namespace armtrue
