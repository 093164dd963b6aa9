#pragma once

#include <Eigen/Core>
#include <stdexcept>
#include <vector>

#include "armtrue/path/path.h"

namespace armtrue {

/// A sample that is no reading of the tool: an instrument's blunder.
struct BadSample {
  Eigen::Index sample = 0;
  double off = 0;  ///< from where its good neighbours show the tool [m]
};

/// Samples of a record at which the instrument did not see the tool, in order; no clock or frame
/// needs to be known. Three things give them away:
/// - the record repeats a reading and then goes on from where the tool has got to since, by more
///   than it moves at once, free play and what resolution and noise may hide (an instrument that
///   hung); repeats at standstill, of a coarse instrument or of one that is asked more often than
///   it measures end otherwise;
/// - the record leaves by more than the tool can travel in a sample and comes back as suddenly,
///   however long it was away (a lost lock, or another reflector); exact zeros need not come back;
/// - up to three samples, within a quarter of a second, depart from what those before show, from
///   what those after show, and from what both show together, by more than chance in a record of
///   this length and noise, by more than free play, and by more than the program itself goes out
///   and back in as short a time.
/// Steps that stay, corners and reversals do neither: on one side the neighbours agree with them.
std::vector<BadSample> find_bad_samples(const Path& programmed, const Path& measured);

/// The same once clock and frame are known: of deviations (measured minus `wanted`), with their
/// times, smaller departures and shorter hangs stand out, except where the program itself turns as
/// suddenly. `known` are those of the record; they are bad unless their deviation is that of their
/// neighbours, as where a reading is repeated because the program stands.
std::vector<BadSample> find_bad_deviations(const Path& deviation, const Eigen::Matrix3Xd& wanted,
                                           const std::vector<BadSample>& known);

/// More of them than the neighbours of each can be relied on.
bool too_many(const std::vector<BadSample>& bad, const Path& measured);

/// A record with too many of them.
struct TooManyBadSamples : std::invalid_argument {
  TooManyBadSamples(size_t which, std::vector<BadSample> those);
  size_t pass;  ///< which of the records
  std::vector<BadSample> bad;
};

/// The path without those samples, all their columns.
Path without(const Path& path, const std::vector<BadSample>& bad);

}  // namespace armtrue
