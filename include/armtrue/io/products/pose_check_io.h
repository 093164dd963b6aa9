#pragma once

#include <optional>
#include <vector>

#include "armtrue/diagnosis/pose_check.h"
#include "armtrue/io/document.h"
#include "armtrue/io/provenance.h"

namespace armtrue {

/// Where a robot stands at the joint angles `q` [rad], and with what a pose of the pendant agrees.
struct PoseCheck {
  JointVector q;
  std::vector<ShownFrame> frames;
  std::optional<PendantPose> pose;  ///< if one is compared
  std::vector<Agreement> agreements;
  bool agrees() const { return !agreements.empty() && agreements.front().changes.empty(); }
};

/// armtrue-pose-check/1.
Document write_pose_check(const Robot& robot, const PoseCheck& check, const Provenance& provenance);

}  // namespace armtrue
