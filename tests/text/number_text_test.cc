#include "armtrue/text/number_text.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <cstdlib>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"

namespace armtrue::number_text_test {
namespace {

TEST(NumberText, IsTheShortestThatReadsBack) {
  EXPECT_EQ(number_text(0.1), "0.1");
  EXPECT_EQ(number_text(-0.0), "0");
  EXPECT_EQ(number_text(1.0 / 3), "0.3333333333333333");
  EXPECT_EQ(number_text(90 * kDegree, kDegree), "90");
  EXPECT_EQ(number_text(-424.2775 * kMillimetre, kMillimetre), "-424.2775");
}

TEST(NumberText, WholeNumbersAreThoseOfAnInt) {
  EXPECT_EQ(read_whole_number("+7"), 7);
  EXPECT_EQ(read_whole_number("-2147483647"), -2147483647);
  for (const char* text : {"", "7.5", "7a", "2147483648", "1e99", "inf", "nan"})
    EXPECT_FALSE(read_whole_number(text)) << text;
}

TEST(NumberText, CountsWithTheRightFormOfTheNoun) {
  EXPECT_EQ(counted(1, "row"), "1 row");
  EXPECT_EQ(counted(0, "row"), "0 rows");
  EXPECT_EQ(counted(2, "joint value"), "2 joint values");
  EXPECT_EQ(counted(2, "body"), "2 bodies");
  EXPECT_EQ(counted(3, "key"), "3 keys");
  EXPECT_EQ(counted(2, "pass"), "2 passes");
  EXPECT_EQ(counted(1, "pass"), "1 pass");
}

// 3.5875 and 1.0005 are a little less than that as doubles, 0.125 is not.
TEST(NumberText, RoundsAFiveAwayFromZero) {
  EXPECT_EQ(fixed_text(3.5875, 3), "3.588");
  EXPECT_EQ(fixed_text(-3.5875, 3), "-3.588");
  EXPECT_EQ(fixed_text(0.125, 2), "0.13");
  EXPECT_EQ(fixed_text(0.135, 2), "0.14");
  EXPECT_EQ(fixed_text(3.58749, 3), "3.587");
  EXPECT_EQ(rounded(3.5875), "3.588");
  EXPECT_EQ(rounded(10005), "1.001e+04");
}

TEST(NumberText, HasTheDecimalsOfItsUncertainty) {
  EXPECT_EQ(as_known(0.30004, 0.08122), "0.300");
  EXPECT_EQ(as_known(0.30004, 0.0997), "0.30");  // 0.10
  EXPECT_EQ(as_known(0.30004, 0.00994), "0.3000");
  EXPECT_EQ(as_known(12.34, 1.26), "12.3");
  EXPECT_EQ(as_known(1234.6, 126), "1235");
  EXPECT_EQ(as_known(-0.0004, 0.08), "0.000");
  EXPECT_EQ(as_known(0.30004, 0), "0.3");
  EXPECT_EQ(decimals_of_figure(0.30004, 20), 1);
  EXPECT_EQ(decimals_of_figure(0.30004, 0.08122), 3);
  EXPECT_EQ(decimals_of_figure(0, 20), 0);
  EXPECT_THROW(as_known(NAN, 0.1), InputError);
}

RC_GTEST_PROP(NumberText, AnyNumberReadsBack, (double value)) {
  RC_PRE(std::isfinite(value));
  RC_ASSERT(std::strtod(number_text(value).c_str(), nullptr) == value);
}

// What stood in a file comes back as it stood there.
RC_GTEST_PROP(NumberText, FileValuesSurviveTheirUnit, (int thousandths)) {
  const double in_file = thousandths / 1000.0;
  for (double unit : {kMillimetre, kDegree})
    RC_ASSERT(std::strtod(number_text(in_file * unit, unit).c_str(), nullptr) * unit ==
              in_file * unit);
}

}  // namespace
}  // namespace armtrue::number_text_test
