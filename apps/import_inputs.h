#pragma once

#include <string>
#include <vector>

#include "armtrue/import/import_io.h"
#include "armtrue/programs/timed_path.h"
#include "command_line.h"

namespace armtrue::app {

/// What import-readings is asked for.
struct ImportArguments {
  std::string points, joints, robot, urdf, images, board, camera;
  bool is_pass = false;  ///< the table is the record of a motion
  std::string program;   ///< a robot program, whose path is wanted; empty: none
  std::vector<std::string> with;
  double feed_mm_s = 0, acceleration_m_s2 = ProgramSpeed{}.acceleration;
  double period_ms = ProgramSpeed{}.period / 1e-3;
  ImportOptions import;
};

void add_import_options(Command& command, ImportArguments& arguments);

/// Reads robot and URDF into the options. Throws UsageError for inputs that do not go together.
void complete(Command& command, ImportArguments& arguments);

}  // namespace armtrue::app
