#include "tracing/judged_names.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "armtrue/effects/posture.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/parameters.h"
#include "search/candidates.h"

namespace armtrue {
namespace {

const double kRuledOut = 2 * std::log(1000.0), kWorthASearch = 2 * std::log(30.0);

bool is_distortion(const Effect& effect) { return is_polynomial(effect.shape); }

// Random effects beside a fit, under the law of readings of another; with errors of the instrument
// if a catalogue is given.
RandomEffects beside_groups(const CalibrationResult& fit, const Campaign& timed,
                            const CalibrationResult& law, const Catalogue* of_instrument = nullptr,
                            const std::vector<Parameter>& wandering = {}) {
  std::vector<EffectGroup> groups = effect_groups(fit.robot, timed);
  if (EffectGroup walk = random_walk(fit.robot, timed, wandering); !walk.effects.empty())
    groups.push_back(std::move(walk));
  if (of_instrument)
    std::ranges::move(errors_of_instrument(fit.robot, timed, *of_instrument),
                      std::back_inserter(groups));
  return random_effects(fit, timed, groups, law);
}

// Whether an effect is doubtful only because no rigid arm has it: not because it follows time or
// the payload, with which what is fastened to the flange may have changed, nor because a law of the
// instrument could take its place.
bool is_of_no_rigid_arm(const TracedEffect& traced) {
  const Driver& driver = traced.effect.driver;
  return traced.effect.may_be_instrument && !driver.follows_course() &&
         driver.kind != DriverKind::payload &&
         std::ranges::none_of(traced.indistinguishable, [](const Rival& rival) {
           return owner_of(rival.effect) == Owner::instrument && !is_distortion(rival.effect);
         });
}

// The fit without some of the effects that were found.
CalibrationResult without_those(const TraceResult& trace, const Campaign& campaign,
                                const std::function<bool(const TracedEffect&)>& goes) {
  const CalibrationResult& fit = trace.fit;
  Robot robot = fit.robot;
  for (size_t k = trace.effects.size(), last = robot.effects.size(); k-- > 0;)
    if (goes(trace.effects[k]))
      robot.effects.erase(robot.effects.begin() + (last - trace.effects.size() + k));
  CalibrationOptions near;
  near.start_near(fit);
  return calibrate(robot, campaign, fit.set, near);
}

// Whether an error of the instrument could explain the readings better than an effect.
bool has_better_rival(const TracedEffect& traced) {
  return std::ranges::any_of(traced.indistinguishable, [](const Rival& rival) {
    return is_lasting_of_instrument(rival.effect) && rival.delta_ebic < 0;
  });
}

// Whether the geometry beside random errors of the instrument explains the readings better than
// what was found, with and without such errors beside it: then axes of the instrument that have
// different scales, or another distortion, were taken for effects of the arm. All under the law of
// readings of what was found.
bool is_error_of_instrument(const TraceResult& trace, const Campaign& timed,
                            const Catalogue& catalogue, double found, double found_beside) {
  const bool of_posture = std::ranges::all_of(
      trace.effects, [](const TracedEffect& traced) { return is_of_posture(traced.effect); });
  if (trace.effects.empty() || !of_posture) return false;  // a distortion of space knows no time
  const double geometry =
      beside_groups(trace.stages.front(), timed, trace.fit, &catalogue).evidence;
  return geometry - found > kRuledOut && geometry > found_beside;
}

// Assigns the effects that no rigid arm has to the arm.
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

bool is_of_time(const TracedEffect& traced) {
  return traced.effect.driver.kind == DriverKind::time && !traced.effect.driver.factor;
}

// Parameters of the arm that so many effects of time move or more, a step among them. A curve
// beside a step is several: a zero that jumps has none between its jumps.
std::vector<Parameter> moved_in_time(const TraceResult& trace, int least) {
  std::vector<Parameter> moved;
  const auto number_of_changes = [&](const Parameter& parameter) {
    int changes = 0;
    for (const TracedEffect& other : trace.effects)
      if (is_of_time(other) && other.effect.parameter == parameter)
        changes += other.effect.shape.kind == ShapeKind::series ? 2 : 1;
    return changes;
  };
  for (const TracedEffect& step : trace.effects) {
    const Parameter& parameter = step.effect.parameter;
    if (is_of_time(step) && step.effect.shape.kind == ShapeKind::step &&
        moved_by(step.effect) == Moved::arm && std::ranges::count(moved, parameter) == 0 &&
        number_of_changes(parameter) >= least)
      moved.push_back(parameter);
  }
  return moved;
}

// Twice the log of how much likelier the effects of time of such parameters are than a random walk
// of these, under one law of readings. The time of a step is one of those of the readings.
double likelier_than_a_walk(const TraceResult& trace, const CalibrationResult& without,
                            const Campaign& sound, const Catalogue* of_instrument,
                            const std::vector<Parameter>& moved) {
  double of_times = 0;
  for (const TracedEffect& traced : trace.effects)
    if (is_of_time(traced) && traced.effect.shape.kind == ShapeKind::step &&
        std::ranges::count(moved, traced.effect.parameter) > 0)
      of_times += 2 * std::log(static_cast<double>(sound.rows()));
  return beside_groups(trace.fit, sound, trace.fit, of_instrument).evidence - of_times -
         beside_groups(without, sound, trace.fit, of_instrument, moved).evidence;
}

// Finds the parameters that wander, leaves their effects of time out, and lets a random effect walk
// in their place. Who masters a joint by mistake masters it once more; a third change is no event.
void judge_walks(JudgedTraining& judged, const Catalogue& catalogue, const TraceOptions& options) {
  TraceResult& trace = judged.training.trace;
  constexpr int kEvents = 2;
  std::vector<Parameter> moved = moved_in_time(trace, kEvents);
  if (moved.empty()) return;
  const auto is_in_place = [&](const TracedEffect& traced) {
    return is_of_time(traced) && std::ranges::count(moved, traced.effect.parameter) > 0;
  };
  const Campaign& sound = *judged.training.sound;
  const Catalogue* of_instrument = judged.instrument_errs ? &catalogue : nullptr;
  const std::vector<Parameter> often = moved_in_time(trace, kEvents + 1);
  if (often.size() < moved.size() &&
      likelier_than_a_walk(trace, without_those(trace, sound, is_in_place), sound, of_instrument,
                           moved) > kRuledOut)
    moved = often;
  if (moved.empty()) return;
  for (size_t k = trace.effects.size(); k-- > 0;)
    if (is_in_place(trace.effects[k])) leave_out_effect(judged.training, k, options);
  judged.wandering = moved;
  judged.random =
      random_effects_beside(judged.instrument_errs ? without_laws(trace.fit, sound) : trace.fit,
                            sound, of_instrument, moved);
}

// Takes the last effects off a robot, so many; its constants get their means over the campaign.
void hold_at_means(const CalibrationResult& fit, const Campaign& campaign, size_t effects,
                   Robot& robot) {
  Robot with = robot;
  with.effects.erase(with.effects.begin(), with.effects.end() - effects);
  robot.effects.resize(robot.effects.size() - effects);
  const RobotModel model(with, campaign.temperature_names);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(parameter_count(robot.chain));
  double weights = 0;
  for (int row = 0; row < campaign.rows(); ++row) {
    sum += fit.weights[row] * model.offsets(campaign.context(row));
    weights += fit.weights[row];
  }
  if (weights <= 0) return;
  const ParameterLayout layout = layout_of(robot.chain);
  for (int k = kFirstLinkParameter; k < layout.tool; ++k) {
    move_parameter(robot.chain, k, sum[k] / weights);
    for (auto& [name, session] : robot.sessions) {
      const auto zero = session.zero.find(link_of_parameter(k));
      if (zero != session.zero.end() && is_zero_offset(robot.chain, k))
        zero->second += sum[k] / weights;
    }
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

// Searched with errors of the instrument, or without.
JudgedTraining judged_laws(const Robot& robot, const Campaign& given, Then then,
                           const Catalogue& catalogue, const TraceOptions& options) {
  TraceOptions of_search = options;
  const auto searched = [&](bool instrument_may_err) {
    of_search.instrument_may_err = instrument_may_err;
    JudgedTraining judged{search_training(robot, given, then, catalogue, of_search), {}, {}};
    if (judged.training.trace.left_out) return judged;
    judged.random = random_effects_beside(judged.training.trace.fit, *judged.training.sound);
    return judged;
  };
  JudgedTraining judged = searched(false);
  TraceResult& trace = judged.training.trace;
  if (trace.left_out) return judged;
  const Campaign timed = in_order_of_visits(*judged.training.sound);
  if (errors_of_instrument(robot, timed, catalogue).empty()) return judged;
  // Effects that no rigid arm has could be errors of the instrument.
  const bool has_doubts = std::ranges::any_of(trace.effects, is_of_no_rigid_arm);
  const CalibrationResult& fit = trace.fit;
  const RandomEffects erring = beside_groups(fit, timed, fit, &catalogue);
  const double of_error =
      (has_doubts ? beside_groups(without_those(trace, *judged.training.sound, is_of_no_rigid_arm),
                                  timed, fit, &catalogue)
                        .evidence
                  : erring.evidence) -
      judged.random.evidence;
  const double without_law = std::max(judged.random.evidence, erring.evidence);
  if (of_error > kWorthASearch || std::ranges::any_of(trace.effects, has_better_rival)) {
    if (options.progress) options.progress("searching with errors of the instrument");
    JudgedTraining lawful = searched(true);
    const CalibrationResult& with = lawful.training.trace.fit;
    // Each model fits best under its own law of readings, so both laws are tried. Only models of
    // the same readings are comparable.
    const auto odds = [&] {
      const double by_its_own =
          lawful.random.evidence - std::max(beside_groups(fit, timed, with).evidence,
                                            beside_groups(fit, timed, with, &catalogue).evidence);
      const double by_other = beside_groups(with, timed, fit).evidence - without_law;
      return 0.5 * (by_its_own + by_other);
    };
    if (rows_of(lawful.training.gross_poses) == rows_of(judged.training.gross_poses) &&
        odds() > kRuledOut) {
      // A law is dropped if random errors of the instrument explain the readings as well: the arm
      // is then that of the model with random errors.
      RandomEffects lawless =
          beside_groups(without_laws(with, *lawful.training.sound), timed, with, &catalogue);
      if (lawful.random.evidence - lawless.evidence < kRuledOut) {
        lawful.random = std::move(lawless);
        lawful.instrument_errs = true;
      }
      return lawful;
    }
  }
  if (is_error_of_instrument(trace, timed, catalogue, judged.random.evidence, erring.evidence)) {
    fall_back_to_geometry(judged.training);
    judged.random =
        beside_groups(judged.training.trace.fit, timed, judged.training.trace.fit, &catalogue);
    judged.instrument_errs = true;
    return judged;
  }
  if (of_error <= 0) settle_doubts(trace);
  return judged;
}

}  // namespace

JudgedTraining judged_training(const Robot& robot, const Campaign& given, Then then,
                               const Catalogue& catalogue, const TraceOptions& options) {
  JudgedTraining judged = judged_laws(robot, given, then, catalogue, options);
  judge_walks(judged, catalogue, options);
  return judged;
}

void fall_back_to_geometry(JudgedTraining& judged) {
  fall_back_to_geometry(judged.training);
  judged.instrument_errs = false;
  judged.random = random_effects_beside(judged.training.trace.fit, *judged.training.sound, nullptr,
                                        judged.wandering);
}

RandomEffects random_effects_beside(const CalibrationResult& fit, const Campaign& campaign,
                                    const Catalogue* of_instrument,
                                    const std::vector<Parameter>& wandering) {
  return beside_groups(fit, in_order_of_visits(campaign), fit, of_instrument, wandering);
}

CalibrationResult without_laws(const CalibrationResult& fit, const Campaign& campaign) {
  Robot robot = fit.robot;
  if (std::erase_if(robot.effects, is_lasting_of_instrument) == 0) return fit;
  CalibrationOptions near;
  near.start_near(fit);
  return calibrate(robot, campaign, fit.set, near);
}

std::optional<Robot> arm_alone(const Robot& result, const Campaign& campaign) {
  if (std::ranges::all_of(result.effects,
                          [](const Effect& effect) { return moves_program(effect, false); }))
    return std::nullopt;
  Robot rest = result;
  std::vector<Effect> of_wires;
  std::erase_if(rest.effects, [&](const Effect& effect) {
    const bool is_of_wire = owner_of(effect) == Owner::anchor;
    if (is_of_wire) of_wires.push_back(effect);
    return is_of_wire;
  });
  Robot alone = without_station_effects(std::move(rest), false);
  alone.effects.insert(alone.effects.end(), of_wires.begin(), of_wires.end());
  place(campaign, alone);
  return alone;
}

CalibrationResult without_campaign(CalibrationResult all, const Campaign& timed,
                                   const RandomEffects& random) {
  if (random.of_campaign.empty()) return all;
  hold_at_means(all, timed, random.of_campaign.size(), all.robot);
  place(timed, all.robot);
  return all;
}

CalibrationResult applied_arm(const CalibrationResult& fit, const Campaign& campaign,
                              const RandomEffects& random) {
  const Campaign timed = in_order_of_visits(campaign);
  return without_campaign(beside(fit, timed, random), timed, random);
}

}  // namespace armtrue
