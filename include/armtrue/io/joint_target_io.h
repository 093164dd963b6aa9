#pragma once

#include <string>
#include <vector>

#include "armtrue/kinematics/joint_names.h"

namespace armtrue {

/// One commanded configuration.
struct JointTarget {
  std::string pose;
  JointVector q;
  int line = 0;         ///< line in its file
  std::string contact;  ///< contact to be touched there, or the text of a BeamName
  std::string target;   ///< target that touches it
};

struct JointTargetFile {
  std::string name, sha256;  ///< name: for messages
  std::vector<JointTarget> targets;
};

/// Reads `pose,q1_deg..q6_deg`, or the columns of other joints, and `beam`, `contact` and `target`
/// if they are there. Throws InputError, also for an id that is missing or occurs twice.
JointTargetFile read_joint_target_file(const std::string& path,
                                       const std::vector<JointName>& joints = six_axis_names());
/// The same; its targets alone.
std::vector<JointTarget> read_joint_targets(
    const std::string& path, const std::vector<JointName>& joints = six_axis_names());

/// The same columns as text, and `beam`, `contact` and `target` where targets have them.
std::string write_joint_targets(const std::vector<JointTarget>& targets,
                                const std::vector<JointName>& joints = six_axis_names());

}  // namespace armtrue
