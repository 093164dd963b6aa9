#pragma once

#include <string>

#include "armtrue/programs/krl.h"

namespace armtrue {

/// Reads a program. Without `dat` that beside `src` with the same name is taken, if there is one.
/// Throws InputError if a file cannot be read.
KrlProgram read_krl(const std::string& src, const std::string& dat = "");

}  // namespace armtrue
