#include "armtrue/campaign/training_rows.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

// Steps to which the numbers of a row are rounded, so that a copy with fewer digits is one still.
constexpr double kAngleStep = 1e-3 * kDegree, kLengthStep = 1e-5;

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
  if (campaign.reads_one_number())
    hash.add(campaign.length(row), kLengthStep);
  else
    for (const double coordinate : campaign.position[k]) hash.add(coordinate, kLengthStep);
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
  std::set<int> seen, compared;
  for (int row = 0; row < campaign.rows(); ++row) {
    const std::uint32_t mark = mark_of(campaign, row);
    if (!are_all && mark > marks.back()) continue;
    const int pose = campaign.pose[row];
    compared.insert(pose);
    if (std::ranges::binary_search(marks, mark)) seen.insert(pose);
  }
  return {static_cast<int>(seen.size()), static_cast<int>(compared.size())};
}

}  // namespace armtrue
