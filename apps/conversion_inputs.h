#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/effects/robot.h"
#include "armtrue/urdf/urdf_io.h"
#include "command_line.h"

namespace armtrue::app {

/// What convert-robot is asked for.
struct ConversionArguments {
  std::string to, into, nominal, poses;
  UrdfEnds ends;
  UrdfKept kept;
  std::vector<double> counts_per_degree;
  std::optional<double> payload_kg, time_s, temperature_c;
};

void add_conversion_options(Command& command, ConversionArguments& arguments);

/// The robot in the text of a file: YAML, URDF, or calibration of Universal Robots. `command` says
/// what of a URDF the user may have meant otherwise.
Robot read_any_robot(Command& command, const std::string& text, const std::string& file,
                     const ConversionArguments& arguments);

/// --nominal. Throws InputError with `why` without it.
Robot nominal_robot(Command& command, const ConversionArguments& arguments, const std::string& why);

/// Throws a mistake in the arguments, or in what they do with this text.
void check_usage(const Command& command, const ConversionArguments& arguments,
                 const std::string& text);

}  // namespace armtrue::app
