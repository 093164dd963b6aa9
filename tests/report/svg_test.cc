#include "report/svg.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <regex>

namespace armtrue::svg_test {
namespace {

using testing::HasSubstr;
using testing::Not;

int steps_of(const Axis& axis) { return static_cast<int>(std::lround(axis.length() / axis.step)); }

TEST(Axis, HoldsBothEndsInFewRoundSteps) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-6, 6), mantissa(-1, 1);
  for (int trial = 0; trial < 10000; ++trial) {
    const double a = mantissa(random) * std::pow(10, exponent(random));
    const double b = mantissa(random) * std::pow(10, exponent(random));
    const Axis axis = round_axis(std::min(a, b), std::max(a, b), "", 6);
    EXPECT_LE(axis.low, std::min(a, b) + 1e-6 * axis.step);
    EXPECT_GE(axis.high, std::max(a, b) - 1e-6 * axis.step);
    EXPECT_LE(steps_of(axis), 8);  // six, and the parts of one at both ends
    const double digit = axis.step / std::pow(10, std::floor(std::log10(axis.step) + 1e-9));
    EXPECT_TRUE(std::abs(digit - 1) < 1e-6 || std::abs(digit - 2) < 1e-6 ||
                std::abs(digit - 5) < 1e-6)
        << axis.step;
  }
}

TEST(Axis, OfNothingStillHasALength) {
  EXPECT_EQ(round_axis(0, 0, "").low, 0);
  EXPECT_GT(round_axis(0, 0, "").high, 0);
  EXPECT_GT(exact_axis(7, 7, "").length(), 0);
  EXPECT_EQ(count_axis(3, "").step, 1);
}

TEST(Axis, TicksHaveNoMoreDigitsThanTheirStep) {
  EXPECT_EQ(tick_text(0.1 + 0.2, 0.1), "0.3");
  EXPECT_EQ(tick_text(-1e-18, 0.5), "0.0");
  EXPECT_EQ(tick_text(1500, 500), "1500");
  EXPECT_EQ(tick_text(-0.05, 0.05), "-0.05");
}

TEST(Thinning, KeepsEndsOrPeaks) {
  EXPECT_THAT(evenly(3, 10), testing::ElementsAre(0, 1, 2));
  const auto rows = evenly(1000, 7);
  EXPECT_EQ(rows.size(), 7u);
  EXPECT_EQ(rows.front(), 0);
  EXPECT_EQ(rows.back(), 999);
  Eigen::VectorXd values = Eigen::VectorXd::Zero(5000);
  values[1234] = 3;
  values[4321] = -2;
  const auto peaks = peaks_kept(values, 100);
  EXPECT_LE(peaks.size(), 100u);
  EXPECT_THAT(peaks, testing::Contains(1234));
  EXPECT_THAT(peaks, testing::Contains(4321));
  EXPECT_TRUE(std::ranges::is_sorted(peaks));
}

TEST(Map, HasEqualScalesAndHoldsItsCorners) {
  for (const double width : {1.0, 300.0, 4000.0})
    for (const double height : {0.0, 10.0, 3000.0}) {
      const MapAxes axes = map_axes({-width, 0}, {width, height}, "x", "y");
      EXPECT_LE(axes.x.low, -width + 1e-9);
      EXPECT_GE(axes.y.high, height - 1e-9);
      const double right = axes.x.length() / Picture::panel_width();
      EXPECT_NEAR(axes.y.length() / axes.height, right, 0.01 * right);
    }
}

TEST(Picture, DrawsWithinItsViewBox) {
  Picture picture("name", "Title", "Description", round_axis(0, 2500, "a long label, mm"));
  Panel& panel = picture.panel(round_axis(-0.001, 0.001, "error, mm"), 120);
  panel.line({{0, -0.001}, {2500, 0.001}}, Look::before, "one");
  panel.points({{0, 0}, {2500, 0}}, Look::after, "two");
  panel.range(1250, -0.001, 0, 0.001, Look::nominal, "three", "0 mm");
  const std::string svg = picture.svg();
  std::smatch box;
  ASSERT_TRUE(std::regex_search(svg, box, std::regex("viewBox=\"0 0 ([0-9.]+) ([0-9.]+)\"")));
  constexpr double kLetter = 7.9;
  const std::regex text(
      "<text[^>]* x=\"([-0-9.]+)\" y=\"([-0-9.]+)\" text-anchor=\"(\\w+)\"[^>]*>([^<]*)<");
  int texts = 0;
  for (std::sregex_iterator match(svg.begin(), svg.end(), text), end; match != end; ++match) {
    const std::string anchor = (*match)[3];
    const double x = std::stod((*match)[1]);
    if (x < 0) continue;  // of the vertical axis, beside its panel
    const double length = kLetter * static_cast<double>((*match)[4].length());
    const double right = anchor == "start" ? x + length : anchor == "middle" ? x + length / 2 : x;
    EXPECT_LE(right, std::stod(box[1]) + 1) << (*match)[4];
    EXPECT_LE(std::stod((*match)[2]), std::stod(box[2])) << (*match)[4];
    ++texts;
  }
  EXPECT_GE(texts, 9);
}

TEST(Picture, EscapesWhatItIsGiven) {
  auto picture = std::make_shared<Picture>("n", "<b>&\"", "a < b", round_axis(0, 1, "x<y"));
  picture->panel(round_axis(0, 1, "<i>"), 50).line({{0, 0}, {1, 1}}, Look::mark, "<u>");
  const std::string svg = stand_alone({picture});
  for (const char* raw : {"<b>", "<i>", "<u>", "a < b"}) EXPECT_THAT(svg, Not(HasSubstr(raw)));
  EXPECT_THAT(svg, HasSubstr("&lt;b&gt;&amp;&quot;"));
  EXPECT_THAT(svg, HasSubstr("prefers-color-scheme:dark"));
  EXPECT_THAT(svg, HasSubstr("xmlns=\"http://www.w3.org/2000/svg\""));
}

}  // namespace
}  // namespace armtrue::svg_test
