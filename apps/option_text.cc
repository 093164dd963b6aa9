#include "option_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "options.h"

namespace armtrue::app {

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> items;
  size_t begin = 0;
  while (begin <= text.size()) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const size_t first = std::min(text.find_first_not_of(' ', begin), end);
    const size_t last = end > first ? text.find_last_not_of(' ', end - 1) + 1 : first;
    if (last > first) items.push_back(text.substr(first, last - first));
    begin = end + 1;
  }
  return items;
}

std::vector<double> numbers_from_text(const std::string& text, std::optional<size_t> count,
                                      const std::string& form) {
  std::vector<double> numbers;
  const std::vector<std::string> items = split_list(text);
  if (std::ranges::count(text, ',') + 1 != std::ssize(items))
    throw std::invalid_argument("'" + text + "' has an empty place; give " + form);
  for (const std::string& item : items) {
    const std::optional<double> number = read_number(item);
    numbers.push_back(number.value_or(0));
    if (!number || !std::isfinite(*number))
      throw std::invalid_argument("'" + item + "' is not a number; give " + form);
    if (std::abs(numbers.back()) > kMaxNumber)
      throw std::invalid_argument("'" + item + "' is larger than anything real; give " + form);
  }
  if (count && numbers.size() != *count)
    throw std::invalid_argument(fmt::format("'{}' has {} instead of {}; give {}", text,
                                            counted(numbers.size(), "number"), *count, form));
  return numbers;
}

Zone zone_from_text(const std::string& text) {
  const std::vector<double> numbers = numbers_from_text(text, 4, "x,y,z,radius in mm");
  constexpr double kMinRadius = 1e-3;  // mm: distances are divided by it
  if (numbers[3] <= 0) throw std::invalid_argument("the radius must be above zero");
  if (numbers[3] < kMinRadius)
    throw std::invalid_argument(fmt::format("the radius is below {:g} mm", kMinRadius));
  return {Eigen::Vector3d(numbers[0], numbers[1], numbers[2]) * kMillimetre,
          numbers[3] * kMillimetre};
}

std::optional<Box> box_from_numbers(const std::vector<double>& numbers_mm) {
  if (numbers_mm.empty()) return std::nullopt;
  const std::vector<double>& n = numbers_mm;
  for (size_t axis = 0; axis < 3; ++axis)
    if (n[2 * axis] > n[2 * axis + 1])
      throw std::invalid_argument(fmt::format(
          "--box-mm: {} ends at {:g}, before it begins, at {:g}; give x0,x1,y0,y1,z0,z1 "
          "in mm, the smaller of each pair first",
          "xyz"[axis], n[2 * axis + 1], n[2 * axis]));
  return Box{Eigen::Vector3d(n[0], n[2], n[4]) * kMillimetre,
             Eigen::Vector3d(n[1], n[3], n[5]) * kMillimetre};
}

JointVector joints_of(const std::vector<double>& numbers, const Robot& robot,
                      const std::string& option) {
  const std::vector<JointName> joints = joint_names(robot.chain);
  if (numbers.size() != joints.size()) {
    const bool of_arm = std::ranges::all_of(joints, [](const JointName& joint) {
      return joint.column.front() == 'q' && !joint.is_length;
    });
    throw UsageError(fmt::format(
        "{}: has {} instead of {}; give {}", option, counted(numbers.size(), "number"),
        joints.size(),
        of_arm ? fmt::format("q1,...,q{} in deg", joints.size()) : encoder_columns(robot.chain)));
  }
  JointVector q(std::ssize(numbers));
  for (size_t j = 0; j < joints.size(); ++j) q[j] = numbers[j] * joints[j].si();
  return q;
}

}  // namespace armtrue::app
