#include "armtrue/campaign/scattered_poses.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "armtrue/campaign/grouped_rows.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

// Rows of one pose, session and target, of those that have several.
std::vector<std::vector<int>> standstills(const Campaign& campaign) {
  const auto of = [&](int row) {
    return std::pair(campaign.session.empty() ? 0 : campaign.session[row],
                     campaign.target.empty() ? 0 : campaign.target[row]);
  };
  std::vector<std::vector<int>> several;
  const GroupedRows poses = grouped_rows(campaign.pose);
  for (int pose = 0; pose < poses.groups(); ++pose) {
    const auto all = poses.rows(pose);
    if (all.size() < 2) continue;
    std::vector<int> rows(all.begin(), all.end());
    std::ranges::stable_sort(rows, {}, of);
    for (auto begin = rows.begin(); begin != rows.end();) {
      const auto end =
          std::find_if(begin, rows.end(), [&](int row) { return of(row) != of(*begin); });
      if (end - begin > 1) several.emplace_back(begin, end);
      begin = end;
    }
  }
  return several;
}

Eigen::Vector3d middle_of(const Campaign& campaign, const std::vector<int>& rows) {
  Eigen::Vector3d middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const int row : rows) values.push_back(campaign.position[row][axis]);
    middle[axis] = median(std::move(values));
  }
  return middle;
}

}  // namespace

std::string scattered_poses(const Campaign& campaign) {
  constexpr double kApart = 5e-3;  // [m]: no arm returns worse
  constexpr double kTimesUsual = 10;
  constexpr size_t kFewest = 3, kTenth = 10;
  if (campaign.position.empty() || campaign.reads_one_number()) return "";
  const std::vector<std::vector<int>> poses = standstills(campaign);
  struct Farthest {
    double off = 0;
    int row = 0;
  };
  std::vector<Farthest> farthest;
  std::vector<double> all;
  for (const std::vector<int>& rows : poses) {
    const Eigen::Vector3d middle = middle_of(campaign, rows);
    Farthest most{-1, 0};
    for (const int row : rows) {
      const double off = (campaign.position[row] - middle).norm();
      all.push_back(off);
      if (off > most.off) most = {off, row};
    }
    farthest.push_back(most);
  }
  if (all.empty()) return "";
  const double apart = std::max(kApart, kTimesUsual * median(std::move(all)));
  const auto is_apart = [&](const Farthest& pose) { return pose.off > apart; };
  const size_t count = std::ranges::count_if(farthest, is_apart);
  if (count < kFewest || kTenth * count < poses.size()) return "";
  const Farthest& worst = *std::ranges::max_element(farthest, {}, &Farthest::off);
  return fmt::format(
      "in {} of {} poses with several points these lie apart, by up to {:.4g} mm (line {}, "
      "pose '{}'), and an arm that stands still does not do that: if the tables were joined by "
      "time, check the offset of the clocks (import-readings --clock-offset-s, or --join stops), "
      "else the names of the poses",
      count, poses.size(), worst.off / kMillimetre, campaign.line[worst.row],
      campaign.pose_ids[campaign.pose[worst.row]]);
}

}  // namespace armtrue
