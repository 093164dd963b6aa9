#pragma once

#include <string>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// Mistakes in a robot program that leave plausible targets, as sentences: joint angles in rad, or
/// in deg where UR counts rad; points, a frame or a tool in m; rotations of UR in deg; a program
/// without a tool, for which its controller takes the one that is active; and calls of routines
/// that may set another. `options`: tool and base of targets
/// that name none; `has_tool`: whether that tool was stated.
std::vector<std::string> doubts_of_program(const RobotProgram& program,
                                           const CompensationOptions& options, bool has_tool);

/// Whether a tool looks as if it were given in m, as a sentence; empty if not.
std::string doubt_of_tool(const std::string& name, const Pose& tool);
/// The same for a frame in R_0.
std::string doubt_of_frame(const std::string& name, const Pose& frame);

/// Whether joint angles that an option states in deg look like radians, as a sentence; empty if
/// not.
std::string doubt_of_joints(const std::string& option, const std::vector<double>& degrees);

/// Whether the poses of a table of targets look as if they were given in m, as a sentence with the
/// name of its file; empty if not.
std::string doubt_of_table(const std::string& file, const Program& program);

/// Cartesian targets whose hints, the joint angles of the controller, contradict them: a base or a
/// tool that is not stated, y with the other sign, another unit, another convention of angles, or
/// hints of the row before. A cause is named only if it makes all rows agree to 1 mm (a unit or a
/// sign to 5 mm, because corrected targets lie as far from their hints); rough hints show nothing.
/// A sentence; empty if there is none.
std::string contradiction_of_hints(const Program& program, const Robot& controller,
                                   const CompensationOptions& options);

}  // namespace armtrue
