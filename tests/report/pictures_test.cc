// The numbers that pictures show, read back from their SVG through the ticks of their axes.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "report/curve_pictures.h"
#include "report/error_map_pictures.h"
#include "report/prediction_parts.h"
#include "report/residual_pictures.h"
#include "report/svg.h"
#include "report/svg_layout.h"

namespace armtrue::pictures_test {
namespace {

// Of each match the whole and its groups.
std::vector<std::vector<std::string>> all_of(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  std::vector<std::vector<std::string>> found;
  for (std::sregex_iterator match(text.begin(), text.end(), regex), end; match != end; ++match)
    found.emplace_back(match->begin(), match->end());
  return found;
}

// A straight line through the outermost of some ticks: value = offset + scale * coordinate.
struct Ruler {
  double scale = 0, offset = 0;

  static Ruler of(const std::vector<std::array<double, 2>>& ticks) {
    const auto [a, b] = std::pair(ticks.front(), ticks.back());
    const double scale = (b[1] - a[1]) / (b[0] - a[0]);
    return {scale, a[1] - scale * a[0]};
  }
  double at(double coordinate) const { return offset + scale * coordinate; }
};

Ruler horizontal(const std::string& svg) {
  std::vector<std::array<double, 2>> ticks;
  for (const auto& match : all_of(svg,
                                  "<text x=\"([-0-9.]+)\" y=\"[-0-9.]+\" text-anchor=\"middle\" "
                                  "class=\"tick\">([-0-9.e+]+)<"))
    ticks.push_back({std::stod(match[1]) - kLeft, std::stod(match[2])});
  return Ruler::of(ticks);
}

std::vector<std::string> panels(const std::string& svg) {
  std::vector<std::string> texts;
  for (size_t at = svg.find("<g transform"); at != std::string::npos;
       at = svg.find("<g transform", at + 1))
    texts.push_back(svg.substr(at, svg.find("</g>", at) - at));
  return texts;
}

Ruler vertical(const std::string& panel) {
  constexpr double kBaseline = 4.5;  // of a tick's text below its line
  std::vector<std::array<double, 2>> ticks;
  for (const auto& match : all_of(panel,
                                  "<text class=\"tick\" x=\"-6\" y=\"([-0-9.]+)\" "
                                  "text-anchor=\"end\">([-0-9.e+]+)<"))
    ticks.push_back({std::stod(match[1]) - kBaseline, std::stod(match[2])});
  EXPECT_LT(Ruler::of(ticks).scale, 0);  // larger values stand higher
  return Ruler::of(ticks);
}

// Beginnings of the parts of the path with a class.
Points starts(const std::string& panel, const std::string& css_class) {
  Points points;
  for (const auto& path : all_of(panel, "class=\"" + css_class + "\" d=\"([^\"]*)\""))
    for (const auto& match : all_of(path[1], "M([-0-9.]+) ([-0-9.]+)"))
      points.emplace_back(std::stod(match[1]), std::stod(match[2]));
  return points;
}

// ---- colours ----

std::map<std::string, std::array<double, 3>> colours(const std::string& css) {
  std::map<std::string, std::array<double, 3>> found;
  for (const auto& match : all_of(css, "--([a-z0-9]+):#([0-9a-f]{3,6})")) {
    std::string digits = match[2];
    if (digits.size() == 3)
      digits = {digits[0], digits[0], digits[1], digits[1], digits[2], digits[2]};
    for (size_t k = 0; k < 3; ++k)
      found[match[1]][k] = std::stoi(digits.substr(2 * k, 2), nullptr, 16) / 255.0;
  }
  return found;
}

std::array<std::map<std::string, std::array<double, 3>>, 2> light_and_dark() {
  const std::string& css = picture_style();
  const size_t dark = css.find("@media");
  return {colours(css.substr(0, dark)), colours(css.substr(dark, css.find(".picture") - dark))};
}

// WCAG 2.2, relative luminance and contrast ratio.
double luminance(const std::array<double, 3>& colour) {
  const auto linear = [](double c) {
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(colour[0]) + 0.7152 * linear(colour[1]) + 0.0722 * linear(colour[2]);
}

double contrast(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  const double of_a = luminance(a), of_b = luminance(b);
  return (std::max(of_a, of_b) + 0.05) / (std::min(of_a, of_b) + 0.05);
}

TEST(Palette, BeforeIsOrangeAndAfterIsBlue) {
  for (const auto& palette : light_and_dark()) {
    EXPECT_GT(palette.at("before")[0], palette.at("before")[2] + 0.3);
    EXPECT_GT(palette.at("after")[2], palette.at("after")[0] + 0.3);
    EXPECT_GT(palette.at("good")[1], palette.at("good")[0] + 0.3);
    EXPECT_GT(palette.at("bad")[0], palette.at("bad")[1] + 0.2);
  }
  for (const char* kind : {".line", ".shaft", ".rule", ".point"})
    for (const char* look : {"nominal", "before", "after"})
      EXPECT_TRUE(std::regex_search(
          picture_style(), std::regex(std::string("\\") + kind + "\\." + look +
                                      "[^{}]*\\{stroke:#[0-9a-f]+;stroke:var\\(--" + look + "\\)")))
          << kind << look;
}

// librsvg and other programs know no variables: before each stands the property with the light
// colour.
TEST(Palette, EachColourIsSaidWithoutAVariableToo) {
  const auto light = colours(picture_style().substr(0, picture_style().find("@media")));
  const auto uses = all_of(picture_style(), "([a-z]+):var\\(--([a-z0-9]+)\\)");
  const auto both = all_of(picture_style(), "([a-z]+):(#[0-9a-f]{3,6});\\1:var\\(--([a-z0-9]+)\\)");
  ASSERT_GT(uses.size(), 20u);
  ASSERT_EQ(both.size(), uses.size());
  for (const auto& use : both)
    EXPECT_EQ(colours("--x:" + use[2]).at("x"), light.at(use[3])) << use[0];
}

TEST(Palette, TextAndLinesStandOutFromThePaper) {
  for (const auto& palette : light_and_dark())
    for (const char* ground : {"paper", "card"}) {
      for (const char* text : {"ink", "quiet", "good", "warn", "bad"})
        EXPECT_GE(contrast(palette.at(text), palette.at(ground)), 4.5) << text << " on " << ground;
      for (const char* line : {"nominal", "before", "after"})
        EXPECT_GE(contrast(palette.at(line), palette.at(ground)), 3) << line << " on " << ground;
    }
}

TEST(Palette, ClassesOfAMapLeaveThePaperStepByStep) {
  for (const auto& palette : light_and_dark())
    for (int k = 0; k + 1 < kHeatClasses; ++k)
      EXPECT_GT(contrast(palette.at("h" + std::to_string(k + 1)), palette.at("paper")),
                1.1 * contrast(palette.at("h" + std::to_string(k)), palette.at("paper")));
}

TEST(HeatLegend, GoesFromTheLowestValueToTheHighest) {
  Picture picture("n", "t", "d", round_axis(0, 1, "x"));
  picture.heat_legend(0.25, 1.5, "mm");
  picture.panel(round_axis(0, 1, "y"), 60);
  const std::string svg = picture.svg();
  std::vector<double> places;
  for (int k = 0; k < kHeatClasses; ++k) {
    const auto match = all_of(svg, "<rect class=\"h" + std::to_string(k) + "\" x=\"([0-9.]+)\"");
    ASSERT_EQ(match.size(), 1u);
    places.push_back(std::stod(match.front()[1]));
  }
  EXPECT_TRUE(std::ranges::is_sorted(places));
  const auto texts = all_of(svg, "<text x=\"([0-9.]+)\"[^>]*>(0.25 mm|1.5 mm)<");
  ASSERT_EQ(texts.size(), 2u);
  EXPECT_EQ(texts[0][2], "0.25 mm");
  EXPECT_LT(std::stod(texts[0][1]), places.front());
  EXPECT_EQ(texts[1][2], "1.5 mm");
  EXPECT_GT(std::stod(texts[1][1]), places.back());
}

// ---- errors of readings ----

// Points in a row, of poses P0, P1 ...
Campaign campaign_of(int rows) {
  Campaign campaign;
  for (int row = 0; row < rows; ++row) {
    campaign.pose.push_back(row);
    campaign.line.push_back(row + 2);
    campaign.q.push_back(JointVector::Zero(6));
    campaign.position.emplace_back(1, 2, 3);
    campaign.pose_ids.push_back("P" + std::to_string(row));
  }
  return campaign;
}

// What a pointer is told, in the order of the marks.
std::vector<std::string> tips(const std::string& panel) {
  std::vector<std::string> texts;
  for (const auto& match : all_of(panel, "<title>([^<]*)</title>")) texts.push_back(match[1]);
  return texts;
}

// Residuals of 0.1, 0.2 ... mm along x; the model after errs by a tenth of that.
Evaluation errors(int rows, double unit) {
  Evaluation evaluation;
  for (int row = 0; row < rows; ++row) {
    Eigen::Matrix<double, 6, 1> residual = Eigen::Matrix<double, 6, 1>::Zero();
    residual[0] = unit * (row + 1) * (row % 2 == 0 ? 1 : -1);
    evaluation.residuals.push_back(residual);
    evaluation.position.push_back(std::abs(residual[0]));
  }
  return evaluation;
}

std::vector<Judged> models(int rows) {
  return {{"nominal", Look::before, errors(rows, 1e-4)},
          {"found", Look::after, errors(rows, 1e-5)}};
}

TEST(Histogram, CountsEachReadingInItsBin) {
  const std::vector<Judged> judged = {{"nominal", Look::before, errors(25, 1.03e-4)},
                                      {"found", Look::after, errors(25, 1.03e-5)}};
  const std::string svg = histogram_picture(judged, "readings")->svg();
  const auto rows = panels(svg);
  ASSERT_EQ(rows.size(), 2u);
  for (size_t m = 0; m < 2; ++m) {
    double readings = 0;
    for (const auto& bar : all_of(rows[m], "<title>([0-9.e-]+) to ([0-9.e-]+) mm: ([0-9]+)<")) {
      const double low = std::stod(bar[1]), high = std::stod(bar[2]), count = std::stod(bar[3]);
      readings += count;
      EXPECT_EQ(count, std::ranges::count_if(judged[m].evaluation.position,
                                             [&](double error) {
                                               return error * 1e3 >= low * (1 - 1e-9) &&
                                                      error * 1e3 < high * (1 - 1e-9);
                                             }))
          << low;
    }
    EXPECT_EQ(readings, 25);
  }
  // The rule of the mean: 0.103 mm x 13.
  EXPECT_NEAR(horizontal(svg).at(starts(rows[0], "rule mark").front().x()), 1.339, 0.02);
  EXPECT_NEAR(horizontal(svg).at(starts(rows[1], "rule mark").front().x()), 0.134, 0.02);
}

TEST(Campaign, EachReadingStandsAtItsErrorInMillimetres) {
  std::vector<bool> left_out(12, false);
  left_out[4] = true;
  const std::string svg = campaign_picture(models(12), campaign_of(12), left_out)->svg();
  const std::string panel = panels(svg).front();
  const Ruler x = horizontal(svg), y = vertical(panel);
  const Points before = starts(panel, "point before"), after = starts(panel, "point after");
  ASSERT_EQ(before.size(), 12u);
  ASSERT_EQ(after.size(), 12u);
  for (size_t k = 0; k < 12; ++k) {
    EXPECT_NEAR(x.at(after[k].x()), static_cast<double>(k + 1), 0.03);
    EXPECT_NEAR(y.at(before[k].y()), 0.1 * static_cast<double>(k + 1), 0.01);
    EXPECT_NEAR(y.at(after[k].y()), 0.01 * static_cast<double>(k + 1), 0.01);
  }
  ASSERT_EQ(starts(panel, "point mark").size(), 1u);
  EXPECT_NEAR(x.at(starts(panel, "point mark").front().x()), 5, 0.05);
  ASSERT_EQ(tips(panel).size(), 24u);  // the mark of a reading left out is the third at its place
  EXPECT_NE(svg.find("Worst, found: pose P11 (0.12 mm), pose P10 (0.11 mm), pose P9 (0.1 mm), "
                     "pose P8 (0.09 mm), pose P7 (0.08 mm)."),
            std::string::npos);
  EXPECT_EQ(tips(panel)[2], "pose P2: 0.3 mm, nominal");
  EXPECT_EQ(tips(panel)[12 + 6], "pose P6: 0.07 mm, found");
  EXPECT_NE(svg.find("left out of the fit"), std::string::npos);
}

TEST(Axes, ShowSmallestMeanAndLargestOfEachAxis) {
  const Campaign campaign = campaign_of(8);
  std::vector<Judged> judged = {{"nominal", Look::before, errors(8, 1e-4)}};
  for (size_t row = 0; row < 8; ++row)
    judged[0].evaluation.residuals[row].head<3>() << (row == 0 ? -8e-4 : 1e-4), 2e-4, 3e-4;
  const std::string svg = axes_picture(judged, campaign)->svg();
  const std::string panel = panels(svg).front();
  const Ruler y = vertical(panel);
  const auto ranges =
      all_of(panel, "class=\"line before\" d=\"M[-0-9.]+ ([-0-9.]+)h10m-5 0V([-0-9.]+)");
  ASSERT_EQ(ranges.size(), 3u);
  EXPECT_NEAR(y.at(std::stod(ranges[0][1])), -0.8, 0.01);
  EXPECT_NEAR(y.at(std::stod(ranges[0][2])), 0.1, 0.01);
  EXPECT_NEAR(y.at(std::stod(ranges[1][1])), 0.2, 0.01);
  EXPECT_NEAR(y.at(std::stod(ranges[2][2])), 0.3, 0.01);
  const Points means = starts(panel, "point before large");
  ASSERT_EQ(means.size(), 3u);
  EXPECT_NEAR(y.at(means[0].y()), (-0.8 + 7 * 0.1) / 8, 0.01);
  EXPECT_NEAR(y.at(means[2].y()), 0.3, 0.01);
}

TEST(Field, ArrowsHaveTheLengthThatTheTextSays) {
  const std::vector<Eigen::Vector3d> places{{0, 0, 0}, {1, 0, 0.5}, {1, 1, 1}};
  const std::vector<Eigen::Vector3d> vectors{{2e-4, 0, 0}, {0, 1e-3, 0}, {0, 0, -5e-4}};
  const auto pictures = field_maps(places, {{"errors", Look::before, vectors}},
                                   {"map", "Errors", "the frame", "Here."});
  ASSERT_EQ(pictures.size(), 4u);  // the fourth in three dimensions
  const std::string description = pictures[0]->description();
  std::smatch words;
  ASSERT_TRUE(std::regex_search(
      description, words,
      std::regex("are ([0-9.e+]+) times as long[^;]*; the longest is ([0-9.]+) mm")));
  EXPECT_EQ(std::stod(words[2]), 1);
  const double factor = std::stod(words[1]);
  const std::string svg = pictures[0]->svg();  // from above: x to the right, y up
  const Ruler x = horizontal(svg), y = vertical(panels(svg).front());
  const auto heads = starts(panels(svg).front(), "head before");
  ASSERT_EQ(heads.size(), 2u);  // the third points down
  EXPECT_NEAR(x.at(heads[0].x()), factor * 0.2, 15);
  EXPECT_NEAR(x.at(heads[1].x()), 1000, 15);
  EXPECT_NEAR(y.at(heads[1].y()), factor * 1.0, 15);
}

// Names of the pictures of a field whose vertical is `up`, with what they are seen from.
std::vector<std::pair<std::string, std::string>> views_of(const Eigen::Vector3d& up) {
  const std::vector<Eigen::Vector3d> places{{0, 0, 0}, {1, 0, 0.5}, {1, 1, 1}};
  std::vector<std::pair<std::string, std::string>> views;
  for (const Drawing& picture :
       field_maps(places, {{"errors", Look::before, places}},
                  {.file = "map", .title = "Errors", .frame = "F", .note = "", .up = up}))
    views.emplace_back(picture->name(), picture->title());
  return views;
}

TEST(Field, IsSeenFromAboveAlongTheVertical) {
  // From above, x and y of the picture and the vertical are right-handed.
  EXPECT_EQ(views_of({0, 0, 1})[0],
            std::pair(std::string("map-xy"), std::string("Errors, from above")));
  EXPECT_EQ(views_of({0, 0, -1})[0].first, "map-yx");
  EXPECT_EQ(views_of({0, 1, 0})[0],
            std::pair(std::string("map-zx"), std::string("Errors, from above")));
  EXPECT_EQ(views_of({0, 1, 0})[1],
            std::pair(std::string("map-zy"), std::string("Errors, from the side")));
  EXPECT_EQ(views_of({-1, 0, 0.1})[0].first, "map-zy");
  EXPECT_EQ(views_of({1, 0, 1})[0].second, "Errors, along z");
}

// The parts of a space: class, both ends within the ball, and both ends as drawn.
struct Segment {
  std::string css;
  std::array<Eigen::Vector3d, 2> ends;
  std::array<Eigen::Vector2d, 2> drawn;
};

std::vector<Segment> segments(const std::string& panel) {
  std::vector<Segment> found;
  for (const auto& path :
       all_of(panel,
              "class=\"([a-z ]+)\" data-place=\"([-0-9. ]+)\" d=\"M([-0-9. ]+)L([-0-9. ]+)\"")) {
    Segment& segment = found.emplace_back();
    segment.css = path[1];
    std::istringstream ends(path[2]);
    for (Eigen::Vector3d& end : segment.ends) ends >> end.x() >> end.y() >> end.z();
    for (size_t k = 0; k < 2; ++k) {
      std::istringstream drawn(path[3 + k]);
      drawn >> segment.drawn[k].x() >> segment.drawn[k].y();
    }
  }
  return found;
}

TEST(Space, HoldsPlacesAndVectorsWithTheVerticalUpwards) {
  const std::vector<Eigen::Vector3d> places{{2, 0, 1}, {3, 0, 1.5}, {3, 1, 2}};
  const std::vector<Eigen::Vector3d> vectors{{2e-4, 0, 0}, {0, 1e-3, 0}, {0, 0, -5e-4}};
  const Drawing picture = field_maps(places, {{"errors", Look::before, vectors}},
                                     {.file = "map",
                                      .title = "Errors",
                                      .frame = "F",
                                      .note = "",
                                      .names = {"P0", "P1", "P2"},
                                      .up = Eigen::Vector3d::UnitX()})
                              .back();
  const std::string panel = panels(picture->svg()).front();
  std::vector<Segment> of_field;
  for (const Segment& segment : segments(panel)) {
    for (const Eigen::Vector3d& end : segment.ends) EXPECT_LE(end.norm(), 1.0005);
    if (segment.css == "line before") of_field.push_back(segment);
  }
  ASSERT_EQ(of_field.size(), 3u);
  EXPECT_EQ(tips(panel), (std::vector<std::string>{"P0: 0.2 mm, errors", "P1: 1 mm, errors",
                                                   "P2: 0.5 mm, errors"}));
  // One turn and one scale take all of them into the ball; x becomes the vertical.
  const double scale =
      (of_field[2].ends[0] - of_field[0].ends[0]).norm() / (places[2] - places[0]).norm();
  EXPECT_NEAR(of_field[1].ends[0].z() - of_field[0].ends[0].z(), scale, 2e-3);
  EXPECT_NEAR((of_field[1].ends[0] - of_field[0].ends[0]).norm(), std::sqrt(1.25) * scale, 2e-3);
  const auto arrow = [&](size_t k) -> Eigen::Vector3d {
    return of_field[k].ends[1] - of_field[k].ends[0];
  };
  EXPECT_NEAR(arrow(1).norm() / arrow(0).norm(), 5, 0.1);
  EXPECT_GT(arrow(0).z(), 0);
  EXPECT_NEAR(arrow(1).z(), 0, 2e-3);
  // Seen from above a corner: what is higher stands higher, along the vertical lines are upright.
  const Segment& upright = of_field[0];
  EXPECT_NEAR(upright.drawn[0].x(), upright.drawn[1].x(), 0.11);
  EXPECT_LT(upright.drawn[1].y(), upright.drawn[0].y());
  // The ball keeps lengths: across the eye's direction none is longer than in space.
  for (const Segment& a : of_field)
    for (const Segment& b : of_field) {
      const double in_space = (a.ends[0] - b.ends[0]).norm();
      const double on_paper = (a.drawn[0] - b.drawn[0]).norm();
      EXPECT_LE(on_paper, in_space * 150 + 0.2);  // half the height of the panel
    }
}

TEST(JointCurve, ShowsCurveNamedPartAndBandOverItsAngle) {
  KinematicChain chain;
  chain.links.resize(2);
  chain.links[0].name = "A1";
  chain.links[1].name = "A2";
  JointCurve curve;
  curve.joint = 1;
  for (int k = 0; k <= 4; ++k) {
    curve.points.push_back({0.1 * k, 1e-4 * k, 5e-5});
    curve.named.push_back(5e-5 * k);
  }
  const std::string svg = joint_picture(curve, chain)->svg(), panel = panels(svg).front();
  const Ruler x = horizontal(svg), y = vertical(panel);
  EXPECT_NE(svg.find("A2.theta, mrad"), std::string::npos);
  constexpr double kMrad = 1e3;
  const auto points = [&](const std::string& css, size_t which) {
    const auto paths = all_of(panel, "class=\"" + css + "\" d=\"M([^\"]*)\"");
    Points read;
    for (const auto& match : all_of(paths.at(which)[1], "([-0-9.]+) ([-0-9.]+)"))
      read.emplace_back(x.at(std::stod(match[1])), y.at(std::stod(match[2])));
    return read;
  };
  const Points applied = points("line after", 0), named = points("line mark", 0),
               band = points("band after", 0);
  ASSERT_EQ(applied.size(), 5u);
  ASSERT_EQ(named.size(), 5u);
  ASSERT_EQ(band.size(), 10u);  // there below and back above
  for (size_t k = 0; k < 5; ++k) {
    const double angle = 0.1 * static_cast<double>(k), value = 1e-4 * static_cast<double>(k);
    EXPECT_NEAR(applied[k].x(), angle * 180 / M_PI, 0.05);
    EXPECT_NEAR(applied[k].y(), value * kMrad, 5e-6 * kMrad);
    EXPECT_NEAR(named[k].y(), 0.5 * value * kMrad, 5e-6 * kMrad);
    EXPECT_NEAR(band[k].y(), (value - 5e-5) * kMrad, 5e-6 * kMrad);
    EXPECT_NEAR(band[9 - k].y(), (value + 5e-5) * kMrad, 5e-6 * kMrad);
  }
  EXPECT_EQ(tips(panel).size(), 5u);
}

TEST(Rows, ShowBothErrorsAlongTheProgram) {
  const Eigen::Vector3d before(1, 2, 3), after(0.1, 0.2, 0.3);
  const std::string svg = rows_picture(before, after, {.after = "left"})->svg();
  const std::string panel = panels(svg).front();
  const Ruler y = vertical(panel);
  const Points first = starts(panel, "point before"), second = starts(panel, "point after");
  ASSERT_EQ(first.size(), 3u);
  ASSERT_EQ(second.size(), 3u);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(y.at(first[static_cast<size_t>(k)].y()), before[k], 0.03);
    EXPECT_NEAR(y.at(second[static_cast<size_t>(k)].y()), after[k], 0.03);
  }
}

// ---- maps ----

TEST(Map, StrongerClassesStandWhereTheErrorIsLarger) {
  ErrorMap map;
  Grid grid;
  grid.low = Eigen::Vector3d(0, 0, 0);
  grid.high = Eigen::Vector3d(1, 1, 0);
  grid.count = {5, 5, 1};
  for (int k = 0; k < grid.points(); ++k) {
    MapPoint point;
    point.position = grid.position(k);
    point.is_predicted = true;
    point.error = Eigen::Vector3d(1e-3 * point.position.x(), 0, 0);  // grows to the right, to 1 mm
    point.left_by_constants = 1e-4;
    map.points.push_back(point);
  }
  map.grid = grid;
  const auto pictures = error_map_pictures(map);
  ASSERT_EQ(pictures.size(), 2u);
  const std::string svg = pictures[0]->svg(), panel = panels(svg).front();
  const Ruler x = horizontal(svg);
  double last = -1;
  for (int k = 0; k < kHeatClasses; ++k)
    for (const Eigen::Vector2d& corner : starts(panel, "h" + std::to_string(k))) {
      EXPECT_GE(x.at(corner.x()), last - 150);  // squares grow, so their corners lie further left
      last = std::max(last, x.at(corner.x()));
    }
  EXPECT_EQ(starts(panel, "h0").size(), 5u);                                    // 0 mm
  EXPECT_EQ(starts(panel, "h" + std::to_string(kHeatClasses - 1)).size(), 5u);  // 1 mm
  EXPECT_NE(svg.find(">1 mm<"), std::string::npos);
  // What is left counts on a scale from 0 to the largest before or after.
  EXPECT_EQ(starts(panels(pictures[1]->svg()).front(), "h0").size(), 25u);
}

}  // namespace
}  // namespace armtrue::pictures_test
