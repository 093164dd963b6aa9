#include "path/samples/program_departure.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "path/samples/neighbours.h"

namespace armtrue {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// The same for runs about some times, increasing.
Departure largest_departure(const Path& programmed, const Eigen::ArrayXd& times, double period,
                            Index length) {
  constexpr Index kSide = kSideOfMotion;
  std::vector<Eigen::Matrix3Xd> at;  // positions of samples 0 .. 2 kSide + length - 1, by time
  const double middle = 0.5 * static_cast<double>(2 * kSide + length - 1);
  for (int k = 0; k < 2 * kSide + length; ++k)
    at.push_back(position_at(programmed, times + (k - middle) * period));
  Neighbours around{};
  around.count = kSideOfMotion;
  around.ends = {0, static_cast<double>(length - 1)};
  for (int k = 0; k < kSide; ++k) {
    around.before[k] = -1 - k;
    around.after[k] = static_cast<double>(length + k);
  }
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Departure most;
  for (Index i = 0; i < times.size(); ++i) {
    const auto sample = [&](Index k) -> Vector3d { return at[k].col(i); };
    for (Index k = 0; k < kSide; ++k) {
      around.before_at[k] = sample(kSide - 1 - k);
      around.after_at[k] = sample(kSide + length + k);
    }
    around.ends_at = {sample(kSide), sample(kSide + length - 1)};
    Departure here{kNone, kNone};
    for (const size_t end : {size_t{0}, size_t{1}}) {
      const auto [before, after] = around.from_each_side(end);
      here.side = std::min({here.side, before.length(), after.length()});
      here.both = std::min(here.both, around.from_both_sides(end).length());
    }
    most.both = std::max(most.both, std::min(here.both, here.side));
    most.side = std::max(most.side, here.side);
  }
  return most;
}

}  // namespace

Departure largest_departure(const Path& programmed, double period, Index length) {
  constexpr Index kPart = 8192;  // samples at a time: bounds the memory
  Departure most;
  for (Index begin = 0; begin < programmed.samples(); begin += kPart) {
    const auto times =
        programmed.time.segment(begin, std::min(kPart, programmed.samples() - begin)).array();
    for (const double shift : {-0.5, 0.0, 0.5}) {
      const Departure here = largest_departure(programmed, times + shift * period, period, length);
      most = {std::max(most.both, here.both), std::max(most.side, here.side)};
    }
  }
  return most;
}

}  // namespace armtrue
