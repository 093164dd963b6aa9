#pragma once

#include <memory>
#include <vector>

#include "armtrue/programs/dialect.h"

namespace armtrue {

/// See FolderTexts: $config.dat and PUBLIC data lists, and to what names sources give values.
std::unique_ptr<FolderTexts> krl_folder(const std::vector<const ProgramText*>& texts);

}  // namespace armtrue
