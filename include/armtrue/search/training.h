#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/gross_poses.h"
#include "armtrue/calibration/prediction.h"
#include "armtrue/search/trace.h"

namespace armtrue {

/// Results of the training poses: the search without gross poses, and the figures of its models
/// that need these readings. Refers to the readings, which must outlive it.
struct Training {
  TraceResult trace;
  std::vector<GrossPose> gross_poses;             ///< of the given campaign
  std::unique_ptr<const Campaign> without_gross;  ///< null if there are none
  const Campaign* sound = nullptr;  ///< the readings of `trace`: the given ones, or `without_gross`
  Robot nominal;                    ///< with base and tool placed
  std::vector<PoseErrors> errors;   ///< of `nominal`, then of each of `trace.stages`
  FitQuality quality;               ///< of the last model
  /// For each found effect, the last model without it, with all else refitted (to first order where
  /// the readings do not fit much worse); see Then.
  std::vector<Robot> without_effect;
  std::optional<IfComplete> if_complete;  ///< of the last model, if it lacks nothing; see Then
};

/// The next step: held-out poses are predicted, which needs `without_effect` and `if_complete`, or
/// the training is reported alone.
enum class Then { predict, report };

/// Errors of a robot on the training poses, without gross poses and blunders.
PoseErrors training_errors(const Robot& robot, const Training& training);

/// Removes the found effects, and those held beside them: the result is the geometry, the first
/// stage, which is then also the last.
void fall_back_to_geometry(Training& training);

/// Removes the k-th found effect and refits the rest. The evidence of the other effects stays that
/// of the search. `training`: for Then::predict.
void leave_out_effect(Training& training, size_t k, const TraceOptions& options);

/// Searches a campaign for effects. Throws std::invalid_argument as trace() does, and if a fit
/// fails require_worthwhile().
Training search_training(const Robot& robot, const Campaign& given, Then then,
                         const Catalogue& catalogue, const TraceOptions& options);

}  // namespace armtrue
