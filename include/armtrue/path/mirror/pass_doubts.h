#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "armtrue/path/mirror/mirror.h"
#include "armtrue/path/mirror/mirror_options.h"
#include "armtrue/path/path.h"

namespace armtrue {

/// A pass whose deviation differs from that of the others, such as a pass in air or at another
/// depth.
struct UnlikePass {
  size_t pass;
  double apart;  ///< rms distance from the mean deviation of the others, across the path [m]
  double mean;   ///< rms mean deviation of all passes [m]
};

/// The pass that is farthest from the others, if its distance exceeds half the mean deviation and
/// six times the noise of a sample; the deviations are averaged over a second. Of two passes, the
/// first is returned. Passes over the same cut differ by a tenth of the deviation. `passes` are the
/// records of the result, bad samples included.
std::optional<UnlikePass> find_unlike_pass(const Path& programmed, const std::vector<Path>& passes,
                                           const MirrorResult& result);

/// Two axes of the force that look exchanged: along both the tool yields to the force of the other,
/// which leaves less than a quarter of what the own force leaves of the deviation. Each law has one
/// number for each axis. No arm yields so: its compliance is symmetric and positive.
std::optional<std::pair<Eigen::Index, Eigen::Index>> exchanged_forces(const Path& programmed,
                                                                      const MirrorResult& result,
                                                                      const MirrorOptions& options);

/// Whether the tool deviates against the force on it: the compliance along the strongest direction
/// of the force is below zero by three standard deviations. As no arm does that, an axis of the
/// record or of the force has the wrong sign. False without a force.
bool deviates_against_force(const Path& programmed, const MirrorResult& result,
                            const MirrorOptions& options);

/// Whether the deviation is no larger than the noise of one sample, as that of a pass which already
/// ran a correction. The mean of many samples may show more than that.
bool hardly_deviates(const MirrorResult& result);

/// The step s of the coordinates of a record [m] if they are rounded to 0.01 to 1 mm (1, 2, 2.5 or
/// 5 times a power of ten) and their noise, rounding included, is below s / 2. With more noise,
/// some samples cross each step, and their mean shows values between the steps. With less, the
/// record hides up to s / 2, which neither its noise nor a forecast contains. `noise`: standard
/// deviation of a sample, per axis [m].
std::optional<double> step_that_hides(const Path& record, double noise);

/// Whether the passes deviate as if the correction `executed` had not been run: the deviation is
/// 0.7 to 1.3 times the one that the correction was made against, with less than a quarter of its
/// square left. A pass that ran the correction shows only its residual.
bool deviates_as_before(const Path& programmed, const MirrorResult& result,
                        const Eigen::Matrix3Xd& executed);

/// The longest time between two samples of a path between which the tool moves [s]. A correction
/// of these samples is straight between them.
double longest_step_in_motion(const Path& path);

/// Whether a path leaves a straight line by no more than `off` (rms) [m]. Where it deviates by as
/// much, it does not show a rotation of the frame about it.
bool is_straight(const Path& path, double off);

/// The normal of the plane that a path leaves by no more than `off` (rms) [m]. Where it deviates by
/// as much, it does not show whether it was turned over or an axis of the record is mirrored.
std::optional<Eigen::Vector3d> normal_of_flat(const Path& path, double off);

}  // namespace armtrue
