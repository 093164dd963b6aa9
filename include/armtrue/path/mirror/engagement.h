#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace armtrue {

/// An instant, certain to lie within time +- uncertainty [s].
struct Instant {
  double time = 0, uncertainty = 0;
};

/// The tool in the material from entry to exit; empty: beyond the record.
struct Engagement {
  std::optional<Instant> entry, exit;
};

struct EngagementRecord {
  std::vector<Engagement> intervals;
  /// RMS of each axis in air: ForceRecord::force_noise before any low pass. Zero if nothing was
  /// found.
  Eigen::Vector3d noise = Eigen::Vector3d::Zero();
};

/// Finds when the tool is in the material, from the magnitude of `signal` (3 x n): the force, or,
/// if there is none, the deviation. The quietest part of the record counts as air, with mean m and
/// standard deviation s. The tool enters where the magnitude exceeds m + 6 s and leaves when it has
/// stayed below m + 3 s for a quarter of a second; a shorter engagement is none. The engaged level
/// is the median magnitude in between. An entry lies between the last sample below m + 3 s, less
/// the time for which a linear growth is hidden in the noise, and the first sample at half the
/// engaged level; an exit likewise. This holds for the beginning of a slow entry, and for a sudden
/// one behind a zero-phase low pass.
///
/// Nothing is found if the engaged level is less than 2 m: the tool was in the material throughout
/// or never, or the signal does not show it. In deviations other causes, such as a reversal, look
/// like an engagement; prefer forces. Throws std::invalid_argument if sizes disagree.
EngagementRecord find_engagement(const Eigen::VectorXd& time, const Eigen::Matrix3Xd& signal);

}  // namespace armtrue
