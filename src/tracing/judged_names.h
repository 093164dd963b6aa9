#pragma once

#include <optional>

#include "armtrue/effects/catalogue.h"
#include "armtrue/search/training.h"
#include "tracing/random_effects.h"

namespace armtrue {

/// The search of a campaign whose names held against what an arm and its station do without a name.
struct JudgedTraining {
  Training training;
  RandomEffects random;          ///< beside the last model of the training
  bool instrument_errs = false;  ///< in a way that no law describes: this is in `random`
};

/// Searches a campaign, as search_training(), for what an arm does and what happens in time. Lasting
/// errors of the instrument could take the place of nearly everything that an arm does smoothly. So
/// the search is repeated with them only where the readings give a reason, and what it finds holds
/// only if they speak for it by odds of 1000 to 1, random effects of the arm and the station beside
/// both and, beside the model without a law, random errors of the instrument. Where random errors
/// explain as much as the law that was found, the arm is the one beside these. Where errors of the
/// instrument lose, an effect that no rigid arm has (see may_be_instrument) is the arm's. Nothing is random where `identify` leaves out what the readings
/// show: it would take the place of that.
JudgedTraining judged_training(const Robot& robot, const Campaign& given, Then then,
                               const Catalogue& catalogue, const TraceOptions& options);

/// As of a Training, with random effects beside the geometry.
void fall_back_to_geometry(JudgedTraining& judged);

/// The random effects of arm and station beside a fit to `campaign`, with errors of the instrument if
/// there is a catalogue of these.
RandomEffects random_effects_beside(const CalibrationResult& fit, const Campaign& campaign,
                                    const Catalogue* of_instrument = nullptr);

/// The fit without the lasting errors of the instrument that have a name.
CalibrationResult without_laws(const CalibrationResult& fit, const Campaign& campaign);

/// The arm of a result as programs are corrected with it: without what the station does, base, tool
/// and targets placed anew. Nothing if the station does nothing in it.
std::optional<Robot> arm_alone(const Robot& result, const Campaign& campaign);

/// The arm of a fit beside() `random`: constants get the means of what follows the campaign alone,
/// base and tool are placed without it. `timed`: the campaign of the fit, in_order_of_visits().
CalibrationResult without_campaign(CalibrationResult all, const Campaign& timed,
                                   const RandomEffects& random);

/// A fit with the random effects of the arm: what a program is corrected with. Those of the campaign
/// have their part in the fit; base and tool are placed without them. `random`: beside the fit, and
/// not empty.
CalibrationResult applied_arm(const CalibrationResult& fit, const Campaign& campaign,
                              const RandomEffects& random);

}  // namespace armtrue
