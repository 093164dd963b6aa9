#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

inline constexpr double kNoEffect = 5e-3;  ///< m: a larger error cannot be an effect of the arm

/// The mistake that explains a pose that is off, in words: each mistake is corrected in turn, and
/// the best counts if all readings then fit within `tolerance` (or 2 % of `off`) and a third of
/// `off` [m]. Mistakes: joint angles of another pose, exchanged or copied; ids of targets
/// or anchors exchanged; another session; a joint's sign; two joints exchanged; degrees for
/// radians; a wrong unit or a wrong sign of a coordinate, two coordinates exchanged. If none does,
/// one joint value that is wrong by any amount, with which the readings must fit to a thirtieth of
/// `off`, where `off` is no less than kNoEffect. `readings`: of each pose that is off, one row for
/// each of its channels; `which`: index of the pose.
std::optional<std::string> likely_mistake(const Robot& fitted, const Campaign& campaign,
                                          const std::vector<std::vector<int>>& readings,
                                          size_t which, double off, double tolerance);

/// A contact, a target or an anchor that some poses show elsewhere than the others.
struct MovedThing {
  std::vector<size_t> poses;  ///< indices into the `readings`
  std::string words;          ///< what it is, and by how much
};

/// The things that one shift for two or more poses explains: with it all of their readings fit
/// within `tolerance` [m] and a tenth of the largest error, and they have three numbers more than
/// the shift has directions that they show. `readings`: rows of each pose that no likely_mistake()
/// explains.
std::vector<MovedThing> moved_things(const Robot& fitted, const Campaign& campaign,
                                     const std::vector<std::vector<int>>& readings,
                                     double tolerance);

}  // namespace armtrue
