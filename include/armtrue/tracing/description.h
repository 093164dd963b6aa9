#pragma once

#include <string>
#include <vector>

#include "armtrue/tracing/loop.h"

namespace armtrue {

/// One sentence on a found effect: which parameter follows which driver, by how much, and how sure
/// the cause is. `gain` may be null, `curve` may be empty.
std::string in_words(const TracedEffect& traced, const HeldOutGain* gain,
                     const std::vector<CurvePoint>& curve, const Robot& robot);

/// One sentence for the operator of the cell: the cause, if one is known, and how sure it is.
std::string for_the_cell(const TracedEffect& traced, const HeldOutGain* gain, const Robot& robot);

/// The verdict as one sentence: the error before and after, and what remains.
std::string verdict_in_words(const LoopResult& result);

/// A sentence on rejected effects: that they are no part of the result, and why; empty if none was
/// rejected.
std::string rejection_in_words(const LoopResult& result);

/// A sentence if the noise is unknown, with the remaining error and the remedy; empty if it is
/// known, or the remaining error is below what instruments read.
std::string unknown_noise_in_words(const LoopResult& result);

/// One sentence on an effect and its rival: what would change if the rival took its place, by how
/// much the two differ, and which readings would separate them.
std::string unidentifiable(const TracedEffect& traced, const Rival& rival);

/// Unit of the amplitude of an effect: "mrad", or "mrad per K" where a factor multiplies it.
std::string amplitude_unit(const Effect& effect, const Robot& robot);

/// "a, b and c".
std::string listed(const std::vector<std::string>& items);

}  // namespace armtrue
