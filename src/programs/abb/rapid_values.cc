#include "programs/abb/rapid_values.h"

#include <cmath>
#include <vector>

#include "armtrue/kinematics/units.h"
#include "programs/dialects.h"

namespace armtrue {

Configuration rapid_configuration(const ProgramPoint& point) {
  Configuration result;
  result.reference << 0, 0, 0, 0, 45, 0;
  result.reference *= kDegree;
  constexpr double kMost = 8;
  for (const ProgramNumber& number : point.configuration)
    if (number.value != std::floor(number.value) || std::abs(number.value) > kMost) return result;
  for (int k = 0; k < 3; ++k) {
    const int joint = k == 0 ? 0 : k == 1 ? 3 : 5;
    result.low[joint] = 90 * kDegree * point.configuration[k].value;
    result.high[joint] = result.low[joint] + 90 * kDegree;
  }
  const int cfx = static_cast<int>(point.configuration[3].value);
  if (cfx < 0) return result;
  result.sides = {cfx & 4 ? -1 : 1, cfx & 2 ? -1 : 1, cfx & 1 ? -1 : 1};
  result.sides_are_weak = true;
  return result;
}

bool is_rapid_quaternion(const ListItem& list) {
  const auto q = list.numbers(4);
  if (!q) return false;
  double square = 0;
  for (double value : *q) square += value * value;
  constexpr double kUnit = 0.01;
  return std::abs(square - 1) < kUnit;
}

bool is_rapid_axis(double value) {
  constexpr double kNoAxis = 1e8;
  return std::abs(value) < kNoAxis;
}

std::optional<Pose> rapid_pose(const ListItem& list) {
  if (list.kind != ListItem::Kind::list || list.items.size() != 2) return std::nullopt;
  const auto position = list.items[0].numbers(3);
  if (!position || !is_rapid_quaternion(list.items[1])) return std::nullopt;
  std::vector<double> numbers = *position;
  for (const ListItem& item : list.items[1].items) numbers.push_back(item.value);
  return rapid_dialect().pose_of_numbers(numbers);
}

}  // namespace armtrue
