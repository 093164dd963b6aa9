#pragma once

#include <string>

#include "armtrue/effects/robot.h"
#include "armtrue/urdf/urdf_io.h"

namespace armtrue {

/// Whether a text is calibration.conf of a controller of Universal Robots: `delta_theta`,
/// `delta_a`, `delta_d` and `delta_alpha`, six numbers each [rad, m], which are added to the DH
/// parameters of the type in the standard convention,
///     R_{j-1} from R_j = Rot(z, theta_j) Trans(z, d_j) Trans(x, a_j) Rot(x, alpha_j).
/// Where two axes are almost parallel, their common normal may lie metres beside the arm: delta_d
/// is then that large.
bool is_ur_conf(const std::string& text);

/// The arm of such a file with frames as parse_urdf() lays them. `nominal`: the arm of the type by
/// its DH parameters, a robot file with `convention: standard` such as the shipped UR5e; `about`:
/// its file, for messages. Throws InputError.
Robot parse_ur_conf(const std::string& text, const std::string& file, const Robot& nominal,
                    const std::string& about);

/// The file with the geometry of `robot`; only the numbers of the four lines change. The file holds
/// no base and no tool: R_0 is on axis 1 and R_7 on axis 6. The shifts of base and tool that are
/// not written are `base` and `tool_left_out` of the result. Throws InputError if the robot is
/// another arm than `nominal`.
PatchedUrdf write_into_ur_conf(const Robot& robot, const std::string& document,
                               const std::string& file, const Robot& nominal,
                               const std::string& about);

}  // namespace armtrue
