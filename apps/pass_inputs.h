#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "armtrue/path/simulation.h"
#include "command_line.h"

namespace armtrue::app {

/// What simulate-path is asked for.
struct PassArguments {
  std::string robot, truth, part;
  std::vector<double> orientation_deg, start_deg, engaged_mm, force_n_mm;  ///< empty: not given
  double depth_mm = 8, ramp_mm = 5;
  double force_variation = Cut{}.variation;
  std::uint64_t part_seed = Cut{}.part_seed;
  double lag_s = PassOptions{}.lag;
  double period_ms = 32, clock_offset_s = 0, clock_rate_ppm = 0, noise_mm = 0, noise_n = 0;
  double lost = 0;
  bool joints = false;
};

void add_pass_options(Command& command, PassArguments& arguments);

/// All of a pass but the part.
PassOptions pass_options(const PassArguments& arguments, std::uint64_t seed);

}  // namespace armtrue::app
