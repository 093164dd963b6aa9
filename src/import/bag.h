#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace armtrue {

struct BagTopic {
  std::string name, type;  ///< such as /joint_states, sensor_msgs/msg/JointState
};

/// What a recording of ROS 2 is asked for.
struct BagVisitor {
  std::function<bool(const BagTopic&)> wants;  ///< asked once or more for each topic
  /// A message of a topic that was wanted: the time at which it was recorded [ns since 1970], and
  /// its bytes as CDR.
  std::function<void(const BagTopic&, std::int64_t logged_ns, std::string_view message)> take;
};

/// Whether a path is a recording of ROS 2: a folder, or a file named .mcap or .db3.
bool is_bag(const std::string& path);

/// Visits a recording, file by file; within a file in any order. Throws InputError if it cannot be
/// read, is damaged or cut, or holds messages of a wanted topic that are not serialized as CDR.
void visit_bag(const std::string& path, const BagVisitor& visitor);

/// One file of a recording: an SQLite database, as ROS 2 Foxy to Humble write.
void visit_db3(const std::string& file, const BagVisitor& visitor);
/// One file of a recording: MCAP, as later ones do (mcap.dev/spec).
void visit_mcap(const std::string& file, const BagVisitor& visitor);

}  // namespace armtrue
