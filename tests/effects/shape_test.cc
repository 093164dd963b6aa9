#include "armtrue/effects/shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "armtrue/effects/driver.h"

namespace armtrue::shape_test {
namespace {

std::vector<double> values(const Shape& shape, double x) {
  std::vector<double> out(static_cast<size_t>(value_count(shape)));
  evaluate(shape, x, out.data());
  return out;
}

TEST(Shape, NamesReadBack) {
  for (const char* text : {"linear", "harmonic 1", "harmonic 47", "harmonic 50.5", "sign", "step",
                           "kink", "exponential", "pre-sliding", "series"})
    EXPECT_EQ(to_string(parse_shape(text).value()), text);
  for (const char* text : {"", "harmonic", "harmonic 0", "harmonic x", "harmonic -3",
                           "harmonic inf", "harmonic nan", "linear 2", "cubic"})
    EXPECT_FALSE(parse_shape(text)) << text;
}

TEST(Driver, NamesReadBack) {
  for (const char* text : {"joint-angle 4",
                           "joint-angle 2,4",
                           "joint-angle 3,1",
                           "gravity-torque 6",
                           "arrival 1",
                           "time",
                           "temperature air",
                           "payload",
                           "force",
                           "moment",
                           "position",
                           "joint-angle 3 * payload",
                           "joint-angle 3 * arrival 2",
                           "stroke 3",
                           "tool-weight 2",
                           "range",
                           "azimuth",
                           "elevation",
                           "incidence",
                           "time * tool-weight 2",
                           "time * gravity-torque 3",
                           "gravity-torque 2 * temperature air",
                           "force * time"})
    EXPECT_EQ(to_string(parse_driver(text).value()), text);
  for (const char* text :
       {"", "joint-angle", "joint-angle 17", "arrival 1,2", "time 3", "temperature", "time * time",
        "time * joint-angle 1", "joint-angle 1,2 * time", "payload * tool-weight 2", "range 1",
        "stroke", "time * payload * time", " * time"})
    EXPECT_FALSE(parse_driver(text)) << text;
}

TEST(Shape, StepAndExponentialFollowTheirInnerValues) {
  const Shape step = step_shape(5);
  EXPECT_EQ(values(step, 4.999)[0], 0);
  EXPECT_EQ(values(step, 5)[0], 1);
  const Shape growth = exponential_shape(2);
  EXPECT_DOUBLE_EQ(values(growth, 2)[0], 1 - std::exp(-1));
}

TEST(Shape, KinkBeginsAndPreSlidingTurnsRound) {
  const Shape kink = kink_shape(0.5);
  EXPECT_EQ(values(kink, 0.4)[0], 0);
  EXPECT_DOUBLE_EQ(values(kink, 0.75)[0], 0.25);
  const Shape sliding = pre_sliding_shape(0.1);
  EXPECT_EQ(values(sliding, 0)[0], 0);
  EXPECT_NEAR(values(sliding, 1e-12)[0], -1, 1e-10);  // still where the last way has left it
  EXPECT_NEAR(values(sliding, 0.1 * std::log(2))[0], 0, 1e-15);
  EXPECT_NEAR(values(sliding, 10)[0], 1, 1e-15);
  EXPECT_NEAR(values(sliding, -10)[0], -1, 1e-15);
}

// Together with the one left out, splines sum to 1 and are never negative: check by the clamped
// end, where only the missing one is left.
TEST(Shape, SplinesAreAClampedBasis) {
  const Shape spline = series_shape(SeriesBasis::spline, 8, -2, 3);
  EXPECT_DOUBLE_EQ(values(spline, -2)[0], 1);
  double at_end = 0;
  for (double v : values(spline, 3)) at_end += std::abs(v);
  EXPECT_NEAR(at_end, 0, 1e-15);
  double previous = 1;
  for (double x = -2; x <= 3; x += 0.01) {
    double sum = 0;
    for (double v : values(spline, x)) {
      EXPECT_GE(v, 0);
      sum += v;
    }
    EXPECT_LE(sum, 1 + 1e-12);
    EXPECT_NEAR(sum, previous, 0.05) << "jump at " << x;  // continuous
    previous = sum;
  }
  EXPECT_EQ(values(spline, -9), values(spline, -2));  // clamped outside the range
}

TEST(Shape, ProductSeriesHoldsEveryProduct) {
  const Shape shape = series_shape(SeriesBasis::fourier, 1);
  double out[4];
  ASSERT_EQ(value_count(shape, true), 4);
  evaluate_product(shape, 0.3, 1.1, out);
  EXPECT_DOUBLE_EQ(out[0], std::sin(0.3) * std::sin(1.1));
  EXPECT_DOUBLE_EQ(out[1], std::sin(0.3) * std::cos(1.1));
  EXPECT_DOUBLE_EQ(out[2], std::cos(0.3) * std::sin(1.1));
  EXPECT_DOUBLE_EQ(out[3], std::cos(0.3) * std::cos(1.1));
}

// Each factor over its own range.
TEST(Shape, ProductSeriesHasARangeOfEachDriver) {
  const Shape shape = series_shape(SeriesBasis::cosine, 1, {-2, 1, 0}, {2, 5, 0});
  double out = 0;
  evaluate_product(shape, 1, 2, &out);  // at 3/4 and at 1/4
  EXPECT_NEAR(out, std::cos(0.75 * M_PI) * std::cos(0.25 * M_PI), 1e-15);
}

// The range is that of two standard deviations.
TEST(Shape, ABumpHasItsWidth) {
  const Shape bump = series_shape(SeriesBasis::bump, 1, -1, 3);
  for (const double x : {-1.0, 0.5, 1.0, 3.0, 6.0})
    EXPECT_NEAR(values(bump, x)[0], std::exp(-(x - 1) * (x - 1) / (2 * 2 * 2)), 1e-15) << x;
}

// Degree 2 and 3 in full, nothing of degree 0 and 1, and the last value beyond the range.
TEST(Shape, PolynomialHoldsEveryProductOfItsDegrees) {
  const Shape shape = series_shape(SeriesBasis::polynomial, 3, {1, -2, 0}, {3, 2, 1});
  ASSERT_EQ(value_count(shape), 16);
  double out[16];
  evaluate_polynomial(shape, {2.5, 1, 0.75}, out);  // u = 0.5 on all axes
  EXPECT_EQ(std::count_if(out, out + 16, [](double v) { return v == 0.25; }), 6);
  EXPECT_EQ(std::count_if(out, out + 16, [](double v) { return v == 0.125; }), 10);
  evaluate_polynomial(shape, {2.5, 0, 0.5}, out);  // u = 0.5, 0, 0: only powers of the first
  EXPECT_EQ(std::count_if(out, out + 16, [](double v) { return v != 0; }), 2);
  double beyond[16];
  evaluate_polynomial(shape, {9, -7, 5}, beyond);
  evaluate_polynomial(shape, {3, -2, 1}, out);
  EXPECT_TRUE(std::equal(out, out + 16, beyond));
}

}  // namespace
}  // namespace armtrue::shape_test
