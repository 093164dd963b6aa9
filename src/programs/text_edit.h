#pragma once

#include <string>
#include <vector>

#include "armtrue/programs/program_text.h"

namespace armtrue {

/// The text of one file with its edits, which must not overlap; those at one place keep their
/// order.
std::string apply_edits(const std::string& text, const std::vector<TextEdit>& edits, int file);

}  // namespace armtrue
