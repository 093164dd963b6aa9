#pragma once

#include <optional>

#include "armtrue/path/path.h"
#include "armtrue/path/registration/clock.h"
#include "armtrue/path/samples/bad_samples.h"

namespace armtrue {

/// From one sample to the next the record jumps, and stays there.
struct RecordStep {
  Eigen::Index sample;  ///< first after the jump
  double moved;         ///< [m]
};

/// The rigid motion that takes most of the deviation off a record.
struct RigidDeviation {
  double before, after;  ///< rms of the deviation as recorded, and with the motion taken off [m]
  double moved;          ///< of the middle of the record [m]
  double turned;         ///< [rad]
};

/// A stretch in which the record does not follow the shape of the program.
struct UnfollowedShape {
  Eigen::Index first, last;  ///< samples of the record
  double shape;              ///< rms distance of the program from an even straight motion [m]
  double followed;           ///< share of that shape which the record has
};

/// What in a record is more likely the instrument's than the arm's. A correction carries both into
/// the part.
/// Or the record is of another program.
struct RecordDoubts {
  /// A jump above 1.5 mm and 6 times the median change from sample to sample, of which at least 70
  /// % stay over ten samples, while the program keeps its velocity. An arm that a cut bends needs
  /// longer.
  std::optional<RecordStep> step;
  /// Present if the deviation is above 2 mm and the motion leaves at most a third of it. An arm
  /// that is off alike all over the path looks the same.
  std::optional<RigidDeviation> rigid;
  /// In a half or a quarter of the samples the program p departs by more than 2 mm (rms) from the
  /// straight motion with constant velocity that is nearest to it, and the record m from its own by
  /// less than half as much: <m, p> / <p, p> < 0.5. The servos of an arm cut corners by less.
  std::optional<UnfollowedShape> unfollowed;
};
RecordDoubts record_doubts(const Path& programmed, const Path& measured, const ClockFit& clock,
                           const std::vector<BadSample>& bad);

}  // namespace armtrue
