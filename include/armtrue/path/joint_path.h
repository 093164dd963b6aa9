#pragma once

#include <optional>
#include <stdexcept>
#include <string>

#include "armtrue/kinematics/chain.h"
#include "armtrue/path/path.h"

namespace armtrue {

/// A sample of a programmed path that the robot cannot take.
struct UnreachableSample : std::invalid_argument {
  UnreachableSample(Eigen::Index at, const std::string& what)
      : std::invalid_argument(what), sample(at) {}
  Eigen::Index sample;
};

struct JointPathOptions {
  std::optional<Eigen::Matrix3d> orientation;  ///< of the measured frame, where the path has none
  std::optional<JointVector> start;            ///< near the angles at the first sample: the branch
};

/// Encoder angles along a programmed path: inverse kinematics of the chain, each sample from the
/// one before, so that the branch is kept. The first one is sought near `start`, without it in the
/// whole travel. Angles of the path itself show the branch (a corrected path may carry those of the
/// path before) and, like `start`, the orientation if nothing else does.
/// Throws UnreachableSample, with the remedy, for a pose out of reach or of travel, for one whose
/// orientation nothing states, and if the path's own angles put the tool more than 10 mm away from
/// its position.
Eigen::Matrix<double, kJoints, Eigen::Dynamic> joint_path(const Path& programmed,
                                                          const KinematicChain& chain,
                                                          const JointPathOptions& options = {});

}  // namespace armtrue
