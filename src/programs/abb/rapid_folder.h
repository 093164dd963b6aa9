#pragma once

#include <memory>
#include <vector>

#include "armtrue/programs/dialect.h"

namespace armtrue {

/// See FolderTexts: modules that declare global data, and what modules do to data.
std::unique_ptr<FolderTexts> rapid_folder(const std::vector<const ProgramText*>& modules);

}  // namespace armtrue
