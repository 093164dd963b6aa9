#pragma once

#include <string>

#include "armtrue/diagnosis/change.h"
#include "armtrue/io/document.h"
#include "armtrue/io/provenance.h"

namespace armtrue {

/// armtrue-change/1: whether a calibration still holds and, if not, what has moved. Lists each move
/// whose p-value is below kChangeSignificance or that cannot be distinguished from the best.
Document write_change(const ChangeResult& result, const Robot& previous, const Campaign& campaign,
                      const Provenance& provenance);

}  // namespace armtrue
