#include "armtrue/statistics/check_digits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace armtrue::check_digits_test {
namespace {

constexpr int kDecimals = 6;

double rounded(double value, int decimals) {
  const double scale = std::pow(10.0, decimals);
  return std::round(value * scale) / scale;
}

std::vector<double> values(int count, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-3000, 3000);
  std::vector<double> result;
  for (int k = 0; k < count; ++k) result.push_back(any(random));
  return result;
}

bool found(const std::vector<double>& numbers, CheckSize size, int decimals = kDecimals,
           Corrector by = Corrector::mirror) {
  CheckDigits digits(size, by);
  for (const double number : numbers) digits.add(number, decimals);
  return digits.are_found();
}

std::vector<double> corrected(std::vector<double> numbers, CheckSize size,
                              int decimals = kDecimals) {
  for (double& number : numbers) number = checked(number, decimals, size, Corrector::mirror);
  return numbers;
}

TEST(CheckDigits, ANumberMovesByLessThanOneOfTheDecimalsThatAreLeft) {
  for (const double value : values(1000)) {
    EXPECT_NEAR(checked(value, kDecimals, CheckSize::digits, Corrector::mirror), value, 1e-4);
    EXPECT_NEAR(checked_if_rounded(value, 3, CheckSize::half, Corrector::mirror), value, 1.2e-3);
    EXPECT_NEAR(checked_if_rounded(value, 3, CheckSize::quarter, Corrector::mirror), value,
                kMostMovedIfRounded * 1e-3);
  }
  EXPECT_NEAR(checked(0, kDecimals, CheckSize::digits, Corrector::mirror), 0, 1e-4);
  EXPECT_EQ(checked(1e12, kDecimals, CheckSize::digits, Corrector::mirror), 1e12);
}

TEST(CheckDigits, FourNumbersAreEnough) {
  EXPECT_TRUE(found(corrected(values(4), CheckSize::digits), CheckSize::digits));
  EXPECT_FALSE(found(corrected(values(3), CheckSize::digits), CheckSize::digits));
}

// 4^-12 and 2^-24 are the first below 1e-7; a tenth of the numbers ends with 0.
TEST(CheckDigits, ThoseOfRoundedNumbersAreFoundWhateverStandsBehindThem) {
  for (const auto& [size, fewest] :
       {std::pair(CheckSize::quarter, 12), std::pair(CheckSize::half, 24)}) {
    std::vector<double> numbers = values(100, 3), some;
    for (double& number : numbers) {
      number = checked_if_rounded(number, 3, size, Corrector::mirror);
      number = checked(number, kDecimals, CheckSize::digits, Corrector::mirror);
    }
    EXPECT_TRUE(found(numbers, CheckSize::digits));
    const auto shows = [&](int count) {
      some.clear();
      for (size_t k = 0; std::ssize(some) < count; ++k)
        if (std::fmod(std::round(std::abs(numbers[k]) * 1000), 10) != 0) some.push_back(numbers[k]);
      for (const int decimals : {3, 4, 5, 6}) {
        CheckDigits digits(size, Corrector::mirror);
        for (const double number : some) digits.add_rounded(rounded(number, decimals), 3);
        if (!digits.are_found()) return false;
      }
      return true;
    };
    EXPECT_TRUE(shows(fewest));
    EXPECT_FALSE(shows(fewest - 1));
  }
}

TEST(CheckDigits, ThoseOfAnotherCorrectorAreNotFound) {
  EXPECT_FALSE(found(corrected(values(1000), CheckSize::digits), CheckSize::digits, kDecimals,
                     Corrector::compensate));
}

TEST(CheckDigits, AreFoundInAnotherUnitAndAmongOtherNumbers) {
  std::vector<double> numbers = values(100, 2);
  for (const double number : corrected(values(20), CheckSize::digits))
    numbers.push_back(number / 1000 * 1000.0);
  EXPECT_TRUE(found(numbers, CheckSize::digits));
}

// Neither of any numbers, nor of evenly spaced ones, nor of one that is repeated.
TEST(CheckDigits, AreNotFoundWhereNothingIsCorrected) {
  for (unsigned seed = 1; seed < 300; ++seed) {
    std::vector<double> numbers = values(200, seed);
    EXPECT_FALSE(found(numbers, CheckSize::digits)) << seed;
    for (double& number : numbers) number = rounded(number, kDecimals);
    EXPECT_FALSE(found(numbers, CheckSize::digits)) << seed;
    for (double& number : numbers) number = rounded(number, 3);
    EXPECT_FALSE(found(numbers, CheckSize::digits)) << seed;
    EXPECT_FALSE(found(numbers, CheckSize::quarter, 3)) << seed;
    EXPECT_FALSE(found(numbers, CheckSize::half, 3)) << seed;
    std::vector<double> evenly;
    for (int k = 0; k < 300; ++k) evenly.push_back(numbers[0] + k * std::round(numbers[1]) / 100);
    EXPECT_FALSE(found(evenly, CheckSize::quarter, 3)) << seed;
    EXPECT_FALSE(found(evenly, CheckSize::half, 3)) << seed;
    for (double& number : evenly) number /= 1000;
    EXPECT_FALSE(found(evenly, CheckSize::digits)) << seed;
  }
  const double one = checked(123.456, kDecimals, CheckSize::digits, Corrector::mirror);
  EXPECT_FALSE(found(std::vector<double>(1000, one), CheckSize::digits));
}

}  // namespace
}  // namespace armtrue::check_digits_test
