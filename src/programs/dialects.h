#pragma once

#include "armtrue/programs/dialect.h"

// The makers, each in its folder.

namespace armtrue {

const Dialect& krl_dialect();
const Dialect& rapid_dialect();
const Dialect& fanuc_dialect();
const Dialect& urscript_dialect();
const Dialect& polyscope_dialect();
const Dialect& inform_dialect();

}  // namespace armtrue
