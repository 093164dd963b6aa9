#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/tracing/loop.h"

namespace armtrue {

/// Reasons to doubt the result of a loop.
struct LoopDoubts {
  std::vector<std::string> sentences;  ///< none is empty
  /// False if the result must not be used: the fit did not converge, its error is beyond any arm,
  /// or held-out poses are predicted worse than by the nominal robot. A sentence says why.
  bool may_be_used = true;
};

/// Doubts about what touches and poses show, the result as a whole, the joint angles, effects that
/// were rejected, and the noise. `training`: the campaign that was given to close_loop().
LoopDoubts doubts_of_loop(const Robot& robot, const Campaign& training, const LoopResult& result);

}  // namespace armtrue
