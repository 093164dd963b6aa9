#pragma once

#include <string>

#include "armtrue/import/import_io.h"
#include "command_line.h"

namespace armtrue::app {

/// What import-readings is asked for.
struct ImportArguments {
  std::string points, joints, robot, urdf, images, board, camera;
  bool is_pass = false;  ///< the table is the record of a motion
  ImportOptions import;
};

void add_import_options(Command& command, ImportArguments& arguments);

/// Reads robot and URDF into the options. Throws UsageError for inputs that do not go together.
void complete(Command& command, ImportArguments& arguments);

}  // namespace armtrue::app
