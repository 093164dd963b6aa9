#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/gross_poses.h"
#include "armtrue/search/trace.h"

namespace armtrue {

/// Results of the training poses: the search without gross poses, and all figures of its models
/// that need these readings, to which it refers.
struct Training {
  TraceResult trace;
  std::vector<GrossPose> gross_poses;             ///< of the campaign as it was given
  std::unique_ptr<const Campaign> without_gross;  ///< null if there are none
  const Campaign* sound = nullptr;  ///< the readings of `trace`: all that were given, or these
  Robot nominal;                    ///< with base and tool placed
  std::vector<PoseErrors> errors;   ///< of `nominal`, then of each of `trace.stages`
  FitQuality quality;               ///< of the last model
  /// For each found effect, the last model without it, with all else fitted again, to first order
  /// where the readings do not fit much worse; see Then.
  std::vector<Robot> without_effect;
  std::optional<Uncertainty> if_complete;  ///< of the last model, if it lacks nothing; see Then
};

/// The next step: held-out poses are predicted, which needs `without_effect` and `if_complete`, or
/// the training is reported alone.
enum class Then { predict, report };

/// Of a robot on the training poses, without gross poses and blunders.
PoseErrors training_errors(const Robot& robot, const Training& training);

/// Takes the effects that were found, and those held beside them, out of a training: its result is
/// the geometry, its first stage, which becomes its last stage too.
void fall_back_to_geometry(Training& training);

/// Searches a campaign for effects. Throws std::invalid_argument as trace() does, and if a fit
/// fails require_worthwhile().
Training search_training(const Robot& robot, const Campaign& given, Then then,
                         const Catalogue& catalogue, const TraceOptions& options);

}  // namespace armtrue
