#include "armtrue/statistics/check_digits.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "armtrue/statistics/distributions.h"

namespace armtrue {
namespace {

constexpr double kMostDigits = 1e15;  // that a double keeps

// A number without its point, of so many decimals.
double digits_of(double value, int decimals) { return std::abs(value) * std::pow(10.0, decimals); }

// The last step of splitmix64 (Steele, Lea, Flood 2014), so that numbers that follow one another
// have check digits that do not.
std::uint64_t mixed(std::uint64_t digits) {
  digits = (digits ^ digits >> 30) * 0xbf58476d1ce4e5b9;
  digits = (digits ^ digits >> 27) * 0x94d049bb133111eb;
  return digits ^ digits >> 31;
}

std::uint64_t base_of(CheckSize size) { return static_cast<std::uint64_t>(size); }

// How many check digits there are.
std::uint64_t checks(CheckSize size) { return size == CheckSize::digits ? 90 : base_of(size); }

std::uint64_t check_of(std::uint64_t before, CheckSize size, Corrector by) {
  const std::uint64_t check = mixed(2 * before + (by == Corrector::mirror)) % checks(size);
  return size == CheckSize::digits ? check + check / 9 + 1 : check;
}

// A number that ends with 0 has fewer decimals, and says nothing.
bool says_nothing(std::uint64_t number) { return number % 10 == 0; }

bool is_checked(std::uint64_t number, CheckSize size, Corrector by) {
  return number % base_of(size) == check_of(number / base_of(size), size, by);
}

}  // namespace

double checked(double value, int decimals, CheckSize size, Corrector by) {
  const double exact = digits_of(value, decimals);
  if (!(exact < kMostDigits)) return value;
  const std::uint64_t base = base_of(size);
  const auto before = static_cast<std::uint64_t>(exact) / base;
  std::optional<double> nearest;
  for (std::uint64_t p = before - (before > 0); p <= before + 1; ++p) {
    const auto digits = static_cast<double>(p * base + check_of(p, size, by));
    if (!nearest || std::abs(digits - exact) < std::abs(*nearest - exact)) nearest = digits;
  }
  return std::copysign(*nearest / std::pow(10.0, decimals), value);
}

double checked_if_rounded(double value, int decimals, CheckSize size, Corrector by) {
  constexpr double kWithin = 1.0 / 3;  // of the last decimal: two check digits move it by 0.1
  const double exact = digits_of(value, decimals);
  if (!(exact < kMostDigits)) return value;
  const auto rounded = static_cast<std::uint64_t>(std::round(exact));
  if (says_nothing(rounded) || is_checked(rounded, size, by)) {
    const auto middle = static_cast<double>(rounded);
    return std::copysign(std::clamp(exact, middle - kWithin, middle + kWithin) /
                             std::pow(10.0, decimals),
                         value);
  }
  const double middle = digits_of(checked(value, decimals, size, by), decimals);
  return std::copysign(std::clamp(exact, middle - kWithin, middle + kWithin) /
                           std::pow(10.0, decimals),
                       value);
}

void CheckDigits::add(double value, int decimals) {
  constexpr double kRounding = 0.05;  // of the last digit, of numbers read in another unit
  const double exact = digits_of(value, decimals), digits = std::round(exact);
  if (std::abs(exact - digits) <= kRounding) add_digits(digits);
}

void CheckDigits::add_rounded(double value, int decimals) {
  add_digits(std::round(digits_of(value, decimals)));
}

void CheckDigits::add_digits(double digits) {
  constexpr size_t kMostNumbers = 10000;  // as many as show it
  if (!(digits < kMostDigits)) return;
  const auto number = static_cast<std::uint64_t>(digits);
  if (says_nothing(number)) return;
  if (numbers_.size() == kMostNumbers || !numbers_.insert(number).second) return;
  checked_ += is_checked(number, size_, by_);
}

bool CheckDigits::are_found() const {
  // A file is looked at for two correctors, in a few units and with two sizes: together one in a
  // million.
  constexpr double kChance = 1e-7;
  return checked_ > 0 &&
         binomial_at_least(checked_, static_cast<int>(numbers_.size()),
                           1.0 / static_cast<double>(checks(size_))) < kChance;
}

}  // namespace armtrue
