#pragma once

#include <map>
#include <vector>

#include "armtrue/planning/pose_cloud.h"

namespace armtrue {

/// The kinds of readings of the given poses. The scanner is the one that read there.
ReadingKinds kinds_of(const Campaign& given);

/// The pose of a row, with what it touches.
PlannedPose planned_pose_at(const Campaign& given, int row);

/// What the arm touched in the given poses, each once, from the side on which it stood.
std::vector<TouchSight> touches_of(const Campaign& given, const KinematicChain& chain);

/// Lets beams that do not state their range read from the least to the largest given reading.
void state_ranges(const Campaign& given, KinematicChain& chain);

/// Standard deviations that the rows of each kind of reading state, their medians. Of pixels [px].
std::map<ReadingKind, double> stated_by_kind(const Campaign& given);

}  // namespace armtrue
