#pragma once

#include <functional>
#include <string>
#include <vector>

#include "armtrue/compensation/move_division.h"
#include "armtrue/compensation/program_targets.h"
#include "correction_inputs.h"

namespace armtrue::app {

/// Commands for all targets of a file, or of a program with the joints `joints`; `command` says
/// what is in doubt. `postures_at_calls`: those of a program that does not say in which posture it
/// begins. Throws InputError for targets that cannot be, or that were corrected before.
DividedProgram correct(Command& command, const Models& models, RobotProgram* program,
                       const ProgramJoints& joints, ProgramFile& file,
                       CorrectionArguments arguments,
                       const std::function<PosturesAtCalls()>& postures_at_calls = {});

/// Reasons to doubt the assumptions of commands, in sentences.
std::vector<std::string> doubts_of_commands(const Models& models,
                                            const std::vector<CorrectedTarget>& targets,
                                            const Campaign& visits,
                                            const CorrectionArguments& arguments);

bool is_noted(const std::vector<CorrectedTarget>& targets);

/// The programs of a folder, each by itself; their texts are written together. Returns the exit
/// code.
int correct_folder(Command& command, const Models& models, CorrectionArguments& arguments);

}  // namespace armtrue::app
