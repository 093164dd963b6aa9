#include "programs/point_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "armtrue/programs/configuration.h"

namespace armtrue {
namespace {

constexpr int kMaxDecimals = 9;

Eigen::Vector3d at_next_turn(Eigen::Vector3d angles, const Eigen::Vector3d& near) {
  for (int i = 0; i < 3; ++i) angles[i] += kTurn * std::round((near[i] - angles[i]) / kTurn);
  return angles;
}

}  // namespace

std::vector<double> values_of(const std::vector<ProgramNumber>& numbers) {
  std::vector<double> values;
  for (const ProgramNumber& number : numbers) values.push_back(number.value);
  return values;
}

JointVector joints_of_point(const Dialect& dialect, const ProgramPoint& point) {
  std::vector<double> numbers = values_of(point.numbers);
  for (size_t i = 0; i < point.counts_per_unit.size(); ++i) numbers[i] /= point.counts_per_unit[i];
  return dialect.joints_of_numbers(numbers);
}

std::vector<double> numbers_of_joints(const Dialect& dialect, const ProgramPoint& point,
                                      const JointVector& q) {
  std::vector<double> numbers = dialect.numbers_of_joints(q);
  for (size_t i = 0; i < point.counts_per_unit.size(); ++i) numbers[i] *= point.counts_per_unit[i];
  return numbers;
}

int decimals_of(const Dialect& dialect, const ProgramPoint& point, size_t component) {
  return point.counts_per_unit.empty() ? dialect.decimals(point.kind, component) : 0;
}

bool leaves(double low, double high, int joint, const ProgramCommand& command) {
  constexpr double kNoise = 1e-9;  // [rad]
  const double before = beyond(low, high, command.programmed[joint]);
  return before <= kRangeSlack &&
         beyond(low, high, command.q[joint]) > std::max(0.0, before) + kNoise;
}

int written_decimals(std::string_view number) {
  const size_t exponent = std::min(number.find_first_of("eE"), number.size());
  const size_t point = number.find('.');
  int decimals =
      point < exponent ? static_cast<int>(std::min<size_t>(exponent - point - 1, 20)) : 0;
  if (exponent < number.size()) {
    int power = 0;
    size_t from = exponent + 1;
    if (from < number.size() && number[from] == '+') ++from;
    std::from_chars(number.data() + from, number.data() + number.size(), power);
    decimals = power > decimals ? 0 : std::min(decimals - power, kMaxDecimals);
  }
  return std::min(decimals, kMaxDecimals);
}

std::string rounded_text(double value, int at_least, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, std::max(at_least, decimals));
  if (const size_t point = text.find('.'); point != std::string::npos) {
    while (text.size() - point - 1 > static_cast<size_t>(at_least) && text.back() == '0')
      text.pop_back();
    if (text.back() == '.') text.pop_back();
  }
  if (text.find_first_not_of("-0.") == std::string::npos && text[0] == '-') text.erase(0, 1);
  return text;
}

Eigen::Vector3d abc_near(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& near) {
  const Eigen::Vector3d exact = abc_from_rotation(rotation);
  const Eigen::Vector3d other(exact[0] + std::numbers::pi, std::numbers::pi - exact[1],
                              exact[2] + std::numbers::pi);
  Eigen::Vector3d best = at_next_turn(exact, near);
  const auto take = [&](const Eigen::Vector3d& angles) {
    constexpr double kSame = 2e-7;  // [rad]
    const Eigen::Vector3d turned = at_next_turn(angles, near);
    const Eigen::Matrix3d reached = rotation_from_abc(turned[0], turned[1], turned[2]);
    if (rotation_log(rotation * reached.transpose()).norm() > kSame) return;
    if ((turned - near).cwiseAbs().maxCoeff() < (best - near).cwiseAbs().maxCoeff()) best = turned;
  };
  for (const Eigen::Vector3d& angles : {exact, other}) {
    take(angles);
    // Near b = +-pi/2 noise turns a and c against each other: keep c where that gives the rotation.
    const double sign = std::sin(angles[1]) > 0 ? 1 : -1;
    take({angles[0] + sign * (near[2] - angles[2]), angles[1], near[2]});
  }
  return best;
}

Eigen::Vector3d rotation_vector_near(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& near) {
  const Eigen::Vector3d shortest = rotation_log(rotation);
  const double angle = shortest.norm();
  const bool is_nothing = angle < 1e-12;
  if (is_nothing && near.norm() < 1e-3) return shortest;
  const Eigen::Vector3d axis = is_nothing ? near.normalized() : Eigen::Vector3d(shortest / angle);
  Eigen::Vector3d best = shortest;
  for (int k = -2; k <= 2; ++k) {
    const Eigen::Vector3d other = (angle + k * kTurn) * axis;
    if ((other - near).norm() < (best - near).norm()) best = other;
  }
  return best;
}

}  // namespace armtrue
