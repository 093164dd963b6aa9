#pragma once

#include <deque>
#include <string>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "compensation/program_arm.h"
#include "compensation/programmed_joints.h"

namespace armtrue {

/// Both models with one frame and one tool of a program.
struct Arms {
  Arms(const Robot& of_identified, const Robot& of_controller, const Program& program,
       const CompensationOptions& own)
      : options(own),
        identified(of_identified, options, options.tool, program.visits.temperature_names),
        controller(of_controller, of_controller_alone(program), options.tool,
                   program.visits.temperature_names),
        programmed(program, options, controller) {}
  Arms(const Arms&) = delete;
  Arms& operator=(const Arms&) = delete;

  // A controller drives the external axes to where the program has them.
  CompensationOptions of_controller_alone(const Program& program) const {
    CompensationOptions alone = options;
    if (program.states_external) alone.move_external_axes = false;
    return alone;
  }

  CompensationOptions options;
  ProgramArm identified, controller;
  ProgrammedJoints programmed;
};

/// One for each frame and tool of the program; they refer to their own members and must not move.
std::deque<Arms> arms_of(const Robot& identified, const Robot& controller, const Program& program,
                         const CompensationOptions& options);

/// The arms of a row.
inline size_t set_up_of(const Program& program, size_t row) {
  return program.set_up.empty() ? 0 : static_cast<size_t>(program.set_up[row]);
}

/// Some rows of a program; a row may stand several times.
Program select(const Program& program, const std::vector<int>& rows);

/// The program with the measured tool of the robot in place of its tools; so in the options.
Program with_measured_tool(const Robot& identified, Program program, CompensationOptions& options);

}  // namespace armtrue
