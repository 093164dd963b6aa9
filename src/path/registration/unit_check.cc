#include "path/registration/unit_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "armtrue/statistics/summary.h"
#include "path/registration/formatted.h"

namespace armtrue {
namespace {

void check_time_unit(const Path& programmed, const Path& measured) {
  const auto duration = [](const Path& path) {
    return path.time[path.samples() - 1] - path.time[0];
  };
  const double longer = duration(measured) / duration(programmed);
  const double window = 0.1 * std::min(duration(measured), duration(programmed));
  const double slower = longest_move(programmed, window) / longest_move(measured, window);
  for (const auto& [factor, what] :
       {std::pair{1e3, "measured path: its clock seems to count milliseconds"},
        {1e6, "measured path: its clock seems to count microseconds"},
        {1e-3, "programmed path: its times seem to be milliseconds"},
        {1e-6, "programmed path: its times seem to be microseconds"}}) {
    // Two indications are required: a record may cover only a part of the program, or contain a
    // long standstill.
    const bool lasts = std::log(longer) / std::log(factor) > 0.5;
    const bool runs = std::abs(std::log(slower / factor)) < std::numbers::ln2;
    if (lasts && runs)
      throw std::invalid_argument(
          "the measured path lasts " + formatted("%.4g", duration(measured)) +
          " s by its column t_s, the "
          "programmed one " +
          formatted("%.4g", duration(programmed)) + " s, and the tool moves " +
          formatted("%.3g", slower) + " times as slowly in it. Correct t_s of the " + what +
          " where the column says s");
  }
}

}  // namespace

// The sixth differences of independent errors are sqrt(924) as large as the errors.
std::optional<double> noise_of_samples(const Path& path) {
  constexpr Eigen::Index kFewestSamples = 50;
  constexpr std::array<double, 7> kBinomials = {1, -6, 15, -20, 15, -6, 1};
  constexpr double kIrregular = 0.01;
  if (path.samples() < kFewestSamples) return std::nullopt;
  const double period = (path.time[path.samples() - 1] - path.time[0]) / (path.samples() - 1);
  std::vector<double> squares;
  for (Eigen::Index i = 0; i + 6 < path.samples(); ++i) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    bool is_regular = true;
    for (Eigen::Index k = 0; k < 7; ++k) {
      sum += kBinomials[k] * path.position.col(i + k);
      if (k > 0)
        is_regular = is_regular && std::abs(path.time[i + k] - path.time[i + k - 1] - period) <
                                       kIrregular * period;
    }
    if (is_regular) squares.push_back(sum.squaredNorm() / 924);
  }
  if (std::ssize(squares) < path.samples() / 2) return std::nullopt;
  constexpr double kMedianOfThree = 2.366;  // of chi-squared with 3 degrees of freedom
  return std::sqrt(median(squares) / kMedianOfThree);
}

namespace {

// A program has no noise, a record has.
void check_not_exchanged(const Path& programmed, const Path& measured) {
  constexpr double kNoNoise = 5e-6, kMuchLess = 0.1;  // m
  const auto of_program = noise_of_samples(programmed), of_record = noise_of_samples(measured);
  if (!of_program || !of_record) return;
  if (*of_program < kNoNoise || *of_record > kMuchLess * *of_program) return;
  throw std::invalid_argument("the programmed path has the noise of a record, " +
                              formatted("%.3g", 1e3 * *of_program) +
                              " mm, and the measured path has none: they look exchanged; give the "
                              "program to --programmed and the record to --measured");
}

}  // namespace

void check_units(const Path& programmed, const Path& measured) {
  const double ratio = extent(measured) / extent(programmed);
  for (const auto& [factor, unit] : {std::pair{1e-3, "in m where the column says mm"},
                                     {1e3, "in mm where the column says m"},
                                     {1 / 25.4, "in inches"},
                                     {25.4, "in mm, while the program is in inches"}})
    if (std::abs(ratio / factor - 1) < 0.1)
      throw std::invalid_argument("the measured path is " + formatted("%.4g", ratio) +
                                  " times as large as the programmed one: it seems to be " + unit +
                                  "; correct the column");
  check_time_unit(programmed, measured);
  check_not_exchanged(programmed, measured);
}

}  // namespace armtrue
