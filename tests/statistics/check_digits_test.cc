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
    EXPECT_NEAR(checked(value, 3, CheckSize::bit, Corrector::mirror), value, 1.51e-3);
  }
  EXPECT_NEAR(checked(0, kDecimals, CheckSize::digits, Corrector::mirror), 0, 1e-4);
  EXPECT_EQ(checked(1e12, kDecimals, CheckSize::digits, Corrector::mirror), 1e12);
}

TEST(CheckDigits, FivePositionsAreEnoughAndBitsNeedThirty) {
  EXPECT_TRUE(found(corrected(values(5), CheckSize::digits), CheckSize::digits));
  EXPECT_FALSE(found(corrected(values(4), CheckSize::digits), CheckSize::digits));
  EXPECT_TRUE(found(corrected(values(30), CheckSize::bit, 3), CheckSize::bit, 3));
  EXPECT_FALSE(found(corrected(values(29), CheckSize::bit, 3), CheckSize::bit, 3));
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
    EXPECT_FALSE(found(numbers, CheckSize::bit, 3)) << seed;
    std::vector<double> evenly;
    for (int k = 0; k < 300; ++k) evenly.push_back(numbers[0] + k * std::round(numbers[1]) / 100);
    EXPECT_FALSE(found(evenly, CheckSize::bit, 3)) << seed;
    for (double& number : evenly) number /= 1000;
    EXPECT_FALSE(found(evenly, CheckSize::digits)) << seed;
  }
  const double one = checked(123.456, kDecimals, CheckSize::digits, Corrector::mirror);
  EXPECT_FALSE(found(std::vector<double>(1000, one), CheckSize::digits));
}

}  // namespace
}  // namespace armtrue::check_digits_test
