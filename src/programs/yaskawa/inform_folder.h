#pragma once

#include <memory>
#include <vector>

#include "armtrue/programs/dialect.h"

namespace armtrue {

/// See FolderTexts: the variables that jobs set, and the frames and tools that called jobs set.
std::unique_ptr<FolderTexts> inform_folder(const std::vector<const ProgramText*>& texts);

}  // namespace armtrue
