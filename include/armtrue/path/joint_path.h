#pragma once

#include <optional>
#include <stdexcept>
#include <string>

#include "armtrue/kinematics/chain.h"
#include "armtrue/path/path.h"

namespace armtrue {

/// A sample of a programmed path that the robot cannot reach.
struct UnreachableSample : std::invalid_argument {
  UnreachableSample(Eigen::Index at, const std::string& what)
      : std::invalid_argument(what), sample(at) {}
  Eigen::Index sample;
};

struct JointPathOptions {
  std::optional<Eigen::Matrix3d> orientation;  ///< of the measured frame, if the path has none
  std::optional<JointVector> start;  ///< near the angles at the first sample: chooses the branch
  /// With what a user states them, for messages; empty if with columns of the path alone.
  std::string orientation_option, start_option;
};

/// Encoder angles along a programmed path, by inverse kinematics of the chain. Each sample starts
/// from the angles of the one before, which keeps the branch. The first sample starts from `start`,
/// else from the angles of the path, else the whole travel is searched. The orientation is that of
/// the path, else that of the options, else that at the angles of the path, else that at `start`.
/// The angles of a corrected path may be those before its correction. Throws UnreachableSample,
/// with the remedy: for a pose out of reach or of travel, for a missing orientation, and if the
/// tool at the angles of the path is more than 10 mm from its position in the path.
JointMatrix joint_path(const Path& programmed, const KinematicChain& chain,
                       const JointPathOptions& options = {});

}  // namespace armtrue
