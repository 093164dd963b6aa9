#pragma once

#include <string>
#include <vector>

namespace armtrue {

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
