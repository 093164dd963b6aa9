#include "diagnosis/far_set_up_change.h"

#include <Eigen/Core>
#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/selection.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/diagnosis/diagnosis.h"
#include "armtrue/observation/placement.h"
#include "armtrue/observation/registration.h"
#include "diagnosis/changed_cause.h"
#include "diagnosis/reading_order.h"

namespace armtrue {
namespace {

constexpr size_t kMostParts = 4;
constexpr int kFewestFar = 6;          // readings; fewer are blunders
constexpr size_t kPosesToBegin = 8;    // 24 numbers for 9 unknowns
constexpr double kShareToBegin = 0.1;  // of the readings
constexpr double kShareNear = 0.8;     // of the readings of a part: the others are blunders
constexpr int kRowsOfFit = 200;

bool is_far(double miss) { return miss > kImplausibleMiss; }

bool fits(const Robot& placed, const Campaign& readings) {
  const std::vector<double> miss = position_errors(placed, readings);
  return static_cast<double>(std::ranges::count_if(miss, is_far)) <=
         (1 - kShareNear) * static_cast<double>(miss.size());
}

std::optional<Robot> placed_on(const Robot& robot, const Campaign& readings) {
  const auto placement = place_base_and_tool(robot, readings, kImplausibleMiss);
  if (!placement) return std::nullopt;
  Robot placed = placed_robot(robot, readings, *placement);
  return fits(placed, readings) ? std::optional(std::move(placed)) : std::nullopt;
}

// Readings that follow each other in an order, with base and tool as they are in them.
struct Stretch {
  int begin, end;
  Robot placed;
};

// The parts of readings in their order; empty if they have none.
class Stretches {
 public:
  Stretches(const Robot& robot, const Campaign& campaign, std::vector<int> order)
      : robot_(robot), campaign_(campaign), order_(std::move(order)) {}

  std::vector<Stretch> find() const {
    std::vector<Stretch> parts;
    for (int begin = 0; begin < rows(); begin = parts.back().end) {
      if (!parts.empty() && rows() - begin < kFewestFar) {
        parts.back().end = rows();
        break;
      }
      auto part = part_from(begin);
      if (!part || parts.size() == kMostParts) return {};
      parts.push_back(std::move(*part));
    }
    for (size_t k = 1; k < parts.size(); ++k) set_border(parts[k - 1], parts[k]);
    return parts;
  }

  Campaign readings(int begin, int end) const {
    return campaign_.select({order_.begin() + begin, order_.begin() + end});
  }

 private:
  int rows() const { return static_cast<int>(order_.size()); }

  // End of the first readings that suffice for a start; the end of all, if they are fewer.
  int end_of_first(int begin) const {
    std::set<int> poses;
    int end = begin;
    while (end < rows() && (poses.size() < kPosesToBegin || end - begin < kShareToBegin * rows()))
      poses.insert(campaign_.pose[order_[end++]]);
    return end;
  }

  std::optional<Robot> placed_on_rows(int begin, int end) const {
    const std::vector<int> all(order_.begin() + begin, order_.begin() + end);
    return placed_on(robot_, campaign_.select(evenly_chosen(all, kRowsOfFit)));
  }

  std::optional<Stretch> part_from(int begin) const {
    int end = end_of_first(begin);
    std::optional<Robot> placed = placed_on_rows(begin, end);
    for (int last = begin; placed && end > last;) {
      last = end;
      end = std::max(end, end_of_near(*placed, begin));
      if (end > last) placed = placed_on_rows(begin, end);
    }
    return placed ? std::optional(Stretch{begin, end, std::move(*placed)}) : std::nullopt;
  }

  // Place up to which the near readings outnumber the far ones most.
  int end_of_near(const Robot& placed, int begin) const {
    const std::vector<double> miss = position_errors(placed, readings(begin, rows()));
    int lead = 0, most = 0, end = begin;
    for (size_t k = 0; k < miss.size(); ++k) {
      lead += is_far(miss[k]) ? -1 : 1;
      if (lead <= most) continue;
      most = lead;
      end = begin + static_cast<int>(k) + 1;
    }
    return end;
  }

  // Moves the border to where each reading is of the part that it is nearer to.
  void set_border(Stretch& before, Stretch& after) const {
    const Campaign both = readings(before.begin, after.end);
    const std::vector<double> of_before = position_errors(before.placed, both),
                              of_after = position_errors(after.placed, both);
    int lead = 0, most = 0, border = before.begin;
    for (size_t k = 0; k < of_before.size(); ++k) {
      lead += of_before[k] <= of_after[k] ? 1 : -1;
      if (lead <= most) continue;
      most = lead;
      border = before.begin + static_cast<int>(k) + 1;
    }
    before.end = after.begin = border;
  }

  const Robot& robot_;
  const Campaign& campaign_;
  std::vector<int> order_;
};

std::vector<Stretch> parts_in(const Robot& robot, const Campaign& campaign,
                              const std::vector<int>& order) {
  std::vector<Stretch> parts = Stretches(robot, campaign, order).find();
  if (!parts.empty()) return parts;
  parts = Stretches(robot, campaign, {order.rbegin(), order.rend()}).find();
  const int rows = static_cast<int>(order.size());
  std::ranges::reverse(parts);
  for (Stretch& part : parts) {
    std::swap(part.begin, part.end);
    part.begin = rows - part.begin;
    part.end = rows - part.end;
  }
  return parts;
}

enum class Moved { frame, tool, neither };

// Whether the frame alone or the tool alone makes the parts differ from the longest of them.
Moved moved_in(const std::vector<Stretch>& parts, const Stretches& all) {
  const Stretch& longest = *std::ranges::max_element(
      parts, {}, [](const Stretch& part) { return part.end - part.begin; });
  bool by_frame = true, by_tool = true;
  for (const Stretch& part : parts) {
    const Campaign readings = all.readings(part.begin, part.end);
    Robot frame_moved = longest.placed, tool_moved = longest.placed;
    frame_moved.chain.base = registered_base(longest.placed, readings);
    tool_moved.chain.tool = part.placed.chain.tool;
    by_frame = by_frame && fits(frame_moved, readings);
    by_tool = by_tool && fits(tool_moved, readings);
  }
  return by_frame ? Moved::frame : by_tool ? Moved::tool : Moved::neither;
}

std::string in_words(Moved moved, const Robot& before, const Robot& after, const ChangedPart& part,
                     const Campaign& campaign) {
  if (moved == Moved::tool) {
    const Pose change = inverse(before.chain.tool) * after.chain.tool;
    return moved_tool_in_words(change.translation.norm(),
                               campaign.has_orientation()
                                   ? std::optional(rotation_log(change.rotation).norm())
                                   : std::nullopt,
                               part);
  }
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : campaign.position) middle += point / campaign.rows();
  const Pose change = after.chain.base * inverse(before.chain.base);
  return moved_frame_in_words((change * middle - middle).norm(),
                              rotation_log(change.rotation).norm(), part);
}

bool has_one_frame(const Robot& robot, const Campaign& campaign) {
  const auto placement = place_base_and_tool(robot, campaign, kImplausibleMiss);
  return !placement || std::ranges::count_if(placement->miss, is_far) < kFewestFar;
}

}  // namespace

std::optional<std::string> find_far_set_up_change(const Robot& given, const Campaign& campaign) {
  const std::vector<std::vector<int>> sessions = rows_by_session(campaign);
  if (sessions.size() > 1) return std::nullopt;
  Robot robot = given;
  robot.effects.clear();
  if (has_one_frame(robot, campaign.select(evenly_chosen(sessions.front(), kRowsOfFit))))
    return std::nullopt;
  std::vector<Stretch> parts;
  ReadingOrder order;
  for (ReadingOrder& other : orders_of(campaign)) {
    std::vector<Stretch> found = parts_in(robot, campaign, other.rows);
    if (found.size() < 2 || (!parts.empty() && found.size() >= parts.size())) continue;
    parts = std::move(found);
    order = std::move(other);
  }
  if (parts.empty()) return std::nullopt;
  const Moved moved = moved_in(parts, Stretches(robot, campaign, order.rows));
  if (moved == Moved::neither) return std::nullopt;
  std::vector<int> first_rows;
  for (size_t k = 1; k < parts.size(); ++k) first_rows.push_back(order.rows[parts[k].begin]);
  return in_words(moved, parts[0].placed, parts[1].placed, parts_from(first_rows, order, campaign),
                  campaign);
}

}  // namespace armtrue
