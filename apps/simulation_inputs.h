#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "armtrue/campaign/simulation.h"
#include "command_line.h"
#include "reading_inputs.h"

namespace armtrue::app {

/// What simulate-poses is asked for.
struct SimulationArguments {
  std::string robot, truth, targets;
  int count = SimulationOptions{}.poses, repeats = SimulationOptions{}.repeats;
  double noise_mm = 0, noise_mrad = 0, noise_px = 0, blunders = 0;
  ReadingArguments readings;
  std::string order = "random";
  std::vector<double> box_mm;
};

void add_simulation_options(Command& command, SimulationArguments& arguments);

SimulationOptions simulation_options(const SimulationArguments& arguments, std::uint64_t seed);

}  // namespace armtrue::app
