#pragma once

#include <string>

#include "armtrue/urdf/urdf_io.h"

namespace armtrue {

/// Whether a text is the kinematics file of Universal Robots' driver: a map `kinematics` of six
/// transforms, as ur_robot_driver extracts it from a controller and ur_description reads it.
bool is_ur_calibration(const std::string& text);

/// The arm of such a file, with the joints that ur_description builds from it: each rotates about z
/// after its transform. R_A is the controller's frame `base`; the tool is `tool0`. Throws
/// InputError.
Robot parse_ur_calibration(const std::string& text, const std::string& file);

/// The file with the geometry of a robot that parse_ur_calibration() made of it, calibrated or not:
/// only numbers change. The file cannot hold a tool. Throws InputError as write_into_urdf().
PatchedUrdf write_into_ur_calibration(const Robot& robot, const std::string& document,
                                      const std::string& file, const UrdfKept& kept);

}  // namespace armtrue
