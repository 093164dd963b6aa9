#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "armtrue/effects/robot.h"
#include "armtrue/path/joint_path.h"
#include "armtrue/path/path.h"

namespace armtrue {

/// A cut and its force on the tool, which does not depend on the deviation of the tool. Defaults:
/// the 8 mm pass of the seed paper. There k = 0.022 mm/N and a mean deviation of 0.91 mm give 41 N;
/// direction and variation along the path are those of table 5.
struct Cut {
  double depth = 8e-3;  ///< [m]; 0: no force
  /// Force on the tool per metre of depth, along feed, normal and z [N/m]. The normal lies to the
  /// left of the feed as seen from above: z x feed; a tool that plunges along z has none.
  Eigen::Vector3d force_per_depth{580, 5000, -1160};
  /// Arc lengths between which the tool cuts [m]; absent: the whole path.
  std::optional<std::array<double, 2>> engaged;
  double ramp = 5e-3;      ///< length of entry and exit [m]; here the radius of the paper's cutter
  double variation = 0.1;  ///< RMS of the variation of the force, relative to the force
  std::uint64_t part_seed = 1;  ///< seed of the variation, which is the same in every pass over one
                                ///< part
};

/// The instrument that records the pass. Its clock shows
///     t = (1 + clock_rate) * (time of the controller) + clock_offset.
struct PathRecorder {
  double period = 32e-3;  ///< by its own clock [s]
  double clock_offset = 0, clock_rate = 0;
  double noise = 0;        ///< of the position, per axis [m]
  double force_noise = 0;  ///< per axis [N]
  double lost = 0;         ///< chance that a sample is lost
  std::uint64_t seed = 1;
};

struct PassOptions {
  JointPathOptions joints;
  Cut cut;
  /// The path that the part was programmed with, at the same times, if the executed path is a
  /// correction of it. The force follows the part and not the slightly longer corrected path.
  std::optional<Path> part;
  double lag = 0;  ///< time constant of the servos, first order, the same for all joints [s]
  PathRecorder recorder;
};

/// Force of the cut on the tool at each sample [N], axes of the path. Throws std::invalid_argument
/// if the tool would cut nowhere on the path.
Eigen::Matrix3Xd cutting_force(const Path& path, const Cut& cut);

/// Simulates a pass as the instrument records it: position, force and encoder angles. The
/// controller turns the path into joint angles with the chain of `robot`, without its effects. The
/// joints follow with their lag. `truth`, with its effects, gives the position of the tool at these
/// angles and this force. Throws as joint_path() and cutting_force() do.
Path simulate_pass(const Path& programmed, const Robot& robot, const Robot& truth,
                   const PassOptions& options = {});

}  // namespace armtrue
