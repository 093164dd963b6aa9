#include "diagnosis/exchanged_targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <set>
#include <vector>

#include "armtrue/campaign/selection.h"
#include "armtrue/diagnosis/diagnosis.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/observation/placement.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

constexpr size_t kPosesOfExchange = 3;

// Of each reading the place on the last link that it shows [m].
std::vector<Eigen::Vector3d> places_on_link(const Robot& robot, const Campaign& campaign) {
  constexpr int kRowsOfPlacement = 500;
  Robot arm = robot;
  arm.effects.clear();
  const auto placed =
      place_base_and_tool(arm, campaign.select(thinned_rows(campaign, kRowsOfPlacement)), 0);
  if (!placed) return {};
  arm.chain.base = placed->base;
  arm.chain.tool = Pose();
  const ChainEvaluator chain(arm.chain);
  std::vector<Eigen::Vector3d> places;
  for (int row = 0; row < campaign.rows(); ++row)
    places.push_back(inverse(chain.pose(campaign.q[row])) * campaign.position[row]);
  return places;
}

// The readings of two targets, in the order of the rows.
struct Pair {
  std::array<int, 2> target;
  std::vector<int> rows;
  std::vector<char> is_second;  // by its name
  std::vector<char> lies_in_second{};
  std::vector<char> is_near{};  // the middle of its group
};

// Whether the places fall into two clear groups; sets in which each lies.
bool split(const std::vector<Eigen::Vector3d>& places, Pair& pair) {
  constexpr int kSteps = 30;
  constexpr double kClear = 8, kNear = 0.25;  // of the distance of the middles
  const auto far = [&](const Eigen::Vector3d& from) {
    return places[*std::ranges::max_element(
        pair.rows, {}, [&](int row) { return (places[row] - from).squaredNorm(); })];
  };
  std::array<Eigen::Vector3d, 2> middle;
  middle[0] = far(places[pair.rows.front()]);
  middle[1] = far(middle[0]);
  for (int step = 0; step < kSteps; ++step) {
    pair.lies_in_second.clear();
    for (int row : pair.rows)
      pair.lies_in_second.push_back((places[row] - middle[1]).squaredNorm() <
                                    (places[row] - middle[0]).squaredNorm());
    for (const int group : {0, 1}) {
      std::array<std::vector<double>, 3> of;
      for (size_t k = 0; k < pair.rows.size(); ++k)
        for (size_t i = 0; i < 3 && pair.lies_in_second[k] == group; ++i)
          of[i].push_back(places[pair.rows[k]][static_cast<Eigen::Index>(i)]);
      if (of[0].empty()) return false;
      middle[static_cast<size_t>(group)] = {median(of[0]), median(of[1]), median(of[2])};
    }
  }
  std::vector<double> within;
  for (size_t k = 0; k < pair.rows.size(); ++k)
    within.push_back(
        (places[pair.rows[k]] - middle[static_cast<size_t>(pair.lies_in_second[k])]).norm());
  const double apart = (middle[1] - middle[0]).norm();
  for (const double distance : within) pair.is_near.push_back(distance < kNear * apart);
  return apart > kClear * median(within);
}

std::string in_words(const Campaign& campaign, const Pair& pair, const std::vector<size_t>& wrong) {
  const auto row_of = [&](size_t k) { return pair.rows[k]; };
  const auto name = [&](int which) {
    return "'" + campaign.target_names[pair.target[static_cast<size_t>(which)]] + "'";
  };
  const bool to_the_end =
      wrong.back() + 1 == pair.rows.size() && wrong.back() - wrong.front() + 1 == wrong.size();
  const std::string where =
      fmt::format("{} of {} readings, {} line {}{}", wrong.size(), pair.rows.size(),
                  to_the_end ? "from" : "the first in", campaign.line[row_of(wrong.front())],
                  to_the_end ? " on" : "");
  const bool of_both = std::ranges::any_of(
      wrong, [&](size_t k) { return pair.is_second[k] != pair.is_second[wrong.front()]; });
  if (of_both)
    return fmt::format(
        "the targets {} and {} look exchanged in {}: each lies where the other does in the rest; "
        "exchange the names in the column 'target' there",
        name(0), name(1), where);
  const int named = pair.is_second[wrong.front()];
  return fmt::format(
      "readings of the target {} look named {}, {}: they lie where {} does in the rest; correct "
      "the "
      "column 'target' there",
      name(1 - named), name(named), where, name(1 - named));
}

}  // namespace

std::optional<std::string> find_exchanged_targets(const Robot& robot, const Campaign& campaign) {
  const auto targets = static_cast<int>(campaign.target_names.size());
  if (targets < 2 || campaign.target.empty() || campaign.reads_one_number()) return std::nullopt;
  const std::vector<Eigen::Vector3d> places = places_on_link(robot, campaign);
  if (places.empty()) return std::nullopt;
  std::vector<std::vector<int>> rows_of(targets);
  for (int row = 0; row < campaign.rows(); ++row) rows_of[campaign.target[row]].push_back(row);
  for (int second = 1; second < targets; ++second)
    for (int first = 0; first < second; ++first) {
      if (rows_of[first].empty() || rows_of[second].empty()) continue;
      Pair pair{{first, second}, rows_of[first], {}};
      pair.rows.insert(pair.rows.end(), rows_of[second].begin(), rows_of[second].end());
      std::ranges::sort(pair.rows);
      for (int row : pair.rows) pair.is_second.push_back(campaign.target[row] == second);
      if (!split(places, pair)) continue;
      std::array<std::vector<size_t>, 2> differs;  // by which name the groups have
      for (size_t k = 0; k < pair.rows.size(); ++k)
        if (pair.is_near[k]) differs[pair.lies_in_second[k] == pair.is_second[k]].push_back(k);
      // Of two halves the later one is wrong.
      const bool swapped = differs[0].size() > differs[1].size() ||
                           (differs[0].size() == differs[1].size() && !differs[0].empty() &&
                            differs[0].front() < differs[1].front());
      const std::vector<size_t>& wrong = differs[swapped];
      std::set<int> poses;
      for (size_t k : wrong) poses.insert(campaign.pose[pair.rows[k]]);
      if (poses.size() >= kPosesOfExchange) return in_words(campaign, pair, wrong);
    }
  return std::nullopt;
}

}  // namespace armtrue
