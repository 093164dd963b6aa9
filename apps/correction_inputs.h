#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/programs/robot_program.h"
#include "command_line.h"
#include "program_arguments.h"
#include "program_project.h"
#include "report_arguments.h"
#include "robot_program_files.h"

namespace armtrue::app {

/// What compensate is asked for.
struct CorrectionArguments : ProgramArguments {
  std::string commands, summary, uncovered = "keep";
  bool strict = false, require_all = false;
  double max_mm = CompensationOptions{}.max_correction / kMillimetre;
  std::optional<double> spacing_mm;
  bool move_external_axes = false;
  RobotProgramFiles program;
  ProjectFiles project;
  ReportArguments page;
  std::optional<JointVector> posture_of_calls;  ///< --start, where the callers of a program tell it
};

void add_correction_options(Command& command, CorrectionArguments& arguments);

CompensationOptions compensation_options(const CorrectionArguments& arguments, const Robot& robot);

/// Throws UsageError if every target of a program states its own tool, or its own frame, and
/// --tool, or --base, gives another.
void refuse_overruled_frames(const RobotProgram& program, const ProgramArguments& arguments);

/// The kind of the commands for the targets of a table.
CommandKind command_kind(const CorrectionArguments& arguments, const Program& program);

/// What the commands assume of controller, tool and frames, in sentences. `program`: may be null.
std::vector<std::string> assumptions(const Robot& controller, const RobotProgram* program,
                                     const CorrectionArguments& arguments);

}  // namespace armtrue::app
