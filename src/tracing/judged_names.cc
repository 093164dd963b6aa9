#include "tracing/judged_names.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "search/candidates.h"

namespace armtrue {
namespace {

const double kRuledOut = 2 * std::log(1000.0);

bool is_distortion(const Effect& effect) { return is_polynomial(effect.shape); }

Catalogue without_distortion(Catalogue catalogue) {
  std::erase_if(catalogue,
                [](const CatalogueEntry& entry) { return is_polynomial(entry.shape); });
  return catalogue;
}

RandomEffects beside_groups(const CalibrationResult& fit, const Campaign& timed,
                            const CalibrationResult& law, bool with_field = false) {
  std::vector<EffectGroup> groups = effect_groups(fit.robot, timed);
  if (with_field) groups.push_back(field_of_space(fit.robot, timed));
  return random_effects(fit, timed, groups, law);
}

// Whether an effect is doubtful only because no rigid arm has it: not because it follows time, nor
// because a law of the instrument could take its place.
bool is_of_no_rigid_arm(const TracedEffect& traced) {
  return traced.effect.may_be_instrument && !traced.effect.driver.follows_course() &&
         std::ranges::none_of(traced.indistinguishable, [](const Rival& rival) {
           return owner_of(rival.effect) == Owner::instrument && !is_distortion(rival.effect);
         });
}

// Whether a field of space is among the claims; one that is only held beside a law of the
// instrument is none.
bool may_be_field(const TraceResult& trace) {
  return std::ranges::any_of(trace.effects, [](const TracedEffect& traced) {
    return is_distortion(traced.effect) || is_of_no_rigid_arm(traced);
  });
}

// The fit without the effects of no rigid arm.
CalibrationResult without_doubtful(const TraceResult& trace, const Campaign& campaign) {
  const CalibrationResult& fit = trace.fit;
  Robot robot = fit.robot;
  for (size_t k = trace.effects.size(), last = robot.effects.size(); k-- > 0;)
    if (is_of_no_rigid_arm(trace.effects[k]))
      robot.effects.erase(robot.effects.begin() +
                          static_cast<std::ptrdiff_t>(last - trace.effects.size() + k));
  CalibrationOptions near;
  near.start_near(fit);
  return calibrate(robot, campaign, fit.set, near);
}

// By how much more the readings speak for a model that has a field of space in the place of what no
// rigid arm does: twice the log of the odds, random effects of arm and station beside both.
double evidence_of_field(const Campaign& timed, const JudgedTraining& judged) {
  const TraceResult& trace = judged.training.trace;
  const CalibrationResult rival = std::ranges::any_of(trace.effects, is_of_no_rigid_arm)
                                      ? without_doubtful(trace, *judged.training.sound)
                                      : trace.fit;
  return beside_groups(rival, timed, trace.fit, true).evidence - judged.random.evidence;
}

// Gives the arm what no rigid arm does.
void settle_doubts(TraceResult& trace) {
  Robot& robot = trace.fit.robot;
  const auto settle = [](Effect& effect) {
    effect.may_be_instrument = false;
    effect.mean = 0;
  };
  const size_t first = robot.effects.size() - trace.effects.size();
  for (size_t k = 0; k < trace.effects.size(); ++k) {
    if (!is_of_no_rigid_arm(trace.effects[k])) continue;
    settle(robot.effects[first + k]);
    settle(trace.stages.back().robot.effects[first + k]);
    settle(trace.effects[k].effect);
  }
}

// Fits base, tool and targets alone.
void place(const Campaign& campaign, Robot& robot) {
  Robot placed = robot;
  placed.identify = {"base", "tool"};
  placed.identify_per_session.clear();
  CalibrationOptions options;
  options.statistics = FitStatistics::weights;
  options.fitted_effects = 0;
  placed = calibrate(placed, campaign, options).robot;
  robot.chain.base = placed.chain.base;
  robot.chain.tool = placed.chain.tool;
  robot.chain.targets = placed.chain.targets;
  for (auto& [name, session] : robot.sessions) session.base = placed.sessions.at(name).base;
}

}  // namespace

JudgedTraining judged_training(const Robot& robot, const Campaign& given, Then then,
                               const Catalogue& catalogue, const TraceOptions& options) {
  const auto searched = [&](const Catalogue& among) {
    JudgedTraining judged{search_training(robot, given, then, among, options), {}};
    if (judged.training.trace.left_out) return judged;
    const CalibrationResult& fit = judged.training.trace.fit;
    judged.random = beside_groups(fit, in_order_of_visits(*judged.training.sound), fit);
    return judged;
  };
  const Catalogue rigid = without_distortion(catalogue);
  JudgedTraining judged = searched(rigid);
  TraceResult& trace = judged.training.trace;
  if (trace.left_out) return judged;
  const Campaign timed = in_order_of_visits(*judged.training.sound);
  const double of_field = evidence_of_field(timed, judged);
  const bool has_law = std::ranges::any_of(trace.effects, [](const TracedEffect& traced) {
    return owner_of(traced.effect) == Owner::instrument;
  });
  if (rigid.size() < catalogue.size() && (of_field > kRuledOut || has_law)) {
    if (options.progress) options.progress("searching with a distortion of the instrument");
    JudgedTraining bent = searched(catalogue);
    const bool is_comparable =
        rows_of(bent.training.gross_poses) == rows_of(judged.training.gross_poses);
    const CalibrationResult &other = bent.training.trace.fit, &fit = trace.fit;
    // The law of readings of each model speaks for it, so both are asked.
    const auto speaks = [&](const CalibrationResult& law) {
      const double own = (&law == &other ? bent.random : beside_groups(other, timed, law)).evidence;
      return own - (&law == &fit ? judged.random : beside_groups(fit, timed, law)).evidence;
    };
    if (!may_be_field(bent.training.trace) ||
        (is_comparable && 0.5 * (speaks(fit) + speaks(other)) > kRuledOut))
      return bent;
  }
  if (of_field <= 0) settle_doubts(trace);
  return judged;
}

void fall_back_to_geometry(JudgedTraining& judged) {
  fall_back_to_geometry(judged.training);
  const CalibrationResult& fit = judged.training.trace.fit;
  judged.random = beside_groups(fit, in_order_of_visits(*judged.training.sound), fit);
}

CalibrationResult applied_arm(const JudgedTraining& judged) {
  const CalibrationResult& fit = judged.training.trace.fit;
  const Campaign& sound = *judged.training.sound;
  CalibrationResult result = beside(fit, in_order_of_visits(sound), judged.random);
  std::vector<Effect>& effects = result.robot.effects;
  effects.resize(effects.size() - judged.random.of_campaign.size());
  if (!judged.random.of_campaign.empty()) place(sound, result.robot);
  return result;
}

}  // namespace armtrue
