#include "programs/point_numbers.h"

namespace armtrue {

JointVector joints_of_point(const Dialect& dialect, const ProgramPoint& point) {
  std::vector<double> numbers;
  for (const ProgramNumber& number : point.numbers) numbers.push_back(number.value);
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

}  // namespace armtrue
