#pragma once

#include <vector>

#include "armtrue/campaign/simulation.h"
#include "command_line.h"

namespace armtrue::app {

/// What kinds of readings are asked for.
struct ReadingArguments {
  bool points = false, distances = false, touches = false, beams = false, images = false;
  std::vector<double> profiles;
};

/// The options of readings of which the robot file says where they read.
struct SightOptions {
  Option touches, beams, images, profiles;
};

/// Adds these, --points and --distances.
SightOptions add_reading_options(Command& command, ReadingArguments& arguments);

/// Throws UsageError if no scanner sees what --profiles says.
ReadingKinds reading_kinds(const ReadingArguments& arguments);

}  // namespace armtrue::app
