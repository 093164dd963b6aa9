#pragma once

#include <string>
#include <vector>

namespace armtrue {

/// What a corrected program needs besides, for pages and messages.
inline constexpr const char* kFramesNeeded =
    "frames and tools ($BASE, wobj, UF, $TOOL) that were measured by the instrument, or touched "
    "with a corrected program: what the arm touched with its own model carries its errors, so "
    "measure it anew";

/// Under which conditions the predictions for an arm are valid: those of a compensation or of a map
/// of errors.
struct PredictionConditions {
  std::string robot, controller;         ///< names
  std::vector<std::string> assumed;      ///< in sentences
  std::vector<std::string> not_applied;  ///< effects of the station
  /// Of a robot program: how many of its moves are corrected, in a sentence, and whether all are.
  std::string moves = {};
  bool all_moves = true;
};

}  // namespace armtrue
