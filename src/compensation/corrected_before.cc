#include "armtrue/compensation/corrected_before.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/distributions.h"

namespace armtrue {
namespace {

constexpr int kMostDecimals = 9;  // as a double of some metres has no more

double grid_step(int decimals) { return std::pow(10.0, -decimals); }

// Distance from the nearest number with so many decimals.
double distance_from_grid(double value, int decimals) {
  const double scale = std::pow(10.0, decimals);
  return std::abs(value - std::round(value * scale) / scale);
}

int decimals_of(double value) {
  int decimals = 0;
  while (decimals < kMostDecimals && distance_from_grid(value, decimals) > 1e-9) ++decimals;
  return decimals;
}

// By how much a number may be off: by rounding, of a correction with its decimals, or with the most
// that are left of them, and by its check digits. A single number may be shorter, because zeros at
// its end were dropped. `other_unit`: factor to another unit in which the numbers may be rounded.
std::vector<double> roundings(const std::vector<NumberBeside>& numbers, double least,
                              double other_unit) {
  constexpr double kHalf = 0.6;  // of a step, and what the other numbers of the point add
  struct Longest {
    int decimals = 0, of_other_unit = 0;
  };
  std::map<int, Longest> longest;  // by the decimals of a correction
  for (const NumberBeside& number : numbers) {
    Longest& most = longest[number.decimals];
    most.decimals = std::max(most.decimals,
                             std::min(number.decimals, decimals_of(number.written)));
    most.of_other_unit =
        std::max(most.of_other_unit, decimals_of(number.written * other_unit));
  }
  std::vector<double> result;
  for (const NumberBeside& number : numbers) {
    const Longest& most = longest[number.decimals];
    const double step =
        std::max(grid_step(most.decimals), most.of_other_unit < kMostDecimals
                                               ? grid_step(most.of_other_unit) / other_unit
                                               : 0);
    result.push_back(std::max(kHalf * step + number.moved, least));
  }
  return result;
}

// One number of a hundred is short where the arm takes it for a reason of its own: an axis of the
// wrist that the minimum leaves at 0, a face that is level in both models.
constexpr double kShortByAccident = 0.01;

// Looks at the numbers off the grid of so many decimals that the arm takes to other numbers. Those
// of one component that are off by the same amount, or are taken to the same number, count once: an
// error that is the same everywhere moves them alike, and a singular posture has one angle.
struct RoundOnGrid {
  RoundWhereReached found;
  double chance = 1;  ///< that so many are round

  RoundOnGrid(const std::vector<NumberBeside>& numbers, const std::vector<double>& rounding,
              int decimals) {
    found.decimals = decimals;
    constexpr double kMostChance = 0.2;  // of one number: finer grids show nothing
    std::set<std::pair<int, long long>> counted, reached;
    double most = kShortByAccident;
    for (size_t i = 0; i < numbers.size(); ++i) {
      const NumberBeside& number = numbers[i];
      const double one = 2 * rounding[i] / grid_step(decimals);
      if (one > kMostChance ||
          distance_from_grid(number.written, decimals) <= 2 * rounding[i] ||
          std::abs(number.beside - number.written) <= rounding[i])
        continue;
      const double rest =
          number.written - std::floor(number.written / grid_step(decimals)) * grid_step(decimals);
      if (!counted.emplace(number.component, std::llround(rest / (4 * rounding[i]))).second)
        continue;
      const bool is_round = distance_from_grid(number.beside, decimals) <= rounding[i];
      if (is_round &&
          !reached
               .emplace(number.component, std::llround(number.beside / grid_step(decimals)))
               .second)
        continue;
      most = std::max(most, one);
      ++found.numbers;
      if (!is_round) continue;
      if (found.round++ > 0) continue;
      found.target = static_cast<int>(number.target);
      found.written = number.written;
      found.reached = number.beside;
    }
    if (found.round > 0) chance = binomial_at_least(found.round, found.numbers, most);
  }
};

// Of some hundred targets, evenly spread: they show it as well as a million.
std::vector<NumberBeside> some_of(const std::vector<NumberBeside>& numbers) {
  constexpr size_t kTargetsToCompare = 500;
  const size_t targets = numbers.empty() ? 0 : numbers.back().target + 1;
  std::vector<NumberBeside> some;
  for (const NumberBeside& number : numbers)
    if (number.target % (targets / kTargetsToCompare + 1) == 0) some.push_back(number);
  return some;
}

// `least`: exactness of the joint angles that compensate() finds, in the unit of the numbers.
std::optional<RoundWhereReached> find_round(const std::vector<NumberBeside>& all, double least,
                                            double other_unit = 1) {
  constexpr double kChance = 1e-8;  // of one grid: a file in a million
  const std::vector<NumberBeside> numbers = some_of(all);
  const std::vector<double> rounding = roundings(numbers, least, other_unit);
  std::optional<RoundOnGrid> best;
  for (int decimals = -1; decimals < kMostDecimals; ++decimals) {
    const RoundOnGrid grid(numbers, rounding, decimals);
    if (!best || grid.chance < best->chance) best = grid;
  }
  return best->chance < kChance ? std::optional(best->found) : std::nullopt;
}

constexpr double kExactLength = 2e-6, kExactAngle = 2e-7;  // [mm], [deg]; see compensate()

}  // namespace

std::optional<RoundWhereReached> find_round_where_reached(
    const RobotProgram& program, const std::vector<CorrectedTarget>& targets,
    const ProgramJoints& joints) {
  std::vector<ProgramCommand> reached;
  for (size_t k = 0; k < targets.size(); ++k) {
    const CorrectedTarget& target = targets[k];
    const JointVector& written = program.targets[k].q;
    reached.push_back({true,
                       joints.arm_of(target.programmed, written),
                       joints.arm_of(target.reached_q, written),
                       target.reached,
                       {}});
  }
  return find_round(numbers_beside(program, reached), 0);
}

std::optional<RoundWhereReached> find_round_where_reached(
    const Robot& controller, const std::vector<CorrectedTarget>& targets) {
  constexpr int kLengths = 7, kAngles = 9;  // decimals of corrections in a table
  const std::vector<JointName> names = joint_names(controller.chain);
  std::vector<NumberBeside> lengths, angles, joint_lengths, joint_angles;
  for (size_t row = 0; row < targets.size(); ++row) {
    const CorrectedTarget& target = targets[row];
    const Eigen::Vector3d written = abc_from_rotation(target.intended.rotation) / kDegree,
                          reached = abc_from_rotation(target.reached.rotation) / kDegree;
    for (int i = 0; i < 3; ++i) {
      lengths.push_back({i, target.intended.translation[i] / kMillimetre,
                         target.reached.translation[i] / kMillimetre, kLengths, 0, row});
      angles.push_back({i, written[i], reached[i], kAngles, 0, row});
    }
    for (size_t j = 0; j < names.size(); ++j) {
      const Eigen::Index at = j;
      (names[j].is_length ? joint_lengths : joint_angles)
          .push_back({static_cast<int>(j), target.programmed[at] / names[j].si(),
                      target.reached_q[at] / names[j].si(),
                      names[j].is_length ? kLengths : kAngles, 0, row});
    }
  }
  for (const std::vector<NumberBeside>* numbers : {&lengths, &joint_lengths})
    if (const auto found = find_round(*numbers, kExactLength)) return found;
  for (const std::vector<NumberBeside>* numbers : {&angles, &joint_angles})
    if (const auto found = find_round(*numbers, kExactAngle, kDegree)) return found;
  return std::nullopt;
}

}  // namespace armtrue
