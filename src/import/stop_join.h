#pragma once

#include "import/joint_match.h"

namespace armtrue {

/// Joins points and joint angles whose clocks differ by the standstills that are found in both, see
/// match_standstills(). A record of points that goes on while the arm moves gives the mean of each
/// standstill; readings that were taken one by one are joined as they are. Where the times can be
/// joined in several ways, the robot of the options tells which: with base and tool fitted its
/// positions agree. Throws InputError if too little, or more than one way, remains.
JointMatches match_by_stops(const TableReader& points, const TableReader& joints,
                            const ImportOptions& options);

}  // namespace armtrue
