#include "statistics/rounding.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace armtrue::rounding_test {
namespace {

std::vector<double> multiples(double step, int count) {
  std::vector<double> values;
  for (int k = 0; k < count; ++k) values.push_back((7 * k - 50) * step);
  return values;
}

TEST(Rounding, ValuesThatVaryShowAllDigits) {
  EXPECT_EQ(last_digits(multiples(1e-3, 100), 1e-3), 10);
  EXPECT_EQ(last_digits(multiples(1e-3, 3), 1e-3), 3);
}

TEST(Rounding, CoarserValuesShowOneDigit) { EXPECT_EQ(last_digits(multiples(1e-3, 100), 1e-4), 1); }

TEST(Rounding, FinerValuesAreNotRoundedSo) {
  EXPECT_EQ(last_digits(multiples(1e-4, 100), 1e-3), std::nullopt);
}

}  // namespace
}  // namespace armtrue::rounding_test
