#pragma once

#include <Eigen/Core>
#include <stdexcept>
#include <vector>

#include "armtrue/path/path.h"

namespace armtrue {

/// A sample that does not show the position of the tool: a blunder of the instrument.
struct BadSample {
  Eigen::Index sample = 0;
  double off = 0;  ///< distance from the position that its good neighbours show [m]
};

/// Bad samples of a record, in order. Clock and frame of the record need not be known. There are
/// three kinds:
/// - frozen: the instrument hung. The record repeats a reading, then jumps to the true position, by
///   more than the tool travels in a sample plus free play or noise. Repeats at standstill, of a
///   coarse instrument, or of one that is asked more often than it measures, do not end with such a
///   jump;
/// - lost lock: the record jumps by more than the tool can travel in a sample (plus 10 mm), and
///   jumps back, after any time; exact zeros need not jump back;
/// - departed: up to three samples within a quarter of a second differ from the line through the
///   samples before, from that through the samples after, and from the cubic through both. Each of
///   these differences exceeds chance in a record of this length and noise, free play, and the
///   largest departure of the program itself that returns in as short a time.
/// Lasting steps, corners and reversals are not bad: one side agrees with the samples.
std::vector<BadSample> find_bad_samples(const Path& programmed, const Path& measured);

/// Bad samples, once clock and frame are known, from the deviations: measured minus `wanted`, at
/// the times of the samples. Deviations show smaller departures and shorter freezes, except where
/// the program itself turns as suddenly. `known`: the bad samples of the record. They stay bad
/// unless their deviation agrees with that of their neighbours, for example where the program
/// stands still and a repeated reading is right.
std::vector<BadSample> find_bad_deviations(const Path& deviation, const Eigen::Matrix3Xd& wanted,
                                           const std::vector<BadSample>& known);

/// Whether more than a tenth of the record is bad: then the neighbours of a sample cannot serve as
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
