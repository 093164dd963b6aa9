#pragma once

#include <optional>
#include <vector>

#include "armtrue/path/mirror/mirror.h"
#include "armtrue/path/mirror/mirror_options.h"
#include "armtrue/path/path.h"

namespace armtrue {

/// A pass whose deviation is another than that of the other passes: of air beside a cut, of another
/// depth.
struct UnlikePass {
  size_t pass;
  double apart;  ///< rms distance from the mean deviation of the others, across the path [m]
  double mean;   ///< rms mean deviation of all passes [m]
};

/// The pass that is farthest from the others, if it is farther than half the mean deviation and
/// than six times the noise of a sample; both distances are means over a second. Of two passes the
/// first. Passes that meet the same cut differ by a tenth of the deviation. `passes` are the records
/// of the result, bad samples included.
std::optional<UnlikePass> find_unlike_pass(const Path& programmed, const std::vector<Path>& passes,
                                           const MirrorResult& result);

/// Whether the tool deviates against the force on it: the compliance along the strongest direction
/// of the force is below zero by three standard deviations. No arm does that; an axis of the record
/// or of the force has the wrong sign. False without a force.
bool deviates_against_force(const Path& programmed, const MirrorResult& result,
                            const MirrorOptions& options);

/// Whether the deviation is no larger than the noise of one sample: there is nothing to correct, as
/// where a pass ran a correction.
bool hardly_deviates(const MirrorResult& result);

/// Whether all samples lie on a straight line: such a path does not show how a frame is turned about
/// it.
bool is_straight(const Path& path);

}  // namespace armtrue
