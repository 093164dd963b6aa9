#include "armtrue/identification/tracing.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <stdexcept>
#include <tuple>

#include "armtrue/identification/evaluation.h"
#include "armtrue/identification/pose_bootstrap.h"
#include "armtrue/identification/statistics.h"
#include "candidates.h"
#include "cross_validation.h"
#include "registration.h"
#include "scan.h"
#include "sessions.h"
#include "variance_shares.h"

namespace armtrue {
namespace {

constexpr double kPossibleVariation = 0.02;  // m or rad: a larger one is no effect but a mistake
constexpr double kSameProjection = 0.95;     // correlation from which two candidates are one class
constexpr double kSameEvidence = 6.0;        // EBIC: odds of 20 to 1
// BIC: odds of a thousand to one. The price of having looked at many is none of the readings'
// doing.
const double kRuledOut = 2 * std::log(1000.0);
constexpr double kClearlyBetter = 2.0;  // EBIC, before an effect gives way to another
constexpr double kSameScore = 0.01;     // EBIC; less is rounding and the end of an iteration
// Twice the fall of the likelihood within which 95 % of the times of a step lie. A step is no
// regular parameter: P(fall <= x) = (1 - exp(-x/2))^2 (Hansen, Econometrica 68, 2000).
const double kFallToStep95 = -2 * std::log(1 - std::sqrt(0.95));
constexpr double kLackOfFit = 1e-3;  // p from which the fit clearly lacks something
constexpr int kRefitted = 3;         // parameters named of those that are refitted for a rival
constexpr double kSearchTolerance = 1e-6;  // of the cost
// Effects of one parameter and driver that look like the pieces of one curve; two may be the two
// that there are.
constexpr size_t kManyOfOnePlace = 3;
constexpr int kRevisions = 4, kSettlings = 2;
constexpr size_t kMostModels = 100;  // some times what the longest search has gone through
constexpr int kMostGatherings = 50;  // likewise
// More would find smaller effects at a cost in proportion, and only the fit needs all.
constexpr int kMostPosesOfSearch = 2000;
constexpr int kTrials = 8;  // candidates that may fail the later gates in one step

// The fewer were tried the better, then by what it is, the joint itself first: bending that turns
// about a joint's axis is its compliance. The order in files does not matter.
bool comes_before(const Candidate& a, const Candidate& b) {
  const auto key = [](const Candidate& candidate) {
    const Effect& effect = candidate.effect;
    const bool is_joint = effect.parameter.ends_with(".theta");
    const Driver& driver = effect.driver;
    const Shape& shape = effect.shape;
    return std::tuple(candidate.log_choices, !is_joint, effect.parameter, driver.kind, driver.joint,
                      driver.second_joint, driver.where, driver.factor, shape.kind, shape.harmonic,
                      shape.basis, shape.count, shape.at, shape.tau, shape.low, shape.high);
  };
  return key(a) < key(b);
}

// Amplitude and phase of an effect, if it is a harmonic, its frequency as it stands.
std::optional<Cycle> fixed_cycle(const CalibrationResult& fit, const Eigen::MatrixXd& departures,
                                 int effect, int poses) {
  const Effect& e = fit.robot.effects[effect];
  if (e.shape.kind != ShapeKind::harmonic || e.coefficients.size() != 2) return std::nullopt;
  const double sine = e.coefficients[0].value, cosine = e.coefficients[1].value;
  Cycle cycle;
  cycle.amplitude = std::hypot(sine, cosine);
  cycle.phase = std::atan2(cosine, sine);
  Eigen::Index first = 0;
  for (int other = 0; other < effect; ++other)
    first += static_cast<Eigen::Index>(fit.robot.effects[other].coefficients.size());
  const Eigen::Vector2d along = Eigen::Vector2d(sine, cosine) / cycle.amplitude;
  const Eigen::Index unknown = static_cast<Eigen::Index>(fit.set.kept.size()) + first;
  const Eigen::Matrix2d covariance = fit.covariance.block<2, 2>(unknown, unknown);
  cycle.amplitude_std = std::sqrt(along.dot(covariance * along));
  const auto [low, high] =
      interval_about(departures.middleCols<2>(first) * along, cycle.amplitude_std, poses);
  cycle.amplitude_ci95 = {cycle.amplitude + low, cycle.amplitude + high};
  return cycle;
}

class Tracer {
 public:
  Tracer(const Robot& robot, const Campaign& campaign, const Catalogue& catalogue,
         const TraceOptions& options)
      : campaign_(campaign), options_(options), poses_(static_cast<int>(campaign.pose_ids.size())) {
    note("fitting the geometry");
    result_.fit = calibrate(robot, campaign);
    declared_ = static_cast<int>(robot.effects.size());
    result_.stages.push_back(result_.fit);
    candidates_ = catalogue_candidates(catalogue, robot, campaign);
    if (options.beyond_catalogue) {
      const std::vector<Candidate> open = open_candidates(robot, campaign);
      const size_t known = candidates_.size();
      for (const Candidate& candidate : open) candidates_.push_back(candidate);
      // Whoever looks beyond the catalogue has looked at the catalogue too.
      for (size_t k = known; k < candidates_.size(); ++k)
        candidates_[k].log_choices =
            std::log(std::exp(candidates_[k].log_choices) + static_cast<double>(known));
    }
    // Of candidates that explain alike the first is taken.
    std::sort(candidates_.begin(), candidates_.end(), comes_before);
    // Moments and forces are taken along the axes of R_A, so each base must be where it was.
    const Robot start = starting_robot(robot, campaign, result_.fit.set);
    scan_.emplace(candidates_, start, in_common_frame(campaign, start));
    if (scan_->candidates().empty())
      throw std::invalid_argument(
          campaign.source +
          ": no effect of the catalogue can be looked for in these measurements, which lack the "
          "columns of its drivers (t_s, temp_..._c, payload_kg, fx_n, dir1, tau1_nm, ...); log "
          "them, take another catalogue or search beyond it (without --only-catalogue)");
  }

  TraceResult run() {
    for (const Effect& effect : options_.start) begin_with(effect);
    if (!chosen_.empty()) {
      revise(KnownCauses::give_way);
      result_.stages.push_back(result_.fit);
    }
    // Beside effects that are still missing a curve takes up what they leave. So a known cause
    // gives way to a curve only when there is nothing left to add.
    bool may_revise = true;
    for (;;) {
      while (step()) {
        if (may_revise && chosen_.size() > 1) revise(KnownCauses::stay);
        gather(kManyOfOnePlace);
        may_revise &= is_new_model();
        result_.stages.push_back(result_.fit);
      }
      if (!(may_revise && revise(KnownCauses::give_way)) && !gather(2)) {
        if (fine_curves_) break;
        fine_curves_ = true;
        continue;
      }
      may_revise &= is_new_model();
      result_.stages.back() = result_.fit;
    }
    settle_inner_values();
    drop_idle();
    order_by_share();
    describe();
    return std::move(result_);
  }

 private:
  // Adding and dropping may not go round in circles: once a model comes back, what is in stays, and
  // after so many models too, for frequencies seldom come back to the last digit.
  bool is_new_model() {
    std::multiset<std::string> names;  // whatever their order; inner values do not count
    for (const Candidate& candidate : chosen_)
      names.insert(candidate.effect.parameter + "|" + to_string(candidate.effect.driver) + "|" +
                   to_string(candidate.effect.shape));
    return seen_.insert(names).second && seen_.size() < kMostModels;
  }

  // All candidates against the fit as it stands.
  struct View {
    Linearization fit;
    ProjectedCandidates projected;

    View(const CandidateScan& scan, const CalibrationResult& result, const Campaign& campaign)
        : fit(result, campaign), projected(scan, fit) {}
  };
  const View& view() {
    if (!view_) view_ = std::make_unique<View>(*scan_, result_.fit, campaign_);
    return *view_;
  }

  void note(const std::string& what) const {
    if (options_.progress) options_.progress(what);
  }

  static std::vector<int> best_first(const std::vector<CandidateScore>& scores) {
    std::vector<int> order(scores.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
      return std::round(scores[a].score / kSameScore) > std::round(scores[b].score / kSameScore);
    });
    return order;
  }

  // Of the right sign, and no larger than such a thing can be. Several coefficients are the first
  // moments of masses that nobody stated, of either sign.
  bool is_possible(const CandidateScan& scan, int candidate, const CandidateScore& score) const {
    const Eigen::VectorXd& c = score.coefficients;
    if (scan.candidates()[candidate].only_positive && c.size() == 1 && c[0] <= 0) return false;
    return scan.variation(candidate, score.coefficients) < kPossibleVariation;
  }

  // One forward step; false if nothing more is to be added.
  bool step() {
    note("scanning for effect " + std::to_string(chosen_.size() + 1));
    const auto& [fit, projected] = view();
    const std::vector<CandidateScore> scores = projected.scores();
    const std::vector<int> order = best_first(scores);
    rank(scores, order);
    result_.best_score = scores[order.front()].score;
    int trials = 0;
    for (int candidate : order) {
      if (scores[candidate].score <= 0 || trials == kTrials) break;
      if (!may_enter(scan_->candidates()[candidate])) continue;
      ++trials;
      if (!is_possible(*scan_, candidate, scores[candidate])) continue;
      const CrossValidation cv =
          CrossValidation::of(fit, projected.directions(candidate), options_.seed);
      if (cv.gain <= cv.error) continue;
      const double p = p_value(scores[candidate].score);
      if (p >= significance() || static_cast<int>(chosen_.size()) == options_.max_effects) {
        result_.remaining_p = p;
        return false;
      }
      add(candidate, p);
      return true;
    }
    result_.remaining_p = p_value(result_.best_score);
    return false;
  }

  void add(int candidate, double p) {
    p_at_gate_.push_back(p);
    chosen_.push_back(refine(scan_->candidates()[candidate], view().fit, -1));
    refit({});
  }

  // Adds an effect that was asked for, whatever the gates say.
  void begin_with(const Effect& effect) {
    const auto& candidates = scan_->candidates();
    const auto found =
        std::find_if(candidates.begin(), candidates.end(),
                     [&](const Candidate& candidate) { return same(candidate.effect, effect); });
    if (found == candidates.end())
      throw std::invalid_argument(effect.parameter + " by " + to_string(effect.driver) +
                                  " is no candidate of the search that is to begin with it");
    const int candidate = static_cast<int>(found - candidates.begin());
    // Nothing is added of which nothing shows.
    const CandidateScore score = view().projected.scores()[candidate];
    if (score.degrees_of_freedom > 0) add(candidate, p_value(score.score));
  }

  // Family-wise: how often chance makes the best of all candidates look as good.
  double p_value(double score) {
    const double level = significance();
    double p = 1;
    for (int flips : {options_.flips, 10 * options_.flips}) {
      if (static_cast<int>(null_scores_.size()) < flips)
        null_scores_ = view().projected.best_of_flipped(flips, options_.seed);
      const auto as_high = std::count_if(null_scores_.begin(), null_scores_.end(),
                                         [&](double by_chance) { return by_chance >= score; });
      p = (1.0 + static_cast<double>(as_high)) / (1.0 + static_cast<double>(null_scores_.size()));
      // More draws only where these cannot tell.
      if (p >= options_.significance || p < level) break;
    }
    describe_null_run(level);
    return p;
  }

  // What would have been added where nothing is: draws whose best candidate passes the gates.
  void describe_null_run(double level) {
    std::vector<double> scores = null_scores_;
    std::sort(scores.begin(), scores.end(), std::greater<>());
    const auto count = static_cast<double>(scores.size());
    NullRun& run = result_.null_run;
    run.flips = static_cast<int>(scores.size());
    run.score_95 = scores[static_cast<size_t>(0.05 * count)];
    int added = 0;
    for (size_t k = 0; k < scores.size(); ++k)
      added += scores[k] > 0 && static_cast<double>(k + 1) / (1.0 + count) < level;
    run.false_add_rate = added / count;
  }

  double significance() const {
    return significance_level(result_.fit, campaign_, options_.significance,
                              options_.significance_without_lack_of_fit);
  }

  // The same candidate with its inner values (t*, tau) where they explain most, beside all that is
  // in the model or, if `effect` is not negative, in the place of that effect.
  Candidate refine(const Candidate& found, const Linearization& fit, int effect) const {
    const std::vector<Candidate> finer = refined_candidates(found, campaign_);
    if (finer.empty()) return found;
    return finer[best_first(scores_of(finer, fit, effect)).front()];
  }

  // Of candidates that are not those of the search, all on the same parameter; `effect` as above.
  std::vector<CandidateScore> scores_of(const std::vector<Candidate>& candidates,
                                        const Linearization& fit, int effect) const {
    const Robot& robot = result_.fit.robot;
    const CandidateScan scan(candidates, robot, in_common_frame(campaign_, robot));
    const ProjectedCandidates projected(scan, fit);
    return effect < 0 ? projected.scores() : projected.scores_without({effect});
  }

  // Refits the geometry and all effects; `start` are coefficients to start from, else zero for new
  // ones.
  void refit(const std::vector<Effect>& start) {
    Robot robot = result_.fit.robot;
    robot.effects.resize(declared_);
    for (size_t k = 0; k < chosen_.size(); ++k) {
      Effect effect = chosen_[k].effect;
      const auto& old = start.empty() ? result_.fit.robot.effects : start;
      const size_t place = static_cast<size_t>(declared_) + k;
      if (place < old.size() && same(old[place], effect))
        effect.coefficients = old[place].coefficients;
      if (effect.coefficients.empty())
        effect.coefficients.resize(
            BoundEffect(effect, robot, campaign_.temperature_names).coefficient_count());
      robot.effects.push_back(effect);
    }
    CalibrationOptions options;
    options.near = &result_.fit;
    options.tolerance = kSearchTolerance;
    result_.fit = calibrate(robot, campaign_, result_.fit.set, options);
    view_.reset();
    null_scores_.clear();
  }

  static bool same(const Effect& a, const Effect& b) {
    return a.parameter == b.parameter && a.driver == b.driver && a.shape == b.shape;
  }

  enum class KnownCauses { stay, give_way };  // to what no catalogue names

  // Drops effects that the others have made idle, and exchanges those that another now explains
  // better. False if nothing changed.
  bool revise(KnownCauses known_causes) {
    int round = 0;
    while (round < kRevisions && !chosen_.empty() && revise_one(known_causes)) ++round;
    return round > 0;
  }

  // The one change that lowers EBIC most, so that it does not matter which effect came first.
  bool revise_one(KnownCauses known_causes) {
    const auto& [fit, projected] = view();
    int effect = -1;
    std::optional<Candidate> other;
    double most = 0;
    for (size_t k = 0; k < chosen_.size(); ++k) {
      const int in_fit = declared_ + static_cast<int>(k);
      const double own = score_of({static_cast<int>(k)}).score;
      const std::vector<CandidateScore> scores = projected.scores_without({in_fit});
      const bool by_known = chosen_[k].from_catalogue && known_causes == KnownCauses::stay;
      const auto better = better_than(std::max(own, 0.0), scores, by_known);
      const double fall = better ? scores[*better].score - own : -own;
      if (fall < most || (!better && own > 0)) continue;
      std::optional<Candidate> refined;
      if (better) refined = refine(scan_->candidates()[*better], fit, in_fit);
      if (refined && same(refined->effect, chosen_[k].effect)) continue;
      most = fall;
      effect = static_cast<int>(k);
      other = refined;
    }
    if (effect < 0) return false;
    std::vector<Effect> coefficients = result_.fit.robot.effects;
    if (other) {
      chosen_[effect] = *other;
      p_at_gate_[effect] = std::nullopt;
      coefficients[declared_ + effect] = {};
    } else {
      remove({effect}, coefficients);
    }
    refit(coefficients);
    return true;
  }

  // Of the chosen, all on one parameter: what they explain together.
  CandidateScore score_of(const std::vector<int>& chosen) {
    std::vector<int> in_fit;
    double log_choices = 0;
    for (int k : chosen) {
      in_fit.push_back(declared_ + k);
      log_choices += chosen_[k].log_choices;
    }
    return view().projected.score_of(in_fit, chosen_[chosen.front()].effect.parameter, log_choices);
  }

  // `least` or more effects of one parameter and driver give way to one fine curve where it
  // explains more than they do together. False if nothing changed.
  bool gather(size_t least) {
    std::vector<int> gathered;
    int curve = -1;
    double most = kClearlyBetter;
    for (size_t first = 0; first < chosen_.size(); ++first) {
      std::vector<int> together, in_fit;
      for (size_t k = first; k < chosen_.size(); ++k)
        if (same_place(chosen_[k].effect, chosen_[first].effect)) {
          together.push_back(static_cast<int>(k));
          in_fit.push_back(declared_ + static_cast<int>(k));
        }
      const bool seen = std::any_of(chosen_.begin(), chosen_.begin() + first, [&](const auto& c) {
        return same_place(c.effect, chosen_[first].effect);
      });
      if (together.size() < least || seen) continue;
      const double own = score_of(together).score;
      const std::vector<CandidateScore> scores = view().projected.scores_without(in_fit);
      for (size_t c = 0; c < scores.size(); ++c) {
        const Candidate& candidate = scan_->candidates()[c];
        if (!candidate.fine || !same_place(candidate.effect, chosen_[first].effect) ||
            scores[c].score <= own + most)
          continue;
        most = scores[c].score - own;
        gathered = together;
        curve = static_cast<int>(c);
      }
    }
    if (curve < 0 || ++gatherings_ > kMostGatherings) return false;
    std::vector<Effect> coefficients = result_.fit.robot.effects;
    remove(gathered, coefficients);
    chosen_.push_back(scan_->candidates()[curve]);
    p_at_gate_.push_back(std::nullopt);
    refit(coefficients);
    return true;
  }

  // Inner values were chosen beside what was in the model then; now beside all.
  void settle_inner_values() {
    for (int round = 0; round < kSettlings; ++round) {
      std::vector<Candidate> settled;
      for (size_t k = 0; k < chosen_.size(); ++k)
        settled.push_back(refine(chosen_[k], view().fit, declared_ + static_cast<int>(k)));
      if (std::equal(
              settled.begin(), settled.end(), chosen_.begin(),
              [](const Candidate& a, const Candidate& b) { return same(a.effect, b.effect); }))
        return;
      chosen_ = settled;
      refit({});
      result_.stages.back() = result_.fit;
    }
  }

  // Some stood for what the inner values of others missed.
  void drop_idle() {
    for (;;) {
      int idle = -1;
      double least = 0;
      for (int k = 0; k < static_cast<int>(chosen_.size()); ++k) {
        const double score = score_of({k}).score;
        if (score > least) continue;
        least = score;
        idle = k;
      }
      if (idle < 0) return;
      std::vector<Effect> coefficients = result_.fit.robot.effects;
      remove({idle}, coefficients);
      refit(coefficients);
      result_.stages.back() = result_.fit;
    }
  }

  // From the chosen; `indices` ascend.
  void remove(const std::vector<int>& indices, std::vector<Effect>& coefficients) {
    for (auto k = indices.rbegin(); k != indices.rend(); ++k) {
      chosen_.erase(chosen_.begin() + *k);
      p_at_gate_.erase(p_at_gate_.begin() + *k);
      coefficients.erase(coefficients.begin() + declared_ + *k);
    }
  }

  // What explains most leads, whichever was found first; effects of one parameter and driver are
  // pieces of one thing and stand together.
  void order_by_share() {
    const VarianceShares found = variance_shares(view().fit.effects_from(declared_), options_.seed);
    const auto effects = static_cast<Eigen::Index>(chosen_.size());
    const Eigen::Map<const Eigen::VectorXd> share(found.of_group.data(), effects);
    std::vector<Eigen::VectorXd> place(chosen_.size(), Eigen::VectorXd::Zero(effects));
    for (size_t a = 0; a < chosen_.size(); ++a)
      for (size_t b = 0; b < chosen_.size(); ++b)
        place[a][static_cast<Eigen::Index>(b)] = same_place(chosen_[a].effect, chosen_[b].effect);
    std::vector<size_t> order(chosen_.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
      return std::pair(place[a].dot(share), found.of_group[a]) >
             std::pair(place[b].dot(share), found.of_group[b]);
    });
    const std::vector<Candidate> chosen = chosen_;
    const auto p_at_gate = p_at_gate_;
    std::vector<Effect> in_order = result_.fit.robot.effects;
    const double wide = student_quantile(poses_);
    for (size_t k = 0; k < order.size(); ++k) {
      const auto own = static_cast<Eigen::Index>(order[k]);
      const double half = wide * found.standard_deviation(Eigen::VectorXd::Unit(effects, own));
      const Eigen::VectorXd behind = place[order.front()] - place[order[k]];
      shares_.push_back({share[own],
                         {std::max(0.0, share[own] - half), std::min(1.0, share[own] + half)},
                         behind.dot(share) <= wide * found.standard_deviation(behind)});
      chosen_[k] = chosen[order[k]];
      p_at_gate_[k] = p_at_gate[order[k]];
      in_order[declared_ + k] = result_.fit.robot.effects[declared_ + order[k]];
    }
    if (std::is_sorted(order.begin(), order.end())) return;
    refit(in_order);
    result_.stages.back() = result_.fit;
  }

  // The best possible candidate, `known` or any, that is clearly better than `score`.
  std::optional<int> better_than(double score, const std::vector<CandidateScore>& scores,
                                 bool known) const {
    for (int candidate : best_first(scores)) {
      if (scores[candidate].score <= score + kClearlyBetter) break;
      const Candidate& other = scan_->candidates()[candidate];
      if ((other.from_catalogue || !known) && may_enter(other) &&
          is_possible(*scan_, candidate, scores[candidate]))
        return candidate;
    }
    return std::nullopt;
  }

  void rank(const std::vector<CandidateScore>& scores, const std::vector<int>& order) {
    result_.ranking.clear();
    for (int candidate : order) {
      if (result_.ranking.size() == 20) break;
      const CandidateScore& score = scores[candidate];
      if (score.degrees_of_freedom == 0) break;
      result_.ranking.push_back(ranked(scan_->candidates()[candidate], score));
    }
    result_.not_separable.clear();
    for (size_t k = 0; k < scores.size(); ++k)
      if (scores[k].degrees_of_freedom == 0 && scan_->candidates()[k].from_catalogue &&
          !is_in_model(scan_->candidates()[k].effect))
        result_.not_separable.push_back(ranked(scan_->candidates()[k], scores[k]));
  }

  bool may_enter(const Candidate& candidate) const {
    return (fine_curves_ || !candidate.fine) && !is_in_model(candidate.effect);
  }

  bool is_in_model(const Effect& effect) const {
    const auto& effects = result_.fit.robot.effects;
    return std::any_of(effects.begin(), effects.end(),
                       [&](const Effect& other) { return same(other, effect); });
  }

  static RankedCandidate ranked(const Candidate& candidate, const CandidateScore& score) {
    return {
        candidate.effect, candidate.separated_by,  score.degrees_of_freedom, score.left, score.gain,
        score.score,      candidate.from_catalogue};
  }

  // Evidence of each effect beside all the others, and what cannot be told from it.
  void describe() {
    if (chosen_.empty()) return;
    result_.effects.resize(chosen_.size());
    note("looking for what cannot be told apart");
    Robot& robot = result_.fit.robot;
    result_.departures =
        bootstrap_coefficients(result_.fit, campaign_, options_.bootstrap, options_.seed);
    set_intervals(result_.departures, poses_, robot);
    const auto& [fit, projected] = view();
    for (size_t k = 0; k < chosen_.size(); ++k) {
      const int effect = declared_ + static_cast<int>(k);
      TracedEffect& traced = result_.effects[k];
      traced.variance_share = shares_[k];
      traced.effect = robot.effects[effect];
      traced.cycle = cycle_of(effect, chosen_[k].frequency_resolution > 0);
      traced.step_ci95 = step_ci95(chosen_[k], effect);
      traced.from_catalogue = chosen_[k].from_catalogue;
      traced.only_prediction = !traced.from_catalogue;
      traced.separated_by = chosen_[k].separated_by;
      traced.incomplete =
          std::count_if(chosen_.begin(), chosen_.end(), [&](const Candidate& other) {
            return same_place(other.effect, chosen_[k].effect);
          }) > 1;
      const CandidateScore own = score_of({static_cast<int>(k)});
      traced.evidence.delta_ebic = own.score;
      traced.evidence.p_value = p_at_gate_[k] ? *p_at_gate_[k] : p_value(own.score);
      const CrossValidation cv = CrossValidation::of_effect(fit, effect, options_.seed);
      traced.evidence.cross_validated_gain = cv.gain;
      traced.evidence.cross_validated_gain_error = cv.error;
      const std::vector<CandidateScore> scores = projected.scores_without({effect});
      const std::vector<CandidateScore> imitations = projected.imitations(effect);
      std::vector<int> listed;
      for (int candidate : best_first(scores)) {
        const Candidate& other = scan_->candidates()[candidate];
        if (same_claim(other, chosen_[k]) || scores[candidate].degrees_of_freedom == 0) continue;
        const double correlation = std::sqrt(imitations[candidate].gain);
        const double behind = own.score - scores[candidate].score;
        const bool simple =
            scores[candidate].degrees_of_freedom <= std::max(2, own.degrees_of_freedom);
        if (!(simple && correlation >= kSameProjection) && behind > kSameEvidence) continue;
        if (!is_possible(*scan_, candidate, scores[candidate])) continue;
        if (std::any_of(listed.begin(), listed.end(),
                        [&](int rival) { return same_claim(scan_->candidates()[rival], other); }))
          continue;
        listed.push_back(candidate);
        const double by_readings = behind - 2 * (other.log_choices - chosen_[k].log_choices);
        const bool ruled_out = std::min(behind, by_readings) > kRuledOut;
        (ruled_out ? traced.ruled_out : traced.indistinguishable)
            .push_back({other.effect, correlation, behind,
                        refitted(effect, candidate, imitations[candidate]), other.separated_by});
      }
    }
  }

  // The times at which a step would explain nearly as much, out to the readings about them.
  std::optional<std::array<double, 2>> step_ci95(const Candidate& chosen, int effect) {
    if (chosen.effect.shape.kind != ShapeKind::step) return std::nullopt;
    const std::vector<Candidate> steps = steps_at_any_time(chosen, campaign_);
    const std::vector<CandidateScore> scores = scores_of(steps, view().fit, effect);
    double best = 0;
    for (const CandidateScore& score : scores) best = std::max(best, score.score);
    double low = chosen.effect.shape.at, high = low;
    for (size_t k = 0; k < steps.size(); ++k) {
      if (scores[k].score < best - kFallToStep95) continue;
      low = std::min(low, steps[k].effect.shape.at);
      high = std::max(high, steps[k].effect.shape.at);
    }
    std::array<double, 2> readings{-std::numeric_limits<double>::infinity(),
                                   std::numeric_limits<double>::infinity()};
    for (double time : campaign_.time_s) {
      if (time < low) readings[0] = std::max(readings[0], time);
      if (time > high) readings[1] = std::min(readings[1], time);
    }
    return readings;
  }

  std::optional<Cycle> cycle_of(int effect, bool searched) {
    std::optional<Cycle> of_effect = fixed_cycle(result_.fit, result_.departures, effect, poses_);
    if (!of_effect) return std::nullopt;
    Cycle& cycle = *of_effect;
    const Effect& e = result_.fit.robot.effects[effect];
    const double sine = e.coefficients[0].value, cosine = e.coefficients[1].value;
    if (searched) {
      // The derivative with respect to the frequency.
      const Linearization& fit = view().fit;
      Eigen::VectorXd column =
          fit.jacobian().col(*find_parameter(result_.fit.robot.chain, e.parameter));
      for (int row = 0; row < fit.rows(); ++row) {
        const double q = campaign_.q[row][e.driver.joint], nq = e.shape.harmonic * q;
        column.segment(row * fit.row_size(), fit.row_size()) *=
            q * (sine * std::cos(nq) - cosine * std::sin(nq));
      }
      cycle.frequency_std = fit.standard_deviation(column);
      const double n = e.shape.harmonic,
                   half_width = student_quantile(poses_) * cycle.frequency_std;
      cycle.frequency_ci95 = {n - half_width, n + half_width};
    }
    return of_effect;
  }

  std::vector<std::string> refitted(int effect, int candidate, const CandidateScore& imitation) {
    const Linearization& fit = view().fit;
    std::vector<std::string> names;
    for (int k : fit.most_refitted(effect, scan_->columns(fit, candidate) * imitation.coefficients,
                                   kRefitted))
      names.push_back(parameter_name(result_.fit.robot.chain, result_.fit.set.kept[k]));
    return names;
  }

  // The same cause as far as a name goes: parameter and driver.
  static bool same_place(const Effect& a, const Effect& b) {
    return a.parameter == b.parameter && a.driver == b.driver;
  }

  // Two frequencies of a gear train that the travel covered tells apart are two claims.
  static bool same_claim(const Candidate& a, const Candidate& b) {
    const double resolution = std::min(a.frequency_resolution, b.frequency_resolution);
    return same_place(a.effect, b.effect) &&
           (resolution == 0 ||
            std::abs(a.effect.shape.harmonic - b.effect.shape.harmonic) < resolution);
  }

  const Campaign& campaign_;
  const TraceOptions& options_;
  const int poses_;
  TraceResult result_;
  std::unique_ptr<View> view_;
  std::vector<double> null_scores_;  // of the view, as far as they were asked for
  int declared_ = 0;
  int gatherings_ = 0;
  bool fine_curves_ = false;  // whether they may enter: once nothing simpler is left
  std::vector<Candidate> candidates_;
  std::optional<CandidateScan> scan_;
  std::vector<Candidate> chosen_;
  std::vector<VarianceShare> shares_;
  std::vector<std::optional<double>> p_at_gate_;  // none where one took another's place
  std::set<std::multiset<std::string>> seen_;
};

// What was found in some of the poses, fitted to all.
void refit_to_all(const Robot& robot, const Campaign& campaign, const TraceOptions& options,
                  TraceResult& result) {
  if (options.progress) options.progress("fitting what was found to all poses");
  CalibrationOptions near;
  near.near = &result.fit;
  near.tolerance = kSearchTolerance;
  result.stages.front() = calibrate(robot, campaign, result.fit.set);
  const CalibrationResult fit = calibrate(result.fit.robot, campaign, result.fit.set, near);
  result.fit = fit;
  result.stages.back() = result.fit;
  if (result.effects.empty()) return;
  const int poses = static_cast<int>(campaign.pose_ids.size());
  result.departures = bootstrap_coefficients(result.fit, campaign, options.bootstrap, options.seed);
  set_intervals(result.departures, poses, result.fit.robot);
  const auto declared = static_cast<int>(robot.effects.size());
  for (size_t k = 0; k < result.effects.size(); ++k) {
    TracedEffect& traced = result.effects[k];
    const int effect = declared + static_cast<int>(k);
    traced.effect = result.fit.robot.effects[effect];
    const Cycle before = traced.cycle.value_or(Cycle{});
    traced.cycle = fixed_cycle(result.fit, result.departures, effect, poses);
    if (!traced.cycle) continue;
    traced.cycle->frequency_std = before.frequency_std;
    traced.cycle->frequency_ci95 = before.frequency_ci95;
  }
}

}  // namespace

// An effect without a lack of fit is a stranger claim, and needs the stronger evidence. The lack is
// that of position, which is what the arm shall be accurate in.
double significance_level(const CalibrationResult& fit, const Campaign& campaign, double with_lack,
                          double without_lack) {
  const double lack_of_fit = assess(fit, campaign).lack_of_fit_in_position.value_or(1.0);
  const double missing = std::clamp(std::log(lack_of_fit) / std::log(kLackOfFit), 0.0, 1.0);
  return without_lack * std::pow(with_lack / without_lack, missing);
}

TraceResult trace(const Robot& robot, const Campaign& campaign, const Catalogue& catalogue,
                  const TraceOptions& options) {
  if (static_cast<int>(campaign.pose_ids.size()) <= kMostPosesOfSearch)
    return Tracer(robot, campaign, catalogue, options).run();
  const Campaign part = campaign.select(rows_of_some_poses(campaign, kMostPosesOfSearch));
  TraceResult result = Tracer(robot, part, catalogue, options).run();
  refit_to_all(robot, campaign, options, result);
  return result;
}

}  // namespace armtrue
