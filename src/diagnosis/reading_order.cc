#include "diagnosis/reading_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "armtrue/text/number_text.h"

namespace armtrue {
namespace {

std::vector<int> sorted_by(const std::vector<double>& keys) {
  std::vector<int> order(keys.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](int row) { return keys[row]; });
  return order;
}

// Pose numbers by row; empty if an id is no number.
std::vector<double> pose_numbers(const Campaign& campaign) {
  std::vector<double> numbers;
  for (int pose : campaign.pose) {
    const std::optional<double> number = read_number(campaign.pose_ids[pose]);
    if (!number || !std::isfinite(*number)) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

std::string place_of(size_t row, const ReadingOrder& order, const Campaign& campaign) {
  if (order.of == "time") return fmt::format("t_s = {:.10g}", campaign.time_s[row]);
  if (order.of == "pose") return "pose " + campaign.pose_ids[campaign.pose[row]];
  return fmt::format("line {}", campaign.line[row]);
}

}  // namespace

std::vector<ReadingOrder> orders_of(const Campaign& campaign) {
  std::vector<ReadingOrder> orders;
  if (!campaign.time_s.empty()) orders.push_back({"time", sorted_by(campaign.time_s)});
  orders.push_back({"line", sorted_by({campaign.line.begin(), campaign.line.end()})});
  if (const auto numbers = pose_numbers(campaign); !numbers.empty())
    orders.push_back({"pose", sorted_by(numbers)});
  return orders;
}

ChangedPart parts_from(const std::vector<int>& rows, const ReadingOrder& order,
                       const Campaign& campaign) {
  std::string places, options;
  for (const int row : rows) {
    places += (places.empty() ? "from " : " and again from ") + place_of(row, order, campaign);
    if (order.of == "time")
      options += fmt::format("--new-session-at-s {:.10g} ", campaign.time_s[row]);
  }
  if (!options.empty()) options += "or ";
  return {fmt::format("{} on, in the order of the {}s,", places, order.of),
          options + "a column 'session'"};
}

}  // namespace armtrue
