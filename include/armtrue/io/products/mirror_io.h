#pragma once

#include <string>

#include "armtrue/io/document.h"
#include "armtrue/io/provenance.h"
#include "armtrue/path/mirror/findings.h"

namespace armtrue {

/// armtrue-mirror/1: clocks of the passes with their uncertainty, noise, deviation before the
/// correction, the correction and the deviation expected after it; accuracy after ISO 9283; the
/// force law and the steps at reversals.
Document write_mirror(const MirrorFindings& findings, const Provenance& provenance);

}  // namespace armtrue
