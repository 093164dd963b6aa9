#pragma once

#include "armtrue/effects/catalogue.h"
#include "search/training.h"
#include "tracing/random_effects.h"

namespace armtrue {

/// The search of a campaign whose names held against what an arm and its station do without a name.
struct JudgedTraining {
  Training training;
  RandomEffects random;  ///< beside the last model of the training
};

/// Searches a campaign, as search_training(). A distortion of the space in which the instrument
/// measures could take the place of nearly everything that an arm does smoothly. So the search is
/// repeated without it, and the distortion stays only if the readings speak for it by odds of 1000
/// to 1, random effects of arm and station beside both. Without it an effect that no rigid arm has
/// (see may_be_instrument) is the arm's if it explains the readings better than any smooth field
/// does. Nothing is random where `identify` leaves out what the readings show: it would take the place
/// of that.
JudgedTraining judged_training(const Robot& robot, const Campaign& given, Then then,
                               const Catalogue& catalogue, const TraceOptions& options);

/// As of a Training, with random effects beside the geometry.
void fall_back_to_geometry(JudgedTraining& judged);

/// The last model of a training with the random effects of the arm: what a program is corrected
/// with. Those of the campaign had their part in the fit; base and tool are placed without them.
/// `random`: not empty.
CalibrationResult applied_arm(const JudgedTraining& judged);

}  // namespace armtrue
