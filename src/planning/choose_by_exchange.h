#pragma once

#include <Eigen/Core>
#include <vector>

namespace armtrue {

/// Initial information on every unknown, as a share of that of an average pose, so that the
/// criterion is defined for the first poses, which are too few for full rank.
inline constexpr double kKnownFromStart = 1e-6;

/// Chooses `count` of the candidates: a greedy start, then each chosen one is exchanged for the
/// best until no exchange helps (Fedorov, "Theory of Optimal Experiments", 1972, in the variant of
/// Cook and Nachtsheim 1980). A local optimum; the first of equal candidates wins.
///
/// `criterion` has `void set_chosen(int candidate, bool)` and `Eigen::VectorXd values_of_adding()
/// const`: for every candidate, the value of the design with it; larger is better.
template <typename Criterion>
std::vector<int> choose_by_exchange(Criterion& criterion, int candidates, int count) {
  constexpr double kExchangeTolerance = 1e-6;  // relative gain
  constexpr int kMaxPasses = 100;
  std::vector<bool> is_chosen(candidates, false);
  const auto set_chosen = [&](int candidate, bool chosen) {
    criterion.set_chosen(candidate, chosen);
    is_chosen[candidate] = chosen;
  };
  const auto best_free = [&](const Eigen::VectorXd& values) {
    int best = -1;
    for (int i = 0; i < candidates; ++i)
      if (!is_chosen[i] && (best < 0 || values[i] > values[best])) best = i;
    return best;
  };
  std::vector<int> chosen;
  for (int k = 0; k < count; ++k) {
    chosen.push_back(best_free(criterion.values_of_adding()));
    set_chosen(chosen.back(), true);
  }
  bool exchanged = true;
  for (int pass = 0; pass < kMaxPasses && exchanged; ++pass) {
    exchanged = false;
    for (int& candidate : chosen) {
      set_chosen(candidate, false);
      const Eigen::VectorXd values = criterion.values_of_adding();
      const int best = best_free(values);
      if (values[best] > (1 + kExchangeTolerance) * values[candidate]) {
        candidate = best;
        exchanged = true;
      }
      set_chosen(candidate, true);
    }
  }
  return chosen;
}

}  // namespace armtrue
