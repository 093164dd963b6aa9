#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/kinematics/units.h"
#include "armtrue/path/mirror/findings.h"
#include "armtrue/path/mirror/mirror.h"
#include "command_line.h"
#include "path_program.h"
#include "report_arguments.h"

namespace armtrue::app {

/// What mirror-correct is asked for.
struct MirrorArguments {
  std::string programmed, robot, previous;
  std::vector<std::string> measured, before, forces;
  bool from_force = false, engaged_only = false, fit_frame = false;
  int order = MirrorOptions{}.order;
  double goal_mm = kFormGoal / kMillimetre;
  std::string cutoff_hz = "1.5625", gain = "auto", points = "turning";
  std::optional<double> max_mm, offset_s, force_offset_s;
  PathProgramArguments program;
  std::string poses, summary, deviation;
  ReportArguments page;
};

void add_mirror_options(Command& command, MirrorArguments& arguments);

/// All but the correction that the passes ran.
MirrorOptions mirror_options(const MirrorArguments& arguments);

/// The files of one run.
struct MirrorInputs {
  PathFile programmed;
  std::optional<Robot> robot;
  std::vector<PathFile> passes, earlier;
  std::vector<PathFile> forces;  ///< of each pass, or none
  std::optional<PathFile> previous;
  std::optional<RobotProgram> program;
  std::optional<About> about;
};

/// Throws InputError for a file that armtrue corrected, and warns of files that are the same,
/// computed or copied.
MirrorInputs read_mirror_inputs(Command& command, const MirrorArguments& arguments);

}  // namespace armtrue::app
