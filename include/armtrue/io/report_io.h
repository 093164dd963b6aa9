#pragma once

#include <optional>
#include <string>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/zone.h"
#include "armtrue/diagnosis/change.h"
#include "armtrue/io/provenance.h"
#include "armtrue/tracing/loop.h"

namespace armtrue {

/// Where the arm shall be accurate, and how many of the readings lie there.
struct WeightedZone {
  Zone zone;
  int readings_inside;
};

/// The calibrated robot with a `calibration:` map: convergence, rank, condition, observability,
/// errors, the zone that it was fitted for, and every absorbed parameter with what absorbs it.
std::string write_calibration(const CalibrationResult& result, const Campaign& campaign,
                              const Provenance& provenance,
                              const std::optional<WeightedZone>& weighted_zone = std::nullopt);

/// armtrue-summary/1: errors of a robot on a campaign.
std::string write_summary(const Evaluation& evaluation, const Robot& robot,
                          const Campaign& campaign, const Provenance& provenance);

/// armtrue-ranking/1: what the tracer found and the best candidates it did not add.
std::string write_ranking(const TraceResult& result, const Provenance& provenance);

/// The effects of an armtrue-ranking/1 or armtrue-loop/1 document, with what cannot be told from
/// them; other statements are not read. Throws InputError.
std::vector<TracedEffect> read_findings(const std::string& path, const KinematicChain& chain);

/// armtrue-change/1: whether a calibration still holds and, if not, what has moved: every move
/// whose p-value is below kChangeSignificance or that cannot be told from the best.
std::string write_change(const ChangeResult& result, const Robot& previous,
                         const Campaign& campaign, const Provenance& provenance);

/// armtrue-loop/1.
std::string write_loop(const LoopResult& result, const TraceOptions& options,
                       const Provenance& provenance, const std::string& next_poses);

/// One sentence for each effect of a loop, as in its document.
std::vector<std::string> effect_descriptions(const LoopResult& result);

/// The stages and the held-out errors as a table for a terminal.
std::string before_after_table(const LoopResult& result);

}  // namespace armtrue
