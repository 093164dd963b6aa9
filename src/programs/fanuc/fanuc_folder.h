#pragma once

#include <memory>
#include <vector>

#include "armtrue/programs/dialect.h"

namespace armtrue {

/// See FolderTexts: listings of a controller, and the position registers to which programs give
/// values.
std::unique_ptr<FolderTexts> fanuc_folder(const std::vector<const ProgramText*>& texts);

}  // namespace armtrue
