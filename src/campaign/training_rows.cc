#include "armtrue/campaign/training_rows.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/distributions.h"

namespace armtrue {
namespace {

// Steps to which the numbers of a row are rounded, so that a copy with fewer digits is one still.
constexpr double kAngleStep = 1e-3 * kDegree, kLengthStep = 1e-5, kPixelStep = 1e-2;

// FNV-1a over 64 bits, then the finaliser of SplitMix64, so that all bits of a mark are even.
class Hash {
 public:
  void add(double value, double step) {
    std::uint64_t steps = std::llround(value / step);
    for (int byte = 0; byte < 8; ++byte, steps >>= 8)
      state_ = (state_ ^ (steps & 0xff)) * 0x100000001b3ULL;
  }
  std::uint32_t mark() const {
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return static_cast<std::uint32_t>((z ^ (z >> 31)) >> 32);
  }

 private:
  std::uint64_t state_ = 0xcbf29ce484222325ULL;
};

// Joint values are angles but for those of rails, which a step of an angle marks as well: 0.017 mm.
std::uint32_t mark_of(const Campaign& campaign, int row) {
  Hash hash;
  const size_t k = row;
  for (const double joint : campaign.q[k]) hash.add(joint, kAngleStep);
  if (campaign.kind(row) == ReadingKind::pixel) {
    // The length at the board depends on the other images. Computed back from it, a pixel that
    // lies between two steps of rounding must not fall to either.
    constexpr double kBetween = 1e-6;
    hash.add(campaign.length(row) / campaign.metre_per_pixel + kBetween, kPixelStep);
  } else if (campaign.reads_one_number()) {
    hash.add(campaign.length(row), kLengthStep);
  } else {
    for (const double coordinate : campaign.position[k]) hash.add(coordinate, kLengthStep);
  }
  if (campaign.has_profiles())
    for (const double coordinate : {campaign.profile[k].y, campaign.profile[k].z})
      hash.add(coordinate, kLengthStep);
  return hash.mark();
}

}  // namespace

TrainingRows training_rows(const Campaign& campaign) {
  TrainingRows training;
  training.rows = campaign.rows();
  std::vector<std::uint32_t>& marks = training.marks;
  // Marks above the largest that is kept cannot come back.
  bool is_full = false;
  const auto keep_least = [&] {
    std::ranges::sort(marks);
    marks.erase(std::unique(marks.begin(), marks.end()), marks.end());
    is_full |= marks.size() >= TrainingRows::kMostMarks;
    if (is_full) marks.resize(TrainingRows::kMostMarks);
  };
  std::uint32_t largest = 0;
  for (int row = 0; row < campaign.rows(); ++row) {
    const std::uint32_t mark = mark_of(campaign, row);
    if (is_full && mark >= largest) continue;
    marks.push_back(mark);
    if (marks.size() < 2 * TrainingRows::kMostMarks) continue;
    keep_least();
    largest = marks.back();
  }
  keep_least();
  return training;
}

SeenPoses seen_poses(const TrainingRows& training, const Campaign& campaign) {
  const std::vector<std::uint32_t>& marks = training.marks;
  if (marks.empty()) return {};
  const bool are_all = marks.size() < TrainingRows::kMostMarks;
  struct Rows {
    int known = 0, compared = 0;
  };
  std::map<int, Rows> poses;
  for (int row = 0; row < campaign.rows(); ++row) {
    const std::uint32_t mark = mark_of(campaign, row);
    if (!are_all && mark > marks.back()) continue;
    Rows& own = poses[campaign.pose[row]];
    ++own.compared;
    own.known += std::ranges::binary_search(marks, mark);
  }
  // One number of a pose that is measured again is often the same by chance: at a noise of 0.05 mm
  // that of one distance in 18, and of a board of 35 corners some pixel of nearly every image.
  constexpr double kByChance = 0.2, kNoChance = 1e-3;
  const bool by_one_number = campaign.reads_one_number();
  SeenPoses result{0, static_cast<int>(poses.size())};
  for (const auto& [pose, rows] : poses)
    result.seen += by_one_number ? 2 * rows.known > rows.compared : rows.known > 0;
  if (by_one_number && binomial_at_least(result.seen, result.compared, kByChance) >= kNoChance)
    result.seen = 0;
  return result;
}

}  // namespace armtrue
