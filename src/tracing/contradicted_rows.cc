#include "tracing/contradicted_rows.h"

#include <algorithm>
#include <iterator>

#include "armtrue/campaign/grouped_rows.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

constexpr double kContradicts = 14, kAgrees = 5;  // standard deviations
constexpr double kMostBlunders = 0.3;   // of the rows

}  // namespace

std::vector<int> contradicted_rows(const Evaluation& evaluation, const NoiseFloor& noise,
                                   const Campaign& held_out) {
  const std::vector<double>& own = held_out.sigma_position;
  const double usual = noise.median_sigma > 0 || own.empty() ? noise.median_sigma : median(own);
  const double per_sigma = own.empty() ? 0 : noise.position / usual;
  const auto is_within = [&](int row, double deviations) {
    const double deviation = own.empty() ? noise.position : per_sigma * own[row];
    return evaluation.position[row] <= deviations * deviation;
  };
  std::vector<int> contradicted;
  if (noise.position <= 0) return contradicted;
  const GroupedRows poses = grouped_rows(held_out.pose);
  for (int pose = 0; pose < poses.groups(); ++pose) {
    const auto rows = poses.rows(pose);
    const auto near = std::ranges::count_if(rows, [&](int row) { return is_within(row, kAgrees); });
    if (2 * near < std::ssize(rows)) continue;
    std::ranges::copy_if(rows, std::back_inserter(contradicted),
                         [&](int row) { return !is_within(row, kContradicts); });
  }
  std::ranges::sort(contradicted);
  if (static_cast<double>(contradicted.size()) > kMostBlunders * held_out.rows()) return {};
  return contradicted;
}

}  // namespace armtrue
