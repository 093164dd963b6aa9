#pragma once

#include <optional>
#include <string>

#include "armtrue/path/registration/clock.h"

namespace armtrue {

/// The record of a pass that ran at another feed.
struct OtherFeed {
  double ratio = 0;   ///< time in motion of the record over that of the program
  double moving = 0;  ///< time in motion of the record [s]
  /// t_instrument = offset + (1 + rate) t_program, from the begin to the end of the motion. The rate
  /// is that of the feed, not of a clock.
  ClockFit stretch;
};

/// Compares the times from leaving the first place of a path to arriving at its last one, each by 5
/// mm: more than the samples of both hide and than an arm errs along its path. Present if the times
/// differ by more than 1 %, which no clock does, and by more than 5 mm at the speed of the program.
/// Needs no frame. A record that begins or ends in motion looks so, too; see joins().
std::optional<OtherFeed> find_other_feed(const Path& programmed, const Path& measured);

/// Whether the record, stretched so, lies as near to the program as a pass does. `fit_frame`:
/// in whatever frame.
bool joins(const Path& programmed, const Path& measured, const OtherFeed& feed, bool fit_frame);

/// "moves for 14 s, 1.25 times as long as the program: it ran at another feed, ..." with the remedy.
std::string in_words(const OtherFeed& feed);

}  // namespace armtrue
