#include "search/ebic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace armtrue::ebic_test {
namespace {

// m ln(1 / (1 - gain / before)) - k ln m - 2 ln(choices), with numbers that a pocket calculator
// checks: m = 100, half of the squares explained, 20 candidates.
TEST(EbicFall, OfOneColumnIsWhatTheHandComputes) {
  // 100 * 0.693147 = 69.3147; ln 100 = 4.60517; 2 ln 20 = 5.99146.
  EXPECT_NEAR(ebic_fall(false, std::log(20.0), 1, 5, 10, 100), 58.7181, 1e-4);
}

TEST(EbicFall, ChargesEveryColumnOfACurve) {
  // 100 ln(1 / 0.9) = 10.53605; 8 * 4.60517 = 36.84136.
  EXPECT_NEAR(ebic_fall(false, 0, 8, 1, 10, 100), -26.3053, 1e-4);
}

TEST(EbicFall, ChargesAGroupByEmpiricalBayes) {
  // Chance makes a fall of -100 ln(0.94) = 6.187540 for 6, so fall = 69.3147 * 6 / 6.187540 =
  // 67.21383; 6 (1 + ln(67.21383 / 6)) = 6 (1 + 2.416119) = 20.49672 < 6 * 4.60517 = 27.63.
  EXPECT_NEAR(ebic_fall(true, 0, 6, 5, 10, 100), 67.21383 - 20.49672, 1e-4);
  // A small fall is charged whole: 100 ln(1 / 0.95) = 5.129 < 6.
  EXPECT_NEAR(ebic_fall(true, 1.5, 6, 0.5, 10, 100), -3, 1e-12);
  // A very large one pays no more than BIC: 100 ln(1e8) = 1842.068, 6 ln 100 = 27.63102.
  EXPECT_NEAR(ebic_fall(true, 0, 6, 10 - 1e-7, 10, 100), 1786.2362 - 27.6310, 1e-3);
}

// Half of what the geometry leaves of noise: 60 coefficients explain half of 120 equations by
// chance, 120 ln 2 = 83.18, no evidence of anything.
TEST(EbicFall, OfALargeGroupIsNothingByChance) {
  EXPECT_NEAR(ebic_fall(true, 0, 60, 5, 10, 120), 0, 1e-9);
  EXPECT_EQ(ebic_fall(true, 0, 91, 9, 10, 120), -std::numeric_limits<double>::infinity());
}

TEST(EbicFall, IsLowestWithoutAColumnAndFiniteWhereNothingIsLeft) {
  EXPECT_EQ(ebic_fall(true, 0, 0, 5, 10, 100), -std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isfinite(ebic_fall(false, 0, 1, 10, 10, 100)));
}

}  // namespace
}  // namespace armtrue::ebic_test
