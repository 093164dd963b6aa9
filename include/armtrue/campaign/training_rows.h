#pragma once

#include <cstdint>
#include <vector>

#include "armtrue/campaign/campaign.h"

namespace armtrue {

/// Marks of the rows that a calibration used: a robot file holds them, so that rows that were
/// copied into another file are recognised. The mark of a row is a hash of its joint values, to
/// 0.001 deg (0.017 mm of a rail), and of its reading, to 0.01 mm or 0.01 px; the name of its pose,
/// its orientation and its time do not count. Of more than kMostMarks marks, the smallest are kept.
struct TrainingRows {
  /// Number of marks that are kept at most: 32 kB of a file. Two rows have the same mark by chance
  /// once in 2^32.
  static constexpr size_t kMostMarks = 4096;

  long rows = 0;                     ///< all that were used
  std::vector<std::uint32_t> marks;  ///< increasing; kMostMarks or fewer
};

TrainingRows training_rows(const Campaign& campaign);

/// Number of poses of a campaign that took part in a calibration.
struct SeenPoses {
  /// Poses with a row among those of the calibration. Where a row is one number (distance, pixel,
  /// ...), with more than half of their rows, and none where chance alone could make so many.
  int seen = 0;
  int compared = 0;  ///< poses with a row that can be looked up: not all, if marks were left out
  double share() const { return compared > 0 ? static_cast<double>(seen) / compared : 0; }
};

SeenPoses seen_poses(const TrainingRows& training, const Campaign& campaign);

}  // namespace armtrue
