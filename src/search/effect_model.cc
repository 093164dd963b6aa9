#include "search/effect_model.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/refit.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/observation/registration.h"
#include "search/candidates.h"
#include "search/ebic.h"

namespace armtrue {
namespace {

// The place of a parameter in an order that no name decides: by the number of its link, target,
// anchor or contact in the chain, then by the name of the component.
auto place_of(const Parameter& parameter, const KinematicChain& chain) {
  const auto number_among = [&](const auto& owners) {
    return std::ranges::find(owners, parameter.of, [](const auto& owner) { return owner.name; }) -
           owners.begin();
  };
  const auto number = [&]() -> std::ptrdiff_t {
    switch (parameter.owner) {
      case Owner::link:
        return number_among(chain.links);
      case Owner::target:
        return number_among(chain.targets);
      case Owner::anchor:
        return number_among(chain.anchors);
      case Owner::beam:
      case Owner::board:
      case Owner::camera:
      case Owner::contact:
        return number_among(chain.contacts);
      case Owner::arm:
      case Owner::base:
      case Owner::coupling:
      case Owner::instrument:
      case Owner::several:
      case Owner::tool:
        break;
    }
    return 0;
  }();
  return std::tuple(
      parameter.owner, number, to_string(Parameter(parameter.owner, "", parameter.component)),
      parameter.owner == Owner::several || parameter.owner == Owner::coupling ? parameter.of : "");
}

// What orders candidates that explain alike: fewer choices first, then joint angles (bending about
// the axis of a joint is its compliance), then the place. The order in files does not matter.
auto preference(const Candidate& candidate, const KinematicChain& chain) {
  const Effect& effect = candidate.effect;
  const bool is_joint = is_link_parameter(effect.parameter, LinkParameter::theta);
  const Driver& driver = effect.driver;
  const Shape& shape = effect.shape;
  return std::tuple(candidate.log_choices, !is_joint, place_of(effect.parameter, chain),
                    driver.kind, driver.joint, driver.second_joint, driver.where, driver.factor,
                    shape.kind, shape.harmonic, shape.basis, shape.count, shape.at, shape.tau,
                    shape.low, shape.high);
}

// The preferred first. Each is described once, because that takes longer than the comparisons.
std::vector<Candidate> by_preference(std::vector<Candidate> candidates,
                                     const KinematicChain& chain) {
  std::vector<decltype(preference(candidates.front(), chain))> keys;
  for (const Candidate& candidate : candidates) keys.push_back(preference(candidate, chain));
  std::vector<std::size_t> order(candidates.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(
      order, {}, [&](std::size_t k) -> const auto& { return keys[k]; });
  std::vector<Candidate> sorted;
  for (std::size_t k : order) sorted.push_back(std::move(candidates[k]));
  return sorted;
}

// The errors of an instrument that distorts space are a few times its noise. If the geometry leaves
// ten times the noise, the arm is the cause, and a distortion would only imitate it.
bool may_be_distortion(const CalibrationResult& geometry, const Campaign& campaign) {
  constexpr double kMaxTimesNoise = 10;
  const NoiseFloor noise =
      noise_floor(geometry.robot, campaign, evaluate(geometry.robot, campaign));
  return noise.source == NoiseFloor::Source::none ||
         geometry.sigma.position < kMaxTimesNoise * noise.position;
}

// Share of the variance of a parameter without a prior that comes from the priors of others.
double share_of_priors(const CalibrationResult& fit, int parameter) {
  const auto k = std::ranges::find(fit.set.kept, parameter) - fit.set.kept.begin();
  const Eigen::VectorXd with = fit.inverse_root * fit.inverse_root.row(k).transpose();
  return with.cwiseProduct(fit.prior_weight).squaredNorm() / with[k];
}

// Whether the readings show the coordinates of the tool, and not what priors say of the small
// angles. Where these and a coordinate show by their product alone, it grows as the angles near
// zero: beyond the length of the arm, which no tool has.
bool shows_tool(const CalibrationResult& fit) {
  constexpr double kFewOfPriors = 0.1;  // pull by less than a third of the standard deviation
  double arm = 0;
  for (const Link& link : fit.robot.chain.links) arm += std::abs(link.d) + std::abs(link.r);
  return fit.robot.chain.tool.translation.norm() < arm &&
         std::ranges::all_of(fit.set.by_small_angles, [&](int parameter) {
           return share_of_priors(fit, parameter) < kFewOfPriors;
         });
}

// Candidates of the catalogue and, if asked for, beyond it.
std::vector<Candidate> all_candidates(const Robot& robot, const Campaign& campaign,
                                      const Catalogue& catalogue, const TraceOptions& options) {
  std::vector<Candidate> candidates = catalogue_candidates(catalogue, robot, campaign);
  std::vector<Candidate> families = family_candidates(candidates, robot, campaign);
  // The coefficients of a group are a family of their own.
  for (Candidate& alone : candidates)
    if (!is_group(alone.effect.parameter)) alone.effect.family.reset();
  std::ranges::move(families, std::back_inserter(candidates));
  if (options.beyond_catalogue) {
    const std::ptrdiff_t first = candidates.size();
    const auto known = std::ranges::count_if(candidates, may_be_alone);
    for (const Candidate& candidate : open_candidates(robot, campaign))
      candidates.push_back(candidate);
    // A search beyond the catalogue has tried the catalogue too.
    for (Candidate& open : std::ranges::subrange(candidates.begin() + first, candidates.end()))
      open.log_choices = std::log(std::exp(open.log_choices) + static_cast<double>(known));
  }
  return by_preference(std::move(candidates), robot.chain);
}

}  // namespace

EffectModel::EffectModel(const Robot& robot, const Campaign& campaign, const Catalogue& catalogue,
                         const TraceOptions& options)
    : campaign_(campaign),
      options_(options),
      file_(robot.chain),
      declared_(static_cast<int>(robot.effects.size())) {
  if (options.progress) options.progress("fitting the geometry");
  as_filed_ = calibrate(robot, campaign);
  fit_ = as_filed_;
  // A constant that is far off and not in the fit looks like an effect. It becomes a constant of
  // the fit if the readings show it and it leaves only noise; otherwise it would absorb a part of
  // the effects.
  const IdentifiableSet free = with_tool_of_small_angles(as_filed_.robot, campaign, as_filed_.set);
  if (!free.by_small_angles.empty())
    if (CalibrationResult all = calibrate(robot, campaign, free);
        assess(all, campaign).leaves_noise() == true && shows_tool(all))
      fit_ = std::move(all);
  Catalogue known = catalogue;
  if (!may_be_distortion(fit_, campaign))
    std::erase_if(known, [](const CatalogueEntry& entry) { return is_polynomial(entry.shape); });
  const std::vector<Candidate> candidates = all_candidates(robot, campaign, known, options);
  // Moments and forces are along the axes of R_A, so each base must keep its place.
  const Robot start = starting_robot(robot, campaign, fit_.set.kept);
  scan_ = std::make_unique<CandidateScan>(candidates, start, in_common_frame(campaign, start));
  if (candidates.empty())
    throw std::invalid_argument(
        campaign.source +
        ": no effect of the catalogue can be looked for in these measurements, which lack the "
        "columns of its drivers (t_s, temp_..._c, payload_kg, fx_n, dir1, tau1_nm, ...); log "
        "them, take another catalogue or search beyond it (without --only-catalogue)");
}

std::optional<Candidate> EffectModel::finest_distortion() const {
  std::optional<Candidate> finest;
  for (const Candidate& candidate : scan_->candidates())
    if (is_polynomial(candidate.effect.shape) &&
        (!finest || finest->effect.shape.count < candidate.effect.shape.count))
      finest = candidate;
  return finest;
}

bool EffectModel::contains(const Effect& effect) const {
  const auto& effects = fit_.robot.effects;
  return std::any_of(effects.begin(), effects.end(), [&](const Effect& other) {
    return same_form(other, effect) ||
           std::ranges::any_of(other.members,
                               [&](const Effect& member) { return same_form(member, effect); });
  });
}

bool EffectModel::is_allowed(int k) const {
  return is_allowed(chosen_[k], fit_.robot.effects[in_fit(k)].coefficients);
}

bool EffectModel::is_allowed(const Candidate& candidate,
                             const std::vector<Coefficient>& fitted) const {
  if (fitted.size() != 1) return true;
  if (candidate.only_positive && fitted.front().value <= 0) return false;
  if (candidate.furthest == 0) return true;
  const CandidateScan scan({candidate}, fit_.robot, in_common_frame(campaign_, fit_.robot));
  return scan.is_allowed(0, Eigen::VectorXd::Constant(1, fitted.front().value));
}

// The candidate that is the effect of a family alone, with its inner values, which were settled for
// the family.
Candidate EffectModel::alone(const Effect& single) const {
  Candidate candidate = *std::ranges::find_if(scan_->candidates(), [&](const Candidate& other) {
    return other.of_family == single.family->name && other.effect.members.empty() &&
           same_place(other.effect, single) && other.effect.shape.kind == single.shape.kind;
  });
  candidate.effect.shape = single.shape;
  candidate.effect.family = single.family;
  return candidate;
}

void EffectModel::add(const Candidate& candidate, double p) {
  std::vector<Effect> coefficients = fit_.robot.effects;
  // A family takes the place of its members.
  std::vector<int> members;
  for (int k = 0; k < chosen_count(); ++k)
    if (std::ranges::any_of(candidate.effect.members, [&](const Effect& member) {
          return same_form(member, chosen_[k].effect);
        }))
      members.push_back(k);
  remove(members, coefficients);
  p_at_gate_.push_back(p);
  chosen_.push_back(candidate);
  refit(coefficients);
  drop_impossible_members(chosen_count() - 1);
}

// Removes the members that their law does not allow from a family, the largest first.
void EffectModel::drop_impossible_members(int k) {
  const auto is_bounded = [](const Candidate& candidate) {
    return candidate.only_positive || candidate.furthest != 0 || candidate.alike;
  };
  while (is_bounded(chosen_[k]) && chosen_[k].effect.members.size() > 1) {
    complete();
    Effect& family = chosen_[k].effect;
    const Effect& fitted = fit_.robot.effects[in_fit(k)];
    Eigen::Index first = 0;
    std::optional<size_t> worst;
    double most = 0;
    const std::vector<double> t = t_of_members(k);
    const double strongest =
        *std::ranges::max_element(t, {}, [](double one) { return std::abs(one); });
    for (size_t m = 0; m < family.members.size(); ++m) {
      const size_t count = fitted.members[m].coefficients.size();
      const Coefficient& c = fitted.coefficients[first];
      const bool may_be =
          is_allowed(alone(family.members[m]), {c}) && !(chosen_[k].alike && t[m] * strongest < 0);
      if (count == 1 && std::abs(t[m]) > most && !may_be) {
        most = std::abs(t[m]);
        worst = m;
      }
      first += count;
    }
    if (!worst) return;
    family.members.erase(family.members.begin() + *worst);
    refit({});
  }
}

// The largest value over standard deviation among the coefficients of each member of a family, with
// its sign. The fit is complete.
std::vector<double> EffectModel::t_of_members(int k) const {
  const Effect& fitted = fit_.robot.effects[in_fit(k)];
  std::vector<double> t;
  Eigen::Index coefficient = 0;
  for (const Effect& member : fitted.members) {
    double& largest = t.emplace_back(0);
    for (size_t c = 0; c < member.coefficients.size(); ++c, ++coefficient) {
      const double own = fitted.coefficients[coefficient].value /
                         std::max(1e-300, standard_deviation(in_fit(k), coefficient));
      if (std::abs(own) > std::abs(largest)) largest = own;
    }
  }
  return t;
}

int EffectModel::members_shown(int k) {
  complete();
  const double least = std::sqrt(std::log(linear().residual_freedom()));
  return static_cast<int>(
      std::ranges::count_if(t_of_members(k), [&](double t) { return std::abs(t) > least; }));
}

// Standard deviation of a coefficient of an effect of the model.
double EffectModel::standard_deviation(int effect, Eigen::Index coefficient) const {
  Eigen::Index first = fit_.set.kept.size();
  for (int e = 0; e < effect; ++e) first += fit_.robot.effects[e].coefficients.size();
  return std::sqrt(fit_.covariance(first + coefficient, first + coefficient));
}

bool EffectModel::split_families() {
  std::vector<Effect> start = fit_.robot.effects;
  bool found = false;
  for (;;) {
    const auto family = std::ranges::find_if(
        chosen_, [](const Candidate& candidate) { return !candidate.effect.members.empty(); });
    if (family == chosen_.end()) break;
    found = true;
    const int k = static_cast<int>(family - chosen_.begin());
    const std::optional<double> p = p_at_gate_[k];
    const std::vector<Effect> singles = single_effects(start[in_fit(k)]);
    remove({k}, start);
    for (const Effect& single : singles) {
      chosen_.push_back(alone(single));
      p_at_gate_.push_back(p);
      start.push_back(single);
    }
  }
  if (found) refit(start);
  return found;
}

void EffectModel::hold(const std::vector<int>& ascending) {
  std::vector<Effect>& effects = fit_.robot.effects;
  for (auto k = ascending.rbegin(); k != ascending.rend(); ++k) {
    const auto first = effects.begin() + declared_;
    std::rotate(first, first + *k, first + *k + 1);
    ++declared_;
    chosen_.erase(chosen_.begin() + *k);
    p_at_gate_.erase(p_at_gate_.begin() + *k);
  }
  refit(std::vector<Effect>(effects));
}

void EffectModel::exchange(int k, const Candidate& candidate) {
  std::vector<Effect> coefficients = fit_.robot.effects;
  chosen_[k] = candidate;
  p_at_gate_[k] = std::nullopt;
  coefficients[in_fit(k)] = {};
  refit(coefficients);
  drop_impossible_members(k);
}

void EffectModel::drop(const std::vector<int>& ascending) {
  std::vector<Effect> coefficients = fit_.robot.effects;
  remove(ascending, coefficients);
  refit(coefficients);
}

void EffectModel::merge(const std::vector<int>& ascending, const Candidate& candidate) {
  std::vector<Effect> coefficients = fit_.robot.effects;
  remove(ascending, coefficients);
  chosen_.push_back(candidate);
  p_at_gate_.push_back(std::nullopt);
  refit(coefficients);
}

void EffectModel::settle(const std::vector<Candidate>& candidates) {
  chosen_ = candidates;
  refit({});
}

std::optional<CalibrationResult> EffectModel::settle_tool() {
  const std::vector<int> coordinates = fit_.set.by_small_angles;
  if (coordinates.empty()) return std::nullopt;
  complete();
  const int tool = layout_of(file_).tool;
  const double charge = std::log(campaign_.rows() * campaign_.reading_size().all());
  Eigen::Vector3d& place = fit_.robot.chain.tool.translation;
  for (const int parameter : coordinates) {
    const auto k = std::ranges::find(fit_.set.kept, parameter) - fit_.set.kept.begin();
    const double change = place[parameter - tool] - file_.tool.translation[parameter - tool];
    if (change * change > charge * fit_.covariance(k, k)) return std::nullopt;
  }
  for (const int parameter : coordinates)
    place[parameter - tool] = file_.tool.translation[parameter - tool];
  fit_.set = as_filed_.set;
  refit(std::vector<Effect>(fit_.robot.effects));
  return as_filed_;
}

void EffectModel::complete_in_order(const std::vector<int>& order) {
  if (std::ranges::is_sorted(order)) return complete();
  const std::vector<Candidate> chosen = chosen_;
  const auto p_at_gate = p_at_gate_;
  std::vector<Effect> in_order = fit_.robot.effects;
  for (int k = 0; k < std::ssize(order); ++k) {
    chosen_[k] = chosen[order[k]];
    p_at_gate_[k] = p_at_gate[order[k]];
    in_order[in_fit(k)] = fit_.robot.effects[in_fit(order[k])];
  }
  start_from(in_order);
  complete();
}

void EffectModel::remove(const std::vector<int>& ascending, std::vector<Effect>& coefficients) {
  for (auto k = ascending.rbegin(); k != ascending.rend(); ++k) {
    chosen_.erase(chosen_.begin() + *k);
    p_at_gate_.erase(p_at_gate_.begin() + *k);
    coefficients.erase(coefficients.begin() + declared_ + *k);
  }
}

// Refits the geometry and all effects, see start_from().
void EffectModel::refit(const std::vector<Effect>& start) {
  start_from(start);
  fit_ = armtrue::refit(start_, campaign_, near_, kSearchTolerance, CalibrationOptions{}.max_rounds,
                        !by_least_squares_);
}

void EffectModel::fit_by_least_squares(bool by_least_squares) {
  by_least_squares_ = by_least_squares;
  refit({});
}

// Lets the next fit start from the coefficients of `start`, or of the present fit if it is empty;
// coefficients of new effects start at zero.
void EffectModel::start_from(const std::vector<Effect>& start) {
  Robot robot = fit_.robot;
  robot.effects.resize(declared_);
  for (int k = 0; k < chosen_count(); ++k) {
    Effect effect = chosen_[k].effect;
    const auto& old = start.empty() ? fit_.robot.effects : start;
    const int place = in_fit(k);
    const BoundEffect bound(effect, robot, campaign_.temperature_names);
    const size_t count = bound.coefficient_count();
    if (place < std::ssize(old) && same_form(old[place], effect) &&
        old[place].coefficients.size() == count)
      effect.coefficients = old[place].coefficients;
    effect.coefficients.resize(count);
    robot.effects.push_back(effect);
  }
  near_ = std::exchange(fit_, {});
  start_ = std::move(robot);
  forget_view();
}

void EffectModel::forget_view() {
  linear_.reset();
  projected_.reset();
  null_scores_.clear();
  significance_.reset();
}

void EffectModel::Fitted::forget_view() {
  linear.reset();
  projected.reset();
}

void EffectModel::come_back(const Fitted& before) {
  chosen_ = before.chosen;
  p_at_gate_.resize(chosen_.size());
  fit_ = before.fit;
  near_ = before.near;
  start_ = before.start;
  linear_ = before.linear;
  projected_ = before.projected;
  null_scores_.clear();
  significance_.reset();
}

void EffectModel::complete() {
  if (fit_.covariance.size() > 0) return;
  CalibrationOptions options;
  options.start_near(near_);
  options.tolerance = kSearchTolerance;
  options.robust = !by_least_squares_;
  fit_ = calibrate(start_, campaign_, near_.set, options);
  significance_.reset();
}

const Linearization& EffectModel::linear() {
  if (!linear_) linear_ = std::make_shared<const Linearization>(fit_, campaign_);
  return *linear_;
}

EffectModel::View EffectModel::view() {
  if (!projected_) projected_ = std::make_shared<const ProjectedCandidates>(*scan_, linear());
  return {*linear_, *projected_};
}

CandidateScore EffectModel::score_of(const std::vector<int>& chosen) {
  std::vector<int> effects;
  for (int k : chosen) effects.push_back(in_fit(k));
  return score_of(chosen, linear().without(effects));
}

CandidateScore EffectModel::score_of(const std::vector<int>& chosen,
                                     const Linearization::Loss& loss) {
  double log_choices = 0;
  for (int k : chosen) log_choices += chosen_[k].log_choices;
  return armtrue::score_of(linear(), loss, is_shrunken(chosen_[chosen.front()].effect),
                           log_choices);
}

CandidateScore EffectModel::score_of_members(const std::vector<int>& chosen,
                                             const std::vector<int>& held) {
  std::vector<int> effects = held;
  for (int k : chosen) effects.push_back(in_fit(k));
  constexpr bool kIsShrunken = true;
  return armtrue::score_of(linear(), linear().without(effects), kIsShrunken,
                           chosen_[chosen.front()].log_choices);
}

std::vector<int> EffectModel::held_with(int k) const {
  std::vector<int> held;
  const std::optional<Family>& family = chosen_[k].effect.family;
  for (int effect = 0; family && effect < declared_; ++effect)
    if (const Effect& other = fit_.robot.effects[effect];
        other.family && other.family->name == family->name)
      held.push_back(effect);
  return held;
}

// The weights of the readings are those of the model with the effect, so that both sums of squares
// are of the same equations.
CandidateScore EffectModel::refitted_score_of(int k) {
  constexpr int kKeepLaw = 1;  // one round: the law of the present fit
  Robot robot = fit_.robot;
  robot.effects.erase(robot.effects.begin() + in_fit(k));
  CalibrationResult without = armtrue::refit(robot, campaign_, fit_, kSearchTolerance, kKeepLaw);
  without.weights = fit_.weights;
  without.weights_in_pose = fit_.weights_in_pose;
  without.sigma = fit_.sigma;
  without.degrees_of_freedom = fit_.degrees_of_freedom;
  const double before = Linearization(without, campaign_).residual_norm();
  CandidateScore score = score_of({k});
  score.gain = std::max(0.0, before - linear().residual_norm());
  score.score =
      ebic_fall(is_shrunken(chosen_[k].effect), chosen_[k].log_choices, score.degrees_of_freedom,
                score.gain, before, linear().residual_freedom());
  return score;
}

std::vector<CandidateScore> EffectModel::scores_of(const std::vector<Candidate>& candidates,
                                                   int effect) {
  const Robot& robot = fit_.robot;
  const CandidateScan scan(candidates, robot, in_common_frame(campaign_, robot));
  const ProjectedCandidates projected(scan, linear());
  return effect < 0 ? projected.scores() : projected.scores_without({effect});
}

ProjectedCandidates::InPlace EffectModel::in_place_of(const std::vector<Candidate>& candidates,
                                                      int effect) {
  const Robot& robot = fit_.robot;
  const CandidateScan scan(candidates, robot, in_common_frame(campaign_, robot));
  return ProjectedCandidates(scan, linear()).in_place_of(effect);
}

EffectModel::Refined EffectModel::best_of(const std::vector<Candidate>& candidates, int effect) {
  const std::vector<CandidateScore> scores = scores_of(candidates, effect);
  const int best = best_first(scores).front();
  return {candidates[best], scores[best].score, best};
}

std::optional<EffectModel::Refined> EffectModel::with_best_inner_values(const Candidate& found,
                                                                        int effect) {
  if (found.frequency_resolution > 0) return with_best_frequency(found, effect);
  const std::vector<Candidate> finer = refined_candidates(found, campaign_);
  if (finer.empty()) return std::nullopt;
  return best_of(finer, effect);
}

// By strides and then by steps: within a stride, a fortieth of the resolution, the score has one
// maximum.
EffectModel::Refined EffectModel::with_best_frequency(const Candidate& found, int effect) {
  constexpr int kStride = 10;
  const int strides =
      best_of(cycles_near(found, -kFinerSteps, kFinerSteps, kStride), effect).number;
  const int middle = kStride * strides - kFinerSteps;
  const int first = std::max(middle - kStride + 1, -kFinerSteps);
  const int last = std::min(middle + kStride - 1, kFinerSteps);
  return best_of(cycles_near(found, first, last, 1), effect);
}

Candidate EffectModel::refined(const Candidate& found, int effect) {
  const std::optional<Refined> best = with_best_inner_values(found, effect);
  return best ? best->candidate : found;
}

}  // namespace armtrue
