#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace armtrue {

/// An instant within time +- uncertainty [s].
struct Instant {
  double time = 0, uncertainty = 0;
};

/// An interval in which the tool is in the material. An empty end lies before the start or after
/// the end of the record.
struct Engagement {
  std::optional<Instant> entry, exit;
};

/// The result of find_engagement().
struct EngagementRecord {
  std::vector<Engagement> intervals;
  /// RMS of each axis in air, which is ForceRecord::force_noise before a low pass. Zero if nothing
  /// was found.
  Eigen::Vector3d noise = Eigen::Vector3d::Zero();
};

/// Finds when the tool is in the material, from the magnitude of `signal` (3 x n): the force, or,
/// if there is none, the deviation. The quietest part of the record counts as air, with mean m and
/// standard deviation s. The tool enters where the magnitude exceeds m + 6 s and leaves when it has
/// stayed below m + 3 s for a quarter of a second; a shorter engagement does not count. The engaged
/// level is the median magnitude in between. An entry lies between two times. The first is that of
/// the last sample below m + 3 s, less the time for which a linear growth is hidden in the noise;
/// the second is that of the first sample at half the engaged level. An exit is bounded likewise.
/// These bounds hold for the beginning of a slow entry, and for a sudden entry after a zero-phase
/// low pass.
///
/// Nothing is found if the engaged level is below 2 m: the tool was always or never in the
/// material, or the signal does not show it. In deviations other causes, such as a reversal, look
/// like an engagement; prefer forces. Throws std::invalid_argument if sizes disagree.
EngagementRecord find_engagement(const Eigen::VectorXd& time, const Eigen::Matrix3Xd& signal);

}  // namespace armtrue
