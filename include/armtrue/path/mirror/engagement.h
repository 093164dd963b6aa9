#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace armtrue {

/// A moment of which it is certain that it lies within +- uncertainty [s].
struct Instant {
  double time = 0, uncertainty = 0;
};

/// The tool in the material; an entry or exit that the record does not hold is empty.
struct Engagement {
  std::optional<Instant> entry, exit;
};

struct EngagementRecord {
  std::vector<Engagement> intervals;
  /// RMS of each axis in air, the noise that force_law() asks for; zero if nothing was found.
  Eigen::Vector3d noise = Eigen::Vector3d::Zero();
};

/// When the tool is in the material, from `signal` (3 x n): the force, or, where there is none, the
/// deviation. The quietest part of the record is taken for air. The tool enters where the magnitude
/// leaves the air's mean by six of its standard deviations for good, and is out once it has stayed
/// within three for a quarter of a second; what lasts less is no engagement. An entry lies between
/// the last sample within the noise, less the time for which an even growth hides in it, and the
/// first at half the engaged level (an exit likewise). That holds for a slow entry, whose beginning
/// is meant, and for a sudden one behind a low pass without phase.
///
/// Nothing is found if the engaged level is not twice that of air: the tool was in the material
/// throughout, or never, or the signal does not show it. From deviations everything else that moves
/// the tool, such as a reversal, looks like an engagement; prefer forces.
/// Throws std::invalid_argument if sizes disagree.
EngagementRecord find_engagement(const Eigen::VectorXd& time, const Eigen::Matrix3Xd& signal);

}  // namespace armtrue
