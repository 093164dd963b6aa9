#pragma once

#include <optional>

#include "armtrue/effects/catalogue.h"
#include "armtrue/search/training.h"
#include "tracing/random_effects.h"

namespace armtrue {

/// The search of a campaign whose named effects hold against random effects of the arm and its
/// station.
struct JudgedTraining {
  Training training;
  RandomEffects random;          ///< beside the last model of the training
  /// Parameters of the arm that walk at random in time, as `random` has it: see judged_training().
  std::vector<Parameter> wandering;
  bool instrument_errs = false;  ///< `random` has errors of the instrument beside its laws
};

/// Searches a campaign, as search_training(), for effects of the arm and of time. Lasting errors of
/// the instrument could imitate nearly every smooth effect of an arm. So the search is repeated
/// with them only if the readings give a reason, and the laws that it finds hold only by odds of
/// 1000 to 1: both models have random effects of arm and station, and the one without laws has
/// random errors of the instrument, too. If random errors explain as much as the laws, the arm is
/// that of the model with random errors. If errors of the instrument lose, an effect that no rigid
/// arm has (see may_be_instrument) belongs to the arm. There are no random effects where `identify`
/// leaves out parameters that the readings show, because they would imitate these.
/// A parameter of the arm that three effects of time move, a step among them, had no event: it
/// wanders, as by friction that remembers or where something slips. So does one that two move,
/// unless the odds against a random walk are 1000 to 1. The effects of time are left out, and the
/// parameter is one of JudgedTraining::wandering.
JudgedTraining judged_training(const Robot& robot, const Campaign& given, Then then,
                               const Catalogue& catalogue, const TraceOptions& options);

/// fall_back_to_geometry() of the training, with random effects beside the geometry. What wanders
/// still does.
void fall_back_to_geometry(JudgedTraining& judged);

/// The random effects of arm and station beside a fit to `campaign`, with errors of the instrument
/// if there is a catalogue of these, and a random walk of what wanders.
RandomEffects random_effects_beside(const CalibrationResult& fit, const Campaign& campaign,
                                    const Catalogue* of_instrument = nullptr,
                                    const std::vector<Parameter>& wandering = {});

/// The fit without the lasting errors of the instrument that have a name.
CalibrationResult without_laws(const CalibrationResult& fit, const Campaign& campaign);

/// The arm of a result as it corrects programs, to be judged by readings: without what station and
/// tool do, as programs of another tool are corrected; base, tool and targets placed anew. Errors
/// of wires stay: the readings have them, and no place of base and tool takes up the scale of a
/// wire, which is millimetres of its length. Nothing without effects of station or tool.
std::optional<Robot> arm_alone(const Robot& result, const Campaign& campaign);

/// The arm of a fit beside() `random`: without RandomEffects::of_campaign, whose means go into the
/// constants; base and tool are placed without it. `timed`: the campaign of the fit,
/// in_order_of_visits().
CalibrationResult without_campaign(CalibrationResult all, const Campaign& timed,
                                   const RandomEffects& random);

/// A fit with the random effects of the arm, as it corrects programs. Those of the campaign take
/// part in the fit, but not in the result; base and tool are placed without them. `random`: beside
/// the fit, and not empty.
CalibrationResult applied_arm(const CalibrationResult& fit, const Campaign& campaign,
                              const RandomEffects& random);

}  // namespace armtrue
