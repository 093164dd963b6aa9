#pragma once

#include <set>
#include <string>

#include "import/plain_table.h"

namespace armtrue {

/// Which messages of a recording become a table.
struct BagSelection {
  bool of_joints = false;  ///< joint states; otherwise poses, points or transforms
  std::string topic;       ///< empty: the only one of such a type, or those of `joints`
  std::string body;        ///< child frame of transforms; empty: the only one
  /// Names of joint states that are wanted: of several topics the one that has them all is read, or
  /// all that have some of them. Empty: one topic.
  std::set<std::string> joints;
};

/// The messages of a recording's topics (see is_bag()) as rows in the order of time, with the
/// columns that the presets plotjuggler-joints and plotjuggler-poses know. The number of a row is
/// that of its message. Times are those of the headers, or of the recorder where all headers of a
/// topic have 0.
/// Throws InputError.
PlainTable read_bag_table(const std::string& path, const BagSelection& selection);

}  // namespace armtrue
