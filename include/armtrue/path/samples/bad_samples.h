#pragma once

#include <Eigen/Core>
#include <stdexcept>
#include <vector>

#include "armtrue/path/path.h"

namespace armtrue {

/// A sample that does not show the tool: a blunder of the instrument.
struct BadSample {
  Eigen::Index sample = 0;
  double off = 0;  ///< distance from where its good neighbours show the tool [m]
};

/// Bad samples of a record, in order; neither its clock nor its frame needs to be known. There are
/// three kinds:
/// - frozen: the instrument hung. The record repeats a reading, then jumps to where the tool has
/// got
///   to, by more than the tool travels in a sample plus free play or noise. Repeats at standstill,
///   of a coarse instrument, or of one that is asked more often than it measures, do not end so;
/// - lost lock: the record jumps by more than the tool can travel in a sample (plus 10 mm), and
///   jumps back, however long it was away; exact zeros need not jump back;
/// - departed: up to three samples within a quarter of a second differ from the line through the
///   samples before, from that through the samples after, and from the cubic through both, each
///   time by more than chance in a record of this length and noise, by more than free play, and by
///   more than the program itself goes out and back in as short a time.
/// Steps that stay, corners and reversals are none of them: one side agrees with the samples.
std::vector<BadSample> find_bad_samples(const Path& programmed, const Path& measured);

/// Bad samples once clock and frame are known, from the deviations: measured minus `wanted`, at
/// their times. Smaller departures and shorter hangs stand out in them, except where the program
/// itself turns as suddenly. `known`: the bad samples of the record; they stay bad unless their
/// deviation agrees with that of their neighbours, as where the program stands and the reading is
/// rightly repeated.
std::vector<BadSample> find_bad_deviations(const Path& deviation, const Eigen::Matrix3Xd& wanted,
                                           const std::vector<BadSample>& known);

/// Whether more than a tenth of the record is bad: then the neighbours of a sample are no
/// reference.
bool too_many(const std::vector<BadSample>& bad, const Path& measured);

/// A record of which too many samples are bad (too_many()).
struct TooManyBadSamples : std::invalid_argument {
  TooManyBadSamples(size_t which, std::vector<BadSample> those);
  size_t pass;  ///< index of the record
  std::vector<BadSample> bad;
};

/// The path without the columns of those samples.
Path without(const Path& path, const std::vector<BadSample>& bad);

}  // namespace armtrue
