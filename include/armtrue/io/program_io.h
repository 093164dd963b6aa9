#pragma once

#include <string>

#include "armtrue/programs/krl.h"

namespace armtrue {

/// Reads a program. Without `dat`, the .dat file beside `src` with the same name is read, if there
/// is one. Throws InputError if a file cannot be read.
KrlProgram read_krl(const std::string& src, const std::string& dat = "");

}  // namespace armtrue
