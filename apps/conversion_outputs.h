#pragma once

#include <string>

#include "armtrue/effects/robot.h"
#include "command_line.h"
#include "conversion_inputs.h"

namespace armtrue::app {

/// The robot as a file without effects holds it best; `command` says both errors.
Robot with_constants_alone(Command& command, const Robot& given, const std::string& file,
                           const ConversionArguments& arguments);

/// The document of --into with the geometry of a robot without effects.
std::string into_urdf(Command& command, const Robot& robot, const ConversionArguments& arguments);
std::string into_controller(Command& command, const Robot& robot,
                            const ConversionArguments& arguments);

/// The table of the controller's own fields. Zero offsets are all that mastering holds: they stand
/// for lengths and effects as far as they can.
std::string controller_fields(Command& command, const Robot& robot, const std::string& file,
                              const ConversionArguments& arguments);

}  // namespace armtrue::app
