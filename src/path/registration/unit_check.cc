#include "armtrue/path/registration/unit_check.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

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
    // Two signs are asked for: a record may cover only a part of the program, or wait for long.
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
}

}  // namespace armtrue
