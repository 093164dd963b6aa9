#pragma once

#include <cstdint>
#include <unordered_set>

namespace armtrue {

/// Corrected numbers carry a mark that no other name, order of columns, comment or form of the
/// numbers takes away: their last digits follow from the digits before them. Numbers that are not
/// corrected have them by chance.

/// What corrects numbers; each has check digits of its own.
enum class Corrector { compensate, mirror };

/// How many numbers with so many decimals there are for each that is checked.
enum class CheckSize {
  half = 2,     ///< where little may move, and many numbers show it: the samples of a path
  quarter = 4,  ///< where there is no room for two more decimals
  /// Two digits, from 01 to 99, the last of them not 0, so that none gets lost: 90 of 100 are used.
  digits = 100,
};

/// The nearest number with so many decimals that is checked. With `digits`, these are the last of
/// the decimals. The value itself if a double has no room for them.
double checked(double value, int decimals, CheckSize size, Corrector by);

/// The nearest number that is checked once it is rounded to so many decimals, whatever stands
/// behind them: a program that is saved with fewer decimals, or a table, keeps its mark. It moves
/// by at most 3.2 units of the last decimal (quarter), or 1.2 (half).
inline constexpr double kMostMovedIfRounded = 3.2;  // units of the last decimal
double checked_if_rounded(double value, int decimals, CheckSize size, Corrector by);

/// Counts the different numbers that have so many decimals, and how many of them are checked.
/// A number whose last decimal is 0 has fewer, so it does not count: numbers that people write are
/// round.
class CheckDigits {
 public:
  CheckDigits(CheckSize size, Corrector by) : size_(size), by_(by) {}
  void add(double value, int decimals);
  /// The same of a number that may have more decimals: what it would be with so many.
  void add_rounded(double value, int decimals);
  /// Whether so many cannot be chance: below 1e-7, if none is checked on purpose.
  bool are_found() const;

 private:
  void add_digits(double digits);

  CheckSize size_;
  Corrector by_;
  std::unordered_set<std::uint64_t> numbers_;  // one that is repeated shows nothing more
  int checked_ = 0;
};

}  // namespace armtrue
