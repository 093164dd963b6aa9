#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "armtrue/path/path.h"

namespace armtrue {

/// A stop of the tool within a record, at a place where the program moves on.
struct Pause {
  Eigen::Index sample;  ///< of the record, the first of the stop
  double begin;         ///< time of the instrument [s]
  double longer;        ///< than the program stands near that place [s]
  double speed;         ///< of the program, its median in motion [m/s]
};

/// The longest stop of the record of more than 0.3 s in which the program moves on by more than 5
/// mm. The tool stands where it moves, in a tenth of a second, by less than a tenth of what the
/// program usually does. Places are compared by their share of the way, so no frame and no clock
/// are needed.
std::optional<Pause> find_pause(const Path& programmed, const Path& measured);

/// "stands for 0.5 s longer than the program ..." with the remedy.
std::string in_words(const Pause& pause);

}  // namespace armtrue
