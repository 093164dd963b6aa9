#include "search/evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "armtrue/calibration/pose_bootstrap.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"
#include "search/candidates.h"
#include "search/cross_validation.h"
#include "search/variance_shares.h"

namespace armtrue {
namespace {

constexpr double kSameProjection = 0.95;  // correlation from which two candidates are one class
// A rival that explains less than half of the variance of an effect is an addition and no
// replacement.
const double kMaxOfIt = std::sqrt(0.5);
constexpr double kSameEvidence = 6.0;  // EBIC: odds of 20 to 1
// Twice the fall of the likelihood within which 95 % of the times of a step lie. The time of a step
// is not a regular parameter: P(fall <= x) = (1 - exp(-x/2))^2 (Hansen, Econometrica 68, 2000).
const double kFallToStep95 = -2 * std::log(1 - std::sqrt(0.95));
constexpr int kRefitted = 3;  // parameters named of those that are refitted for a rival

// Whether it moves the instrument, or the base, which in the readings is the same.
bool moves_station(const Effect& effect) {
  return owner_of(effect) == Owner::instrument || owner_of(effect) == Owner::base;
}

// Contains the uncertainty of the frequency, if that was searched.
std::optional<Cycle> cycle_of(EffectModel& model, const Campaign& campaign,
                              const TraceResult& result, int chosen) {
  const int effect = model.in_fit(chosen);
  const auto poses = static_cast<int>(campaign.pose_ids.size());
  std::optional<Cycle> cycle = fixed_cycle(result.fit, result.bootstrap_draws, effect, poses);
  if (!cycle || model.chosen()[chosen].frequency_resolution == 0) return cycle;
  const Effect& e = result.fit.robot.effects[effect];
  const double sine = e.coefficients[0].value, cosine = e.coefficients[1].value;
  const double n = e.shape.harmonic;
  Effect linear = e;  // its value is that of the driver
  linear.shape = Shape{};
  const BoundEffect driver(linear, result.fit.robot, campaign.temperature_names);
  const ChainEvaluator chain(result.fit.robot.chain);
  // The derivative with respect to the frequency.
  const Linearization& fit = model.linear();
  Eigen::VectorXd column = fit.jacobian().col(*find_parameter(result.fit.robot.chain, e.parameter));
  for (int row = 0; row < fit.rows(); ++row) {
    const Replicates& replicates = fit.replicates();
    const Context context = campaign.context(replicates.reading[replicates.first[row]]);
    ArmFrames frames;
    if (driver.needs_frames()) frames = chain.link_frames(context.q);
    double x = 0;
    driver.values(context, &frames, nullptr, &x);
    column.segment(row * fit.row_size(), fit.row_size()) *=
        x * (sine * std::cos(n * x) - cosine * std::sin(n * x));
  }
  cycle->frequency_std = fit.standard_deviation(column);
  const double half_width = student_t_975(poses - 1) * cycle->frequency_std;
  cycle->frequency_ci95 = {n - half_width, n + half_width};
  return cycle;
}

// Two frequencies of a gear train that the measured travel resolves are two different effects.
bool same_claim(const Candidate& a, const Candidate& b) {
  const double resolution = std::min(a.frequency_resolution, b.frequency_resolution);
  return same_place(a.effect, b.effect) &&
         (resolution == 0 ||
          std::abs(a.effect.shape.harmonic - b.effect.shape.harmonic) < resolution);
}

bool is_behind_joints(const KinematicChain& chain, const Parameter& parameter) {
  const auto found = find_parameter(chain, parameter);
  if (!found || !layout_of(chain).is_of_links(*found)) return false;
  for (int link = link_of_parameter(*found); link < std::ssize(chain.links); ++link)
    if (chain.links[link].joint != JointKind::fixed) return false;
  return true;
}

// Whether it moves what is fastened to the last joint, and nothing in the arm: in time, or with the
// payload.
bool is_of_fastened(const Effect& effect, const KinematicChain& chain) {
  const Driver& driver = effect.driver;
  return !driver.factor && (driver.follows_course() || driver.kind == DriverKind::payload) &&
         (moved_by(effect) == Moved::fastened || is_behind_joints(chain, effect.parameter));
}

// Whether it follows the payload alone, and the tool could as well sit elsewhere under another
// load. Without such a rival it is the arm's: a load of the arm moves no instrument.
bool may_be_other_tool(const TracedEffect& traced) {
  const Driver& driver = traced.effect.driver;
  return driver.kind == DriverKind::payload && !driver.factor &&
         std::ranges::any_of(traced.indistinguishable, [&](const Rival& rival) {
           return rival.effect.driver == driver && moved_by(rival) == Moved::fastened;
         });
}

// Sets the rivals of one of the chosen effects: indistinguishable, or excluded by odds. An effect
// that occurs with others has none alone.
void list_rivals(EffectModel& model, int chosen, const ProjectedCandidates::InPlace& in_place,
                 TracedEffect& traced) {
  const int effect = model.in_fit(chosen);
  const Candidate& found = model.chosen()[chosen];
  if (found.only_together) return;
  const Linearization& fit = model.linear();
  const KinematicChain& chain = model.fit().robot.chain;
  const std::vector<Candidate>& candidates = model.scan().candidates();
  const CandidateScore own = model.score_of({chosen});
  const auto& [scores, imitations] = in_place;
  std::vector<int> listed;
  for (int k : best_first(scores)) {
    const Candidate& other = candidates[k];
    const CandidateScore& score = scores[k];
    if (same_claim(other, found) || score.degrees_of_freedom == 0) continue;
    if (!other.effect.members.empty()) continue;  // its members are rivals themselves
    if (!may_be_alone(other)) continue;
    const double correlation = std::sqrt(imitations[k].gain);
    if (correlation < kMaxOfIt) continue;
    const double behind = own.score - score.score;
    const bool simple = score.degrees_of_freedom <= std::max(2, own.degrees_of_freedom);
    if (!(simple && correlation >= kSameProjection) && behind > kSameEvidence) continue;
    if (!model.scan().is_possible(k, score.coefficients)) continue;
    if (std::any_of(listed.begin(), listed.end(),
                    [&](int rival) { return same_claim(candidates[rival], other); }))
      continue;
    listed.push_back(k);
    std::vector<std::string> refitted;
    const Eigen::VectorXd imitation =
        model.view().projected.columns(k) * imitations[k].coefficients;
    for (int unknown : fit.most_refitted(effect, imitation, kRefitted))
      refitted.push_back(parameter_name(chain, model.fit().set.kept[unknown]));
    const double by_readings = behind - 2 * (other.log_choices - found.log_choices);
    const bool ruled_out = std::min(behind, by_readings) > kRuledOut;
    (ruled_out ? traced.ruled_out : traced.indistinguishable)
        .push_back({other.effect, correlation, behind, refitted, other.separated_by,
                    other.from_catalogue, is_behind_joints(chain, other.effect.parameter)});
  }
}

// Of a member of a family that is only together: the cause alone that explains as much in its place
// by a zero of a joint. A link that was bent moves others than zeros.
std::optional<Rival> zero_in_place_of(EffectModel& model, int chosen,
                                      const ProjectedCandidates::InPlace& in_place) {
  const Candidate& found = model.chosen()[chosen];
  if (!found.only_together || !found.effect.driver.follows_course()) return std::nullopt;
  const KinematicChain& chain = model.fit().robot.chain;
  const double own = model.score_of({chosen}).score;
  const std::vector<Candidate>& candidates = model.scan().candidates();
  for (const int k : best_first(in_place.scores)) {
    const Candidate& other = candidates[k];
    const auto parameter = find_parameter(chain, other.effect.parameter);
    if (!other.from_catalogue || !other.effect.members.empty() || !may_be_alone(other) ||
        other.effect.driver != found.effect.driver ||
        other.effect.shape.kind != found.effect.shape.kind || !parameter ||
        !is_zero_offset(chain, *parameter))
      continue;
    const double correlation = std::sqrt(in_place.imitations[k].gain);
    const double behind = own - in_place.scores[k].score;
    if (correlation < kSameProjection || behind > kSameEvidence) continue;
    return Rival{other.effect, correlation, behind, {}, other.separated_by, true};
  }
  return std::nullopt;
}

// Lists these rivals where each member of a family has one.
void list_zeros(const std::vector<Candidate>& chosen,
                const std::vector<std::optional<Rival>>& zeros, std::vector<TracedEffect>& traced) {
  for (size_t k = 0; k < traced.size(); ++k) {
    bool all = zeros[k].has_value();
    for (size_t i = 0; i < traced.size(); ++i)
      all &= chosen[i].of_family != chosen[k].of_family || zeros[i].has_value();
    if (all) traced[k].indistinguishable.push_back(*zeros[k]);
  }
}

// Of a curve of a joint that gives way under gravity: the masses of the robot file, or their
// centres, that are off by some share. The joint then errs by its compliance times their torque, so
// no poses tell the two apart where the first moments of the links make such a curve.
std::optional<Rival> masses_in_place_of(const TracedEffect& traced, const Robot& robot,
                                        const Campaign& campaign) {
  const Effect& found = traced.effect;
  if (found.driver.kind != DriverKind::joint_angle || found.driver.factor || robot.bodies.empty())
    return std::nullopt;
  const auto compliance = std::ranges::find_if(robot.effects, [&](const Effect& other) {
    return other.parameter == found.parameter && other.shape.kind == ShapeKind::linear &&
           other.driver.kind == DriverKind::gravity_torque && !other.driver.factor &&
           other.coefficients.size() == 1;
  });
  if (compliance == robot.effects.end()) return std::nullopt;
  Robot of_moments = robot;
  of_moments.bodies.clear();
  const auto bound = [&](const Effect& effect, const Robot& loaded) {
    return BoundEffect(effect, loaded, campaign.temperature_names);
  };
  const BoundEffect torque = bound(*compliance, robot), curve = bound(found, robot);
  const BoundEffect moments = bound(*compliance, of_moments);
  const ChainEvaluator chain(robot.chain);
  Eigen::MatrixXd by_moments(campaign.rows(), 1 + moments.value_count());
  Eigen::VectorXd moved(campaign.rows()), torques(campaign.rows()), shapes(curve.value_count());
  Eigen::VectorXd of_row(moments.value_count());
  for (int row = 0; row < campaign.rows(); ++row) {
    const Context context = campaign.context(row);
    const ArmFrames frames = chain.link_frames(context.q);
    torque.values(context, &frames, nullptr, &torques[row]);
    moments.values(context, &frames, nullptr, of_row.data());
    by_moments.row(row) << 1, of_row.transpose();
    curve.values(context, &frames, nullptr, shapes.data());
    moved[row] = 0;
    for (Eigen::Index k = 0; k < shapes.size(); ++k)
      moved[row] += found.coefficients[k].value * shapes[k];
  }
  const Eigen::VectorXd left =
      moved - by_moments * by_moments.completeOrthogonalDecomposition().solve(moved);
  const auto spread = [](const Eigen::VectorXd& values) {
    return (values.array() - values.mean()).matrix().norm();
  };
  const double correlation =
      std::sqrt(std::max(0.0, 1 - left.squaredNorm() / std::pow(spread(moved), 2)));
  const double most =
      kMassesOff * std::abs(compliance->coefficients.front().value) * spread(torques);
  if (correlation < kSameProjection || spread(moved) > most) return std::nullopt;
  Effect masses = found;
  masses.name = "masses of the robot file";
  masses.coefficients.clear();
  return Rival{masses, correlation, 0, {}, "the weights of links and tool, or the motor torque",
               true};
}

// Score that a curve without a known cause needs, without the charge for choices, to reject the
// cause of an effect.
double score_to_beat(EffectModel& model, int chosen) {
  const Candidate& found = model.chosen()[chosen];
  if (!found.from_catalogue) return std::numeric_limits<double>::infinity();
  return model.score_of({chosen}).score + 2 * found.log_choices + kRuledOut;
}

// The time of a chosen step, and the time constant of a course, were refined; the candidates have
// those of a grid. Gives those with the same law the inner values of the chosen one, where they
// explain more.
void refine_alike(EffectModel& model, int chosen, ProjectedCandidates::InPlace& in_place) {
  const Effect& found = model.chosen()[chosen].effect;
  const Shape& shape = found.shape;
  if (!found.driver.follows_course() ||
      (shape.kind != ShapeKind::step && shape.kind != ShapeKind::exponential))
    return;
  const std::vector<Candidate>& candidates = model.scan().candidates();
  std::vector<int> alike;  // of each cause the one that explains most
  std::vector<Candidate> refined;
  for (const int k : best_first(in_place.scores)) {
    const Effect& other = candidates[k].effect;
    const auto is_same_cause = [&](const Candidate& one) {
      return one.effect.name == other.name && one.effect.parameter == other.parameter;
    };
    if (!other.members.empty() || other.driver != found.driver || other.shape.kind != shape.kind ||
        std::ranges::any_of(refined, is_same_cause))
      continue;
    alike.push_back(k);
    refined.push_back(candidates[k]);
    refined.back().effect.shape = shape;
  }
  if (refined.empty()) return;
  const ProjectedCandidates::InPlace now = model.in_place_of(refined, model.in_fit(chosen));
  for (size_t i = 0; i < alike.size(); ++i)
    if (now.scores[i].score > in_place.scores[alike[i]].score) {
      in_place.scores[alike[i]] = now.scores[i];
      in_place.imitations[alike[i]] = now.imitations[i];
    }
}

// All candidates in the place of one of the chosen effects, but those that are neither rivals nor
// curves that reject its cause.
ProjectedCandidates::InPlace candidates_in_place_of(EffectModel& model, int chosen) {
  double most_choices = 0;
  for (const Candidate& candidate : model.scan().candidates())
    most_choices = std::max(most_choices, candidate.log_choices);
  ProjectedCandidates::InPlace in_place = model.view().projected.in_place_of(
      model.in_fit(chosen), score_to_beat(model, chosen) - 2 * most_choices, kMaxOfIt * kMaxOfIt);
  refine_alike(model, chosen, in_place);
  return in_place;
}

// Whether a curve without a name, of the same parameter, explains the readings so much better that
// the cause is rejected.
bool is_beaten(EffectModel& model, int chosen, const std::vector<CandidateScore>& scores) {
  const double least = score_to_beat(model, chosen);
  const std::vector<Candidate>& candidates = model.scan().candidates();
  for (size_t k = 0; k < candidates.size(); ++k) {
    const Candidate& other = candidates[k];
    if (other.from_catalogue || other.effect.parameter != model.chosen()[chosen].effect.parameter)
      continue;
    if (scores[k].score + 2 * other.log_choices > least &&
        model.scan().is_possible(static_cast<int>(k), scores[k].coefficients))
      return true;
  }
  return false;
}

// The values that a function of one driver takes at the readings, and their range [SI].
std::vector<double> values_at_readings(const Effect& effect, const Campaign& campaign) {
  std::vector<double> values = values_of(effect.driver, campaign);
  Eigen::VectorXd of_shape(value_count(effect.shape));
  for (double& value : values) {
    evaluate(effect.shape, value, of_shape.data());
    value = 0;
    for (size_t k = 0; k < effect.coefficients.size(); ++k)
      value += effect.coefficients[k].value * of_shape[k];
  }
  return values;
}

double range_of(const std::vector<double>& values) {
  const auto [low, high] = std::ranges::minmax(values);
  return high - low;
}

// Whether the effect and others of the same driver and parameter cancel among the readings. Then
// the readings show only their sum, a curve, and none of them is a cause.
bool cancels(const Effect& effect, const std::vector<Effect>& effects, const Campaign& campaign) {
  constexpr double kMostOfSum = 2;
  if (!can_be_bounded(effect) || is_group(effect.parameter)) return false;
  std::vector<double> sum(campaign.rows());
  for (const Effect& other : effects) {
    if (!same_place(other, effect)) continue;
    const std::vector<double> values = values_at_readings(other, campaign);
    for (size_t row = 0; row < sum.size(); ++row) sum[row] += values[row];
  }
  return range_of(values_at_readings(effect, campaign)) > kMostOfSum * range_of(sum);
}

// Sorts the effects by their shares, not by the order of discovery. Effects of one parameter and
// driver count together and stay together. Completes the fit; returns the shares in that order.
std::vector<VarianceShare> order_by_share(SearchResult& search, int poses, std::uint64_t seed) {
  EffectModel& model = search.model;
  const std::vector<Candidate>& chosen = model.chosen();
  const VarianceShares found = variance_shares(model.linear().effects_from(model.in_fit(0)), seed);
  const Eigen::Index effects = chosen.size();
  const Eigen::Map<const Eigen::VectorXd> share(found.of_group.data(), effects);
  std::vector<Eigen::VectorXd> place(chosen.size(), Eigen::VectorXd::Zero(effects));
  for (size_t a = 0; a < chosen.size(); ++a)
    for (size_t b = 0; b < chosen.size(); ++b)
      place[a][b] = same_place(chosen[a].effect, chosen[b].effect);
  std::vector<int> order(chosen.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return std::pair(place[a].dot(share), found.of_group[a]) >
           std::pair(place[b].dot(share), found.of_group[b]);
  });
  const double wide = student_t_975(poses - 1);
  std::vector<VarianceShare> shares;
  for (int k : order) {
    const double half = wide * found.standard_deviation(Eigen::VectorXd::Unit(effects, k));
    const Eigen::VectorXd behind = place[order.front()] - place[k];
    shares.push_back({share[k],
                      {std::max(0.0, share[k] - half), std::min(1.0, share[k] + half)},
                      behind.dot(share) <= wide * found.standard_deviation(behind)});
  }
  model.complete_in_order(order);
  search.stages.back() = model.fit();
  return shares;
}

// The chosen effects of one coefficient whose interval holds zero: these readings do not even show
// its sign. A member of a family has the evidence of the whole family.
std::vector<int> without_sign(const EffectModel& model, const Robot& fitted) {
  std::vector<int> found;
  for (int k = 0; k < model.chosen_count(); ++k) {
    const Effect& effect = fitted.effects[model.in_fit(k)];
    if (effect.coefficients.size() != 1 || effect.family) continue;
    const auto [low, high] = effect.coefficients.front().ci95;
    if (low <= 0 && high >= 0) found.push_back(k);
  }
  return found;
}

}  // namespace

std::optional<std::array<double, 2>> step_ci95(EffectModel& model, const Campaign& campaign,
                                               int chosen) {
  const Candidate& step = model.chosen()[chosen];
  if (!has_at(step.effect.shape.kind) || step.effect.driver.kind == DriverKind::session)
    return std::nullopt;
  const std::vector<Candidate> steps = steps_anywhere(step, campaign);
  const std::vector<CandidateScore> scores = model.scores_of(steps, model.in_fit(chosen));
  double best = 0;
  for (const CandidateScore& score : scores) best = std::max(best, score.score);
  double low = step.effect.shape.at, high = low;
  for (size_t k = 0; k < steps.size(); ++k) {
    if (scores[k].score < best - kFallToStep95) continue;
    low = std::min(low, steps[k].effect.shape.at);
    high = std::max(high, steps[k].effect.shape.at);
  }
  std::array<double, 2> readings{-std::numeric_limits<double>::infinity(),
                                 std::numeric_limits<double>::infinity()};
  const Driver& driver = step.effect.driver;
  for (int row = 0; row < campaign.rows(); ++row) {
    const double place =
        driver.kind == DriverKind::time ? campaign.time_s[row] : campaign.q[row][driver.joint];
    if (place < low) readings[0] = std::max(readings[0], place);
    if (place > high) readings[1] = std::min(readings[1], place);
  }
  return readings;
}

std::optional<Cycle> fixed_cycle(const CalibrationResult& fit,
                                 const Eigen::MatrixXd& bootstrap_draws, int effect, int poses) {
  const Effect& e = fit.robot.effects[effect];
  if (e.shape.kind != ShapeKind::harmonic || e.coefficients.size() != 2) return std::nullopt;
  const double sine = e.coefficients[0].value, cosine = e.coefficients[1].value;
  Cycle cycle;
  cycle.amplitude = std::hypot(sine, cosine);
  cycle.phase = std::atan2(cosine, sine);
  Eigen::Index first = 0;
  for (int other = 0; other < effect; ++other)
    first += fit.robot.effects[other].coefficients.size();
  const Eigen::Vector2d along = Eigen::Vector2d(sine, cosine) / cycle.amplitude;
  const Eigen::Index unknown = static_cast<Eigen::Index>(fit.set.kept.size()) + first;
  const Eigen::Matrix2d covariance = fit.covariance.block<2, 2>(unknown, unknown);
  cycle.amplitude_std = std::sqrt(along.dot(covariance * along));
  const auto [low, high] =
      interval_about(bootstrap_draws.middleCols<2>(first) * along, cycle.amplitude_std, poses);
  cycle.amplitude_ci95 = {cycle.amplitude + low, cycle.amplitude + high};
  return cycle;
}

TraceResult with_evidence(SearchResult search, const Campaign& campaign,
                          const TraceOptions& options) {
  const auto poses = static_cast<int>(campaign.pose_ids.size());
  const std::vector<VarianceShare> shares = order_by_share(search, poses, options.seed);
  EffectModel& model = search.model;
  TraceResult result;
  result.fit = model.fit();
  result.stages = std::move(search.stages);
  result.ranking = std::move(search.ranking);
  result.not_separable = std::move(search.not_separable);
  result.best_score = search.best_score;
  result.null_run = search.null_run;
  result.remaining_p = search.remaining_p;
  result.pattern_remains = search.pattern_remains;
  if (shares.empty()) return result;
  if (options.progress) options.progress("searching for rivals of the effects");
  result.bootstrap_draws =
      bootstrap_coefficients(result.fit, campaign, options.bootstrap, options.seed);
  set_intervals(result.bootstrap_draws, poses, result.fit.robot);
  if (const std::vector<int> dropped = without_sign(model, result.fit.robot); !dropped.empty()) {
    model.drop(dropped);
    search.stages = std::move(result.stages);
    search.ranking = std::move(result.ranking);
    search.not_separable = std::move(result.not_separable);
    return with_evidence(std::move(search), campaign, options);
  }
  const std::vector<Candidate>& chosen = model.chosen();
  const CrossValidation left_out(model.linear(), options.seed);
  std::vector<std::optional<Rival>> zeros;
  for (int k = 0; k < model.chosen_count(); ++k) {
    TracedEffect& traced = result.effects.emplace_back();
    Effect& fitted = result.fit.robot.effects[model.in_fit(k)];
    traced.effect = fitted;
    traced.variance_share = shares[k];
    traced.cycle = cycle_of(model, campaign, result, k);
    traced.step_ci95 = step_ci95(model, campaign, k);
    traced.from_catalogue = chosen[k].from_catalogue;
    traced.separated_by = chosen[k].separated_by;
    traced.in_words = chosen[k].in_words;
    double score = model.score_of({k}).score;
    if (const std::vector<int> held = model.held_with(k); score <= 0 && !held.empty()) {
      score = model.score_of_members({k}, held).score;
      for (int effect : held) traced.shared_with.push_back(result.fit.robot.effects[effect]);
    }
    const auto in_place = candidates_in_place_of(model, k);
    const bool is_part = cancels(fitted, result.fit.robot.effects, campaign);
    // What a family explains together is not beaten by a curve that explains the part of one
    // member.
    if (is_part || (traced.shared_with.empty() && is_beaten(model, k, in_place.scores))) {
      if (!is_part) traced.beaten_cause = traced.effect.name;
      traced.from_catalogue = false;
      traced.in_words.clear();
      traced.effect.name = fitted.name = "unexplained";
    }
    traced.incomplete = std::count_if(chosen.begin(), chosen.end(), [&](const Candidate& other) {
                          return same_place(other.effect, chosen[k].effect);
                        }) > 1;
    const GainLeftOut cv = left_out.of_effect(model.in_fit(k));
    const std::optional<double> at_gate = model.p_at_gate(k);
    const double p = at_gate ? *at_gate : model.chance_of(score);
    traced.evidence = {score, p, cv.gain, cv.error};
    list_rivals(model, k, in_place, traced);
    if (const auto masses = masses_in_place_of(traced, result.fit.robot, campaign))
      traced.indistinguishable.push_back(*masses);
    zeros.push_back(zero_in_place_of(model, k, in_place));
    traced.effect.may_be_instrument = fitted.may_be_instrument =
        may_be_instrument(traced, result.fit.robot);
  }
  list_zeros(chosen, zeros, result.effects);
  return result;
}

Moved moved_by(const Effect& effect) {
  switch (owner_of(effect)) {
    case Owner::base:
    case Owner::instrument:
    case Owner::anchor:
    case Owner::beam:
    case Owner::board:
    case Owner::camera:
    case Owner::contact:
      return Moved::station;
    case Owner::tool:
    case Owner::target:
      return Moved::fastened;
    case Owner::arm:
    case Owner::link:
    case Owner::coupling:
    case Owner::several:
      break;
  }
  return Moved::arm;
}

Moved moved_by(const Rival& rival) {
  return rival.is_behind_joints ? Moved::fastened : moved_by(rival.effect);
}

bool is_other_cause(const Effect& effect, const Rival& rival) {
  const auto is_slow_or_sudden = [](const Driver& driver) {
    return !driver.factor && (driver.follows_course() || driver.kind == DriverKind::temperature);
  };
  if (is_slow_or_sudden(effect.driver) && is_slow_or_sudden(rival.effect.driver) &&
      moved_by(effect) != moved_by(rival))
    return true;
  const auto is_of_heat = [](const Driver& driver) {
    return driver.kind == DriverKind::temperature;
  };
  if (is_slow_or_sudden(effect.driver) && is_slow_or_sudden(rival.effect.driver) &&
      is_of_heat(effect.driver) != is_of_heat(rival.effect.driver) &&
      rival.delta_ebic <= kSameEvidence)
    return true;
  // What follows one joint under one name is one cause, whichever parameter shows it.
  if (effect.driver.joint >= 0 && rival.effect.name == effect.name &&
      rival.effect.driver == effect.driver)
    return false;
  return rival.from_catalogue &&
         (rival.effect.name != effect.name || rival.effect.parameter != effect.parameter);
}

bool is_unlisted_cause(const KinematicChain& chain, const Effect& effect, const Rival& rival) {
  const auto parameter = find_parameter(chain, rival.effect.parameter);
  return !rival.from_catalogue && rival.effect.parameter != effect.parameter &&
         rival.effect.driver == effect.driver && rival.delta_ebic <= kSameEvidence && parameter &&
         is_zero_offset(chain, *parameter);
}

bool is_of_instrument(const Effect& effect) {
  return !effect.driver.follows_course() &&
         (effect.may_be_instrument || owner_of(effect) == Owner::instrument);
}

bool may_be_rest_of_event(const Effect& effect, const Robot& robot) {
  const auto follows_time = [](const Effect& any) {
    return any.driver.follows_course() && !any.driver.factor;
  };
  return follows_time(effect) && !moves_station(effect) &&
         std::ranges::any_of(robot.effects, [&](const Effect& other) {
           return follows_time(other) && moves_station(other);
         });
}

bool may_be_instrument(const TracedEffect& traced, const Robot& robot) {
  const auto of_instrument = [](const Rival& rival) {
    return owner_of(rival.effect) == Owner::instrument;
  };
  if (std::ranges::any_of(traced.indistinguishable, of_instrument)) return true;
  if (may_be_rest_of_event(traced.effect, robot) && traced.evidence.delta_ebic < kRuledOut)
    return true;
  return traced.in_words.empty() &&
         (is_of_no_arm(traced.effect, robot.chain) || is_of_fastened(traced.effect, robot.chain) ||
          may_be_other_tool(traced));
}

}  // namespace armtrue
