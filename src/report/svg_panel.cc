#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/units.h"
#include "report/svg.h"
#include "report/svg_layout.h"

namespace armtrue {
namespace {

// The text of the i-th mark, as a <title> in its element.
std::string title_of(const std::vector<std::string>& texts, size_t i) {
  return texts.empty() ? "" : "<title>" + escaped(texts[i]) + "</title>";
}

// The first view of a space: the direction in which one looks, from a corner above.
constexpr double kViewTurn = 35, kViewTilt = 28;  // deg: about the vertical, and downwards

std::string place_text(const Eigen::Vector3d& place) {
  return fmt::format("{:.3f} {:.3f} {:.3f}", place.x(), place.y(), place.z());
}

}  // namespace

Panel::Panel(Picture& picture, Axis x, Axis y, int height)
    : picture_(&picture), x_(std::move(x)), y_(std::move(y)), height_(height) {}

double Panel::px(double x) const { return (x - x_.low) / x_.length() * Picture::panel_width(); }

double Panel::py(double y) const { return height_ * (1 - (y - y_.low) / y_.length()); }

std::string Panel::at(const Eigen::Vector2d& point) const {
  return coordinate_text(px(point.x())) + " " + coordinate_text(py(point.y()));
}

void Panel::bars(double low, double width, const std::vector<double>& heights,
                 const std::vector<std::string>& texts, Look look, const std::string& name) {
  picture_->legend("bar", look, name);
  for (int k = 0; k < std::ssize(heights); ++k) {
    if (heights[k] <= 0) continue;
    const double left = px(low + width * k);
    body_ += fmt::format(
        "<rect class=\"bar {}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"><title>{}</title>"
        "</rect>\n",
        class_of(look), coordinate_text(left + 0.5), coordinate_text(py(heights[k])),
        coordinate_text(px(x_.low + width) - 1), coordinate_text(height_ - py(heights[k])),
        escaped(texts[k]));
  }
}

void Panel::line(const Points& points, Look look, const std::string& name,
                 const std::vector<std::string>& texts) {
  picture_->legend("line", look, name);
  std::string path;
  for (const Eigen::Vector2d& point : points) path += (path.empty() ? "M" : "L") + at(point);
  if (!path.empty())
    body_ += fmt::format("<path class=\"line {}\" d=\"{}\"/>\n", class_of(look), path);
  for (size_t k = 0; k < texts.size(); ++k)
    body_ += fmt::format("<path class=\"hover\" d=\"M{}h0\">{}</path>\n", at(points[k]),
                         title_of(texts, k));
}

void Panel::band(const Points& low, const Points& high, Look look, const std::string& name) {
  picture_->legend("band", look, name);
  std::string path;
  for (const Eigen::Vector2d& point : low) path += (path.empty() ? "M" : "L") + at(point);
  for (size_t k = high.size(); k-- > 0;) path += "L" + at(high[k]);
  if (!path.empty())
    body_ += fmt::format("<path class=\"band {}\" d=\"{}z\"/>\n", class_of(look), path);
}

void Panel::points(const Points& points, Look look, const std::string& name,
                   const std::vector<std::string>& texts) {
  picture_->legend("point", look, name);
  std::string path;
  for (size_t k = 0; k < points.size(); ++k) {
    path += mark_path(class_of(look), px(points[k].x()), py(points[k].y()));
    if (texts.empty() && k + 1 < points.size()) continue;
    body_ += fmt::format("<path class=\"point {}\" d=\"{}\">{}</path>\n", class_of(look), path,
                         title_of(texts, k));
    path.clear();
  }
}

void Panel::dots(const Points& points) {
  std::string path;
  for (const Eigen::Vector2d& point : points) path += "M" + at(point) + "h0";
  body_ += fmt::format("<path class=\"dot\" d=\"{}\"/>\n", path);
}

void Panel::vectors(const Points& from, const Points& to, Look look, const std::string& name,
                    const std::vector<std::string>& texts) {
  picture_->legend("vector", look, name);
  constexpr double kHead = 6, kHalfHead = 2.6, kShortest = 1;
  std::string shaft, heads;
  const auto add_shaft = [&](const std::string& title) {
    if (!shaft.empty())
      body_ += fmt::format("<path class=\"shaft {}\" d=\"{}\">{}</path>\n", class_of(look), shaft,
                           title);
    shaft.clear();
  };
  for (size_t k = 0; k < from.size(); ++k) {
    const Eigen::Vector2d a(px(from[k].x()), py(from[k].y())), b(px(to[k].x()), py(to[k].y()));
    const double length = (b - a).norm();
    if (length < kShortest) continue;
    const Eigen::Vector2d along = (b - a) / length, across(-along.y(), along.x());
    const Eigen::Vector2d neck = b - std::min(kHead, 0.7 * length) * along;
    shaft += "M" + coordinate_text(a.x()) + " " + coordinate_text(a.y()) + "L" +
             coordinate_text(neck.x()) + " " + coordinate_text(neck.y());
    heads += "M" + coordinate_text(b.x()) + " " + coordinate_text(b.y());
    for (double side : {kHalfHead, -kHalfHead}) {
      const Eigen::Vector2d corner = neck + std::min(side * side, length) / side * across;
      heads += "L" + coordinate_text(corner.x()) + " " + coordinate_text(corner.y());
    }
    heads += "z";
    if (!texts.empty()) add_shaft(title_of(texts, k));
  }
  add_shaft("");
  if (!heads.empty())
    body_ += fmt::format("<path class=\"head {}\" d=\"{}\"/>\n", class_of(look), heads);
}

void Panel::range(double x, double low, double middle, double high, Look look,
                  const std::string& name, const std::string& text) {
  picture_->legend("point", look, name);
  const double left = px(x);
  body_ +=
      fmt::format("<path class=\"line {}\" d=\"M{} {}h10m-5 0V{}m-5 0h10\"/>\n", class_of(look),
                  coordinate_text(left - 5), coordinate_text(py(low)), coordinate_text(py(high)));
  body_ += fmt::format("<path class=\"point {0} large\" d=\"{1}\">{2}</path>\n", class_of(look),
                       mark_path(class_of(look), left, py(middle)), title_of({text}, 0));
}

void Panel::cells(const Points& centres, const std::vector<int>& classes, double width,
                  double height, const std::vector<std::string>& texts) {
  const double w = px(x_.low + width), h = height_ - py(y_.low + height);
  for (size_t k = 0; k < centres.size(); ++k) {
    // The side shows the class where colours do not.
    const double share = 0.45 + 0.5 * classes[k] / (kHeatClasses - 1);
    body_ += fmt::format("<path class=\"h{}\" d=\"M{} {}h{}v{}h-{}z\">{}</path>\n", classes[k],
                         coordinate_text(px(centres[k].x()) - 0.5 * share * w),
                         coordinate_text(py(centres[k].y()) - 0.5 * share * h),
                         coordinate_text(share * w), coordinate_text(share * h),
                         coordinate_text(share * w), title_of(texts, k));
  }
}

void Panel::rule_x(double x, Look look, const std::string& name) {
  picture_->legend("rule", look, name);
  body_ += fmt::format("<path class=\"rule {}\" d=\"M{} 0v{}\"/>\n", class_of(look),
                       coordinate_text(px(x)), height_);
}

void Panel::rule_y(double y, Look look, const std::string& name) {
  picture_->legend("rule", look, name);
  body_ += fmt::format("<path class=\"rule {}\" d=\"M0 {}h{}\"/>\n", class_of(look),
                       coordinate_text(py(y)), coordinate_text(Picture::panel_width()));
}

void Panel::text(double x, double y, const std::string& text, const char* anchor) {
  body_ += fmt::format("<text class=\"halo\" x=\"{}\" y=\"{}\" text-anchor=\"{}\">{}</text>\n",
                       coordinate_text(px(x)), coordinate_text(py(y)), anchor, escaped(text));
}

void Panel::corner(const std::string& text) {
  body_ += fmt::format("<text class=\"halo\" x=\"{}\" y=\"14\" text-anchor=\"end\">{}</text>\n",
                       coordinate_text(Picture::panel_width() - 4), escaped(text));
}

double Panel::ball_radius() const {
  constexpr double kMargin = 12;  // for labels
  return 0.5 * std::min<double>(height_, Picture::panel_width()) - kMargin;
}

// Turned about the vertical, then tilted, as the script of a page does it further.
Eigen::Vector2d Panel::projected(const Eigen::Vector3d& place) const {
  const double turn = kViewTurn * kDegree, tilt = kViewTilt * kDegree;
  const double right = std::cos(turn) * place.x() - std::sin(turn) * place.y();
  const double away = std::sin(turn) * place.x() + std::cos(turn) * place.y();
  const double up = std::cos(tilt) * place.z() + std::sin(tilt) * away;
  return {0.5 * Picture::panel_width() + ball_radius() * right, 0.5 * height_ - ball_radius() * up};
}

void Panel::segments(const Places& from, const Places& to, std::optional<Look> look,
                     const std::string& name, const std::vector<std::string>& texts) {
  if (look) picture_->legend("line", *look, name);
  const std::string of = look ? std::string("line ") + class_of(*look) : "grid";
  for (size_t k = 0; k < from.size(); ++k) {
    const Eigen::Vector2d a = projected(from[k]), b = projected(to[k]);
    body_ += fmt::format("<path class=\"{}\" data-place=\"{} {}\" d=\"M{} {}L{} {}\">{}</path>\n",
                         of, place_text(from[k]), place_text(to[k]), coordinate_text(a.x()),
                         coordinate_text(a.y()), coordinate_text(b.x()), coordinate_text(b.y()),
                         title_of(texts, k));
  }
}

void Panel::dots(const Places& places) {
  for (const Eigen::Vector3d& place : places) {
    const Eigen::Vector2d at = projected(place);
    body_ += fmt::format("<path class=\"dot\" data-place=\"{}\" d=\"M{} {}h0\"/>\n",
                         place_text(place), coordinate_text(at.x()), coordinate_text(at.y()));
  }
}

void Panel::label(const Eigen::Vector3d& place, const std::string& text) {
  const Eigen::Vector2d at = projected(place);
  body_ += fmt::format(
      "<text class=\"halo\" data-place=\"{}\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
      place_text(place), coordinate_text(at.x()), coordinate_text(at.y()), escaped(text));
}

std::string Panel::frame(bool is_last) const {
  if (is_space_)
    return fmt::format(
        "<path class=\"turned\" data-turn=\"{} {}\" data-ball=\"{} {} {}\" d=\"M0 "
        "0h{}v{}h-{}z\"/>\n",
        kViewTurn, kViewTilt, coordinate_text(0.5 * Picture::panel_width()),
        coordinate_text(0.5 * height_), coordinate_text(ball_radius()),
        coordinate_text(Picture::panel_width()), height_, coordinate_text(Picture::panel_width()));
  std::string grid, texts;
  const std::string width = coordinate_text(Picture::panel_width());
  const double first = std::ceil(y_.low / y_.step - 1e-9);
  for (double k = first; k * y_.step <= y_.high + 1e-9 * y_.step; ++k) {
    const double y = py(k * y_.step);
    grid += "M0 " + coordinate_text(y) + "h" + width;
    texts += fmt::format("<text class=\"tick\" x=\"-6\" y=\"{}\" text-anchor=\"end\">{}</text>\n",
                         coordinate_text(y + 4.5), tick_text(k * y_.step, y_.step));
  }
  const double first_x = std::ceil(x_.low / x_.step - 1e-9);
  if (picture_->words_.empty())
    for (double k = first_x; k * x_.step <= x_.high + 1e-9 * x_.step; ++k)
      grid += fmt::format("M{} 0v{}", coordinate_text(px(k * x_.step)), height_);
  return fmt::format("<path class=\"grid\" d=\"{}\"/>\n<path class=\"axis\" d=\"M0 0V{}{}\"/>\n{}",
                     grid, height_, is_last ? "h" + width : std::string(), texts);
}

}  // namespace armtrue
