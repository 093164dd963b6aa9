#pragma once

#include <cstdint>
#include <unordered_set>

namespace armtrue {

/// Corrected numbers carry a mark that no other name, order of columns, comment or form of the
/// numbers takes away: their last digits follow from the digits before them. Numbers that are not
/// corrected have them by chance.

/// What corrects numbers; each has check digits of its own.
enum class Corrector { compensate, mirror };

/// How many numbers the last digits tell apart.
enum class CheckSize {
  bit = 2,       ///< the last digit is even or odd: where there is no room for two more
  digits = 100,  ///< two digits, from 01 to 99, the last of them not 0, so that none gets lost
};

/// The nearest number with so many decimals that has its check digits, which are the last of these
/// decimals. The value itself if a double has no room for them.
double checked(double value, int decimals, CheckSize size, Corrector by);

/// Counts the different numbers that have so many decimals, and how many of them are checked.
class CheckDigits {
 public:
  CheckDigits(CheckSize size, Corrector by) : size_(size), by_(by) {}
  void add(double value, int decimals);
  /// Whether so many cannot be chance.
  bool are_found() const;

 private:
  CheckSize size_;
  Corrector by_;
  std::unordered_set<std::uint64_t> numbers_;  // one that is repeated shows nothing more
  int checked_ = 0;
};

}  // namespace armtrue
