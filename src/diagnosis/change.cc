#include "armtrue/diagnosis/change.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/campaign/without_rows.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/distributions.h"
#include "diagnosis/change_problem.h"

namespace armtrue {
namespace {

constexpr double kIndistinguishable = 6;     // BIC
constexpr double kBlunderWeight = 0.25;      // some six standard deviations under Student's t
constexpr double kMostTimesPromised = 4;     // that a loss falls where it falls little
constexpr double kExchangeTolerance = 1e-6;  // BIC
constexpr size_t kMaxMoves = 4;              // more at once want a new calibration

std::vector<int> find_blunders(const ChangeProblem& problem) {
  const ReadingLaw law{4.0};
  const double price = std::log(problem.equations());
  ChangeProblem::Fit best = problem.fit({}, law);
  const auto is_off = [](double weight) { return weight < kBlunderWeight; };
  if (std::ranges::none_of(best.weights, is_off)) return {};
  const std::vector<double> promised = problem.promised_falls(law, best);
  for (int k = 0; k < problem.hypotheses(); ++k) {
    const double of_moves = price * problem.moves_in({k});
    if (kMostTimesPromised * promised[k] < of_moves) continue;
    ChangeProblem::Fit other = problem.fit({k}, law);
    other.loss += of_moves;
    if (other.loss < best.loss) best = std::move(other);
  }
  std::vector<int> blunders;
  for (int row = 0; row < std::ssize(best.weights); ++row)
    if (is_off(best.weights[row])) blunders.push_back(row);
  if (static_cast<double>(blunders.size()) >
      kMaxBlunders * static_cast<double>(best.weights.size()))
    return {};
  return blunders;
}

// Hypotheses taken as true together.
struct Explanation {
  std::vector<int> moved;
  ChangeProblem::Fit fit;
  double bic;
};

Explanation explain(const ChangeProblem& problem, const std::vector<int>& moved) {
  Explanation explanation{moved, problem.fit(moved, {}), 0};
  explanation.bic = explanation.fit.loss + problem.moves_in(moved) * std::log(problem.equations());
  return explanation;
}

// The fits with one more of the other hypotheses; by BIC, best first.
std::vector<Explanation> each_beside(const ChangeProblem& problem, const std::vector<int>& moved) {
  std::vector<Explanation> explanations;
  for (int k = 0; k < problem.hypotheses(); ++k) {
    if (std::ranges::count(moved, k) > 0) continue;
    std::vector<int> more = moved;
    more.push_back(k);
    explanations.push_back(explain(problem, more));
  }
  std::ranges::stable_sort(explanations, {}, &Explanation::bic);
  return explanations;
}

std::vector<int> all_but(std::vector<int> moved, size_t which) {
  moved.erase(moved.begin() + which);
  return moved;
}

// A lower bound of p_value(): the same if the readings of a pose were independent.
double p_of_independent(const ChangeProblem& problem, const Explanation& fewer,
                        const Explanation& more) {
  const double fall = std::max(0.0, fewer.fit.loss - more.fit.loss);
  const double freedom = std::max(1, problem.moves_in(more.moved) - problem.moves_in(fewer.moved));
  return std::min(1.0, problem.hypotheses() * chi_squared_above(fall, freedom));
}

// p-value of the fall of chi-square by the move `which` of `more`.
double p_value(const ChangeProblem& problem, const Explanation& fewer, Explanation& more,
               size_t which) {
  const double fall = std::max(0.0, fewer.fit.loss - more.fit.loss);
  const double freedom = std::max(1, problem.moves_in(more.moved) - problem.moves_in(fewer.moved));
  problem.complete(more.moved, more.fit);
  const double widening = problem.widening(more.moved, which, more.fit);
  double p = chi_squared_above(fall, freedom);
  if (widening > 1)
    p = std::max(
        p, fisher_f_above(fall / (freedom * widening), freedom, std::max(1, problem.poses() - 1)));
  return std::min(1.0, problem.hypotheses() * p);
}

// Exchanges taken moves for others as long as that is better.
void exchange(const ChangeProblem& problem, Explanation& current) {
  for (size_t k = 0, kept = 0; kept < current.moved.size() && current.moved.size() > 1;
       k = (k + 1) % current.moved.size()) {
    Explanation other = each_beside(problem, all_but(current.moved, k)).front();
    ++kept;
    if (!(other.bic < current.bic - kExchangeTolerance)) continue;
    current = std::move(other);
    kept = 0;
  }
}

void drop_superfluous(const ChangeProblem& problem, Explanation& current) {
  for (size_t k = 0; k < current.moved.size();) {
    Explanation fewer = explain(problem, all_but(current.moved, k));
    if (p_value(problem, fewer, current, k) < kChangeSignificance)
      ++k;
    else
      current = std::move(fewer);
  }
}

// Adds moves to those of `current` as long as that is better.
Explanation with_more_moves(const ChangeProblem& problem, Explanation current) {
  const double independent = 1;  // the scatter of the poses is known once what moved is taken out
  while (current.moved.size() < kMaxMoves) {
    Explanation more = each_beside(problem, current.moved).front();
    if (!(more.bic < current.bic)) break;
    if (problem.p_value(current.moved, current.fit, independent) >= kChangeSignificance &&
        p_value(problem, current, more, current.moved.size()) >= kChangeSignificance)
      break;
    current = std::move(more);
    exchange(problem, current);
  }
  return current;
}

Explanation find_moves(const ChangeProblem& problem) {
  const Explanation nothing = explain(problem, {});
  Explanation best = with_more_moves(problem, nothing);
  if (best.moved.empty() || problem.p_value(best.moved, best.fit, 1) >= kChangeSignificance)
    return best;
  // Two moves that neither explains much alone are found as a pair, beside the first.
  constexpr double kMostEquations = 2000;  // beyond, nobody waits for all pairs
  if (problem.equations() > kMostEquations) return best;
  const int first = best.moved.front();
  std::optional<Explanation> pair;
  for (int i = 0; i < problem.hypotheses(); ++i)
    for (int j = 0; j < i; ++j) {
      if (i == first || j == first) continue;
      Explanation other = explain(problem, {first, j, i});
      if (!pair || other.bic < pair->bic) pair = std::move(other);
    }
  if (!pair || !(pair->bic < best.bic)) return best;
  return with_more_moves(problem, std::move(*pair));
}

// p-value of the largest fall of chi-square by any single move.
double p_of_any_move(const ChangeProblem& problem, const Explanation& nothing) {
  double least = 1;
  for (Explanation& moved : each_beside(problem, {}))
    if (p_of_independent(problem, nothing, moved) < least)
      least = std::min(least, p_value(problem, nothing, moved, 0));
  return least;
}

Move tested(const ChangeProblem& problem, Explanation& explanation, size_t which,
            const Explanation& without, double overdispersion) {
  problem.complete(explanation.moved, explanation.fit);
  Move move = problem.described(explanation.moved, which, explanation.fit);
  move.delta_bic = without.bic - explanation.bic;
  move.p_value = p_value(problem, without, explanation, which);
  move.p_value_left = problem.p_value(explanation.moved, explanation.fit, overdispersion);
  return move;
}

std::vector<Move> with_rivals(const ChangeProblem& problem, Explanation& found,
                              double overdispersion) {
  std::vector<Move> moves;
  for (size_t k = 0; k < found.moved.size(); ++k) {
    const Explanation without = explain(problem, all_but(found.moved, k));
    Move& move = moves.emplace_back(tested(problem, found, k, without, overdispersion));
    for (Explanation& rival : each_beside(problem, without.moved))
      if (rival.bic < found.bic + kIndistinguishable &&
          std::ranges::count(found.moved, rival.moved.back()) == 0)
        move.indistinguishable.push_back(
            tested(problem, rival, without.moved.size(), without, overdispersion));
  }
  return moves;
}

double times_noisier(const NoiseFloor& noise, double spread) {
  constexpr double kNoticeable = 1.5, kNoChance = 1e-3;
  const double times = noise.position / spread, freedom = noise.degrees_of_freedom;
  return times > kNoticeable && chi_squared_above(freedom * times * times, freedom) < kNoChance
             ? times
             : 1;
}

}  // namespace

ChangeResult detect_change(const Robot& calibrated, const ReadingSigma& spread,
                           const Campaign& campaign) {
  const Robot previous = robot_at_row(calibrated, campaign, 0);
  if (previous.std.empty())
    throw std::invalid_argument(
        "the previous robot states no 'std' of its parameters; give one that calibrate or "
        "close-loop --robot-out has written");
  ChangeResult result;
  result.sigma = spread;
  const NoiseFloor noise = noise_floor(previous, campaign, evaluate(previous, campaign));
  const bool is_measured = noise.source == NoiseFloor::Source::replicates;
  if (is_measured) result.noisier = times_noisier(noise, spread.position);
  if (is_measured || !campaign.sigma_position.empty())
    result.sigma.position = std::max(spread.position, noise.position);
  if (is_measured || !campaign.sigma_orientation.empty())
    result.sigma.orientation = std::max(spread.orientation, noise.orientation);
  const auto need = [](double deviation, const char* what, const char* key) {
    if (!(deviation > 0))
      throw std::invalid_argument("the spread of " + std::string(what) +
                                  " that the previous calibration left is not known; add '" + key +
                                  "' to the 'noise' of the previous robot");
  };
  need(result.sigma.position, "positions", "position_mm");
  if (campaign.has_orientation())
    need(result.sigma.orientation, "orientations", "orientation_mrad");

  std::optional<ChangeProblem> of_rows(std::in_place, calibrated, campaign, result.sigma);
  result.blunders = find_blunders(*of_rows);
  Campaign sound;  // if there are blunders
  if (!result.blunders.empty()) {
    sound = without_rows(campaign, result.blunders);
    of_rows.emplace(calibrated, sound, result.sigma);
  }
  const ChangeProblem& problem = *of_rows;
  const Explanation nothing = explain(problem, {});
  Explanation found = find_moves(problem);
  // The scatter of the poses is estimated after the possible moves are fitted.
  problem.complete(found.moved, found.fit);
  const double overdispersion = problem.overdispersion(found.fit);
  // With many readings, the chi-square of all hardly shows a change of one parameter.
  result.p_value = std::min(1.0, 2 * std::min(problem.p_value({}, nothing.fit, overdispersion),
                                              p_of_any_move(problem, nothing)));
  result.holds = result.p_value >= kChangeSignificance;
  if (result.holds)
    found = nothing;
  else
    drop_superfluous(problem, found);
  result.moved = with_rivals(problem, found, overdispersion);
  result.p_value_left = problem.p_value(found.moved, found.fit, overdispersion);
  problem.complete(found.moved, found.fit);
  result.stations = problem.stations(found.fit);
  result.before = problem.mean_error({}, nothing.fit);
  result.after = problem.mean_error(found.moved, found.fit);
  return result;
}

std::string noisier_in_words(const ChangeResult& result) {
  if (result.noisier == 1) return "";
  return fmt::format(
      "visits of the same pose scatter by {:.3g} mm per axis, {:.3g} times as much as the readings "
      "did "
      "at the calibration: the test takes that for noise, and smaller changes are hidden; does the "
      "arm "
      "return as it did (a loose axis, a brake, a reflector), and does the instrument stand firm?",
      result.sigma.position / kMillimetre, result.noisier);
}

}  // namespace armtrue
