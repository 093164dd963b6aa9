#pragma once

#include <cstdint>
#include <unordered_set>

namespace armtrue {

/// Corrected numbers carry a mark that no other name, order of columns, comment or form of the
/// numbers takes away: their last digits follow from the digits before them. Numbers that are not
/// corrected have them by chance.

/// The command that corrects numbers; each has its own check digits.
enum class Corrector { compensate, mirror };

/// One of so many numbers with a given number of decimals is checked.
enum class CheckSize {
  half = 2,     ///< where numbers may move by little, and there are many: the samples of a path
  quarter = 4,  ///< where there is no room for two more decimals
  /// Two digits, from 01 to 99 without a 0 at the end, which files drop: 90 of 100 are used.
  digits = 100,
};

/// The nearest number with so many decimals that is checked. With `digits`, these are the last of
/// the decimals. The value itself if a double has no room for them.
double checked(double value, int decimals, CheckSize size, Corrector by);

/// The nearest number that is checked after rounding to so many decimals: a program or a table that
/// is saved with fewer decimals keeps its mark. It moves by at most 3.2 units of the last decimal
/// (quarter), or 1.2 (half).
inline constexpr double kMostMovedIfRounded = 3.2;  // units of the last decimal
double checked_if_rounded(double value, int decimals, CheckSize size, Corrector by);

/// Counts the different numbers that have exactly so many decimals, and how many of them are
/// checked. A number whose last decimal is 0 has fewer and does not count: numbers that people
/// write are round. At most 10,000 are counted.
class CheckDigits {
 public:
  CheckDigits(CheckSize size, Corrector by) : size_(size), by_(by) {}
  void add(double value, int decimals);
  /// The same for a number with more decimals, after rounding to so many.
  void add_rounded(double value, int decimals);
  /// Whether so many checked numbers are no chance: p < 1e-7 if none is checked on purpose.
  bool are_found() const;

 private:
  void add_digits(double digits);

  CheckSize size_;
  Corrector by_;
  std::unordered_set<std::uint64_t> numbers_;  // one that is repeated shows nothing more
  int checked_ = 0;
};

}  // namespace armtrue
