#pragma once

#include <string>
#include <vector>

#include "armtrue/effects/robot.h"

namespace armtrue {

/// A URDF document (metres, radians): `world` is R_A, `base_link` R_0, then one link for each link
/// of the chain and `tool` for the measured frame. The seven link entries are also kept as
/// attributes that other readers ignore, so that reading the document back gives the same numbers
/// to the last digit.
std::string write_urdf(const Robot& robot);

/// The keys of the robot file that URDF cannot hold and this robot has.
std::vector<std::string> lost_in_urdf(const Robot& robot);

/// Reads a URDF of a serial arm with six revolute joints, parsed by urdfdom. Links written by
/// write_urdf come back as they were; any other arm gets Khalil's frames from the common normals of
/// its axes, beta = 0. Throws InputError: no valid URDF, a branched chain, another number of driven
/// joints.
Robot parse_urdf(const std::string& text, const std::string& file);

}  // namespace armtrue
