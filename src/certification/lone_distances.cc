#include "certification/lone_distances.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "armtrue/statistics/distributions.h"

namespace armtrue {
namespace {

constexpr int kFewestDistances = 20, kOneOf = 20;  // of the distances, one of so many
constexpr double kRareByLaw = 3e-5;

// Of the k largest among `sorted`, longest first; the others tell the law.
double chance_of_largest(const std::vector<double>& sorted, std::ptrdiff_t k) {
  const double nearest = sorted[k - 1], next = sorted[k];
  const double middle = sorted[k + (std::ssize(sorted) - k) / 2];
  struct Law {
    double log_likelihood, chance;
  };
  std::vector<Law> laws;
  const auto others = static_cast<double>(std::ssize(sorted) - k), lone = static_cast<double>(k);
  double sum_of_logs = 0;
  for (auto r = sorted.begin() + k; r != sorted.end(); ++r) sum_of_logs += std::log(*r);
  for (const double axes : {1.0, 2.0, 3.0})
    for (const double freedom : {2.0, 3.0, 4.0, 6.0, 10.0, 20.0, 60.0})
      for (double log_scale = -1.5; log_scale <= 1.0; log_scale += 0.08) {
        const double scale = middle * std::exp(log_scale);
        const auto beyond = [&](double r) {
          return fisher_f_above(r * r / (axes * scale * scale), axes, freedom);
        };
        double log = (axes - 1) * sum_of_logs +
                     others * (std::lgamma((freedom + axes) / 2) - std::lgamma(freedom / 2) -
                               std::lgamma(axes / 2) - axes * std::log(scale) -
                               axes / 2 * std::log(freedom));
        for (auto r = sorted.begin() + k; r != sorted.end(); ++r)
          log -= (freedom + axes) / 2 * std::log1p(*r * *r / (scale * scale * freedom));
        const double above_next = std::max(beyond(next), 1e-300);
        laws.push_back({log + lone * std::log(above_next),
                        std::pow(std::min(1.0, beyond(nearest) / above_next), lone)});
      }
  const double most = std::ranges::max_element(laws, {}, &Law::log_likelihood)->log_likelihood;
  double sum = 0, chance = 0;
  for (const Law& law : laws) {
    const double weight = std::exp(law.log_likelihood - most);
    sum += weight;
    chance += weight * law.chance;
  }
  return chance / sum;
}

}  // namespace

double least_lone_distance(std::vector<double> distances) {
  constexpr double kAllCounts = 1.645, kLeastGap = 1.3;
  std::erase_if(distances, [](double r) { return r <= 0; });
  std::ranges::sort(distances, std::greater<>{});
  double least = std::numeric_limits<double>::infinity();
  const auto count = std::ssize(distances);
  if (count < kFewestDistances) return least;
  double least_chance = kRareByLaw;
  for (std::ptrdiff_t k = 1; k <= count / kOneOf; ++k) {
    if (distances[k - 1] < kLeastGap * distances[k]) continue;  // no law has so sharp an end
    const double chance = kAllCounts * static_cast<double>(k * k) * chance_of_largest(distances, k);
    if (chance >= least_chance) continue;
    least_chance = chance;
    least = distances[k - 1];
  }
  return least;
}

}  // namespace armtrue
