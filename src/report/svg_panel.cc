#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/svg.h"
#include "report/svg_layout.h"

namespace armtrue {

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
  for (size_t k = 0; k < heights.size(); ++k) {
    if (heights[k] <= 0) continue;
    const double left = px(low + width * static_cast<double>(k));
    body_ += fmt::format(
        "<rect class=\"bar {}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"><title>{}</title>"
        "</rect>\n",
        class_of(look), coordinate_text(left + 0.5), coordinate_text(py(heights[k])),
        coordinate_text(px(x_.low + width) - 1), coordinate_text(height_ - py(heights[k])),
        escaped(texts[k]));
  }
}

void Panel::line(const Points& points, Look look, const std::string& name) {
  picture_->legend("line", look, name);
  std::string path;
  for (const Eigen::Vector2d& point : points) path += (path.empty() ? "M" : "L") + at(point);
  if (!path.empty())
    body_ += fmt::format("<path class=\"line {}\" d=\"{}\"/>\n", class_of(look), path);
}

void Panel::band(const Points& low, const Points& high, Look look, const std::string& name) {
  picture_->legend("band", look, name);
  std::string path;
  for (const Eigen::Vector2d& point : low) path += (path.empty() ? "M" : "L") + at(point);
  for (size_t k = high.size(); k-- > 0;) path += "L" + at(high[k]);
  if (!path.empty())
    body_ += fmt::format("<path class=\"band {}\" d=\"{}z\"/>\n", class_of(look), path);
}

void Panel::points(const Points& points, Look look, const std::string& name) {
  picture_->legend("point", look, name);
  std::string path;
  for (const Eigen::Vector2d& point : points)
    path += mark_path(class_of(look), px(point.x()), py(point.y()));
  if (!path.empty())
    body_ += fmt::format("<path class=\"point {}\" d=\"{}\"/>\n", class_of(look), path);
}

void Panel::dots(const Points& points) {
  std::string path;
  for (const Eigen::Vector2d& point : points) path += "M" + at(point) + "h0";
  body_ += fmt::format("<path class=\"dot\" d=\"{}\"/>\n", path);
}

void Panel::vectors(const Points& from, const Points& to, Look look, const std::string& name) {
  picture_->legend("vector", look, name);
  constexpr double kHead = 6, kHalfHead = 2.6, kShortest = 1;
  std::string shafts, heads;
  for (size_t k = 0; k < from.size(); ++k) {
    const Eigen::Vector2d a(px(from[k].x()), py(from[k].y())), b(px(to[k].x()), py(to[k].y()));
    const double length = (b - a).norm();
    if (length < kShortest) continue;
    const Eigen::Vector2d along = (b - a) / length, across(-along.y(), along.x());
    const Eigen::Vector2d neck = b - std::min(kHead, 0.7 * length) * along;
    shafts += "M" + coordinate_text(a.x()) + " " + coordinate_text(a.y()) + "L" +
              coordinate_text(neck.x()) + " " + coordinate_text(neck.y());
    heads += "M" + coordinate_text(b.x()) + " " + coordinate_text(b.y());
    for (double side : {kHalfHead, -kHalfHead}) {
      const Eigen::Vector2d corner = neck + std::min(side * side, length) / side * across;
      heads += "L" + coordinate_text(corner.x()) + " " + coordinate_text(corner.y());
    }
    heads += "z";
  }
  if (!shafts.empty())
    body_ +=
        fmt::format("<path class=\"shaft {0}\" d=\"{1}\"/><path class=\"head {0}\" d=\"{2}\"/>\n",
                    class_of(look), shafts, heads);
}

void Panel::range(double x, double low, double middle, double high, Look look,
                  const std::string& name) {
  picture_->legend("point", look, name);
  const double left = px(x);
  body_ +=
      fmt::format("<path class=\"line {}\" d=\"M{} {}h10m-5 0V{}m-5 0h10\"/>\n", class_of(look),
                  coordinate_text(left - 5), coordinate_text(py(low)), coordinate_text(py(high)));
  body_ += fmt::format("<path class=\"point {0} large\" d=\"{1}\"/>\n", class_of(look),
                       mark_path(class_of(look), left, py(middle)));
}

void Panel::cells(const Points& centres, const std::vector<int>& classes, double width,
                  double height) {
  const double w = px(x_.low + width), h = height_ - py(y_.low + height);
  for (int of = 0; of < kHeatClasses; ++of) {
    // The side shows the class where colours do not.
    const double share = 0.45 + 0.5 * of / (kHeatClasses - 1);
    std::string path;
    for (size_t k = 0; k < centres.size(); ++k)
      if (classes[k] == of)
        path += fmt::format(
            "M{} {}h{}v{}h-{}z", coordinate_text(px(centres[k].x()) - 0.5 * share * w),
            coordinate_text(py(centres[k].y()) - 0.5 * share * h), coordinate_text(share * w),
            coordinate_text(share * h), coordinate_text(share * w));
    if (!path.empty()) body_ += fmt::format("<path class=\"h{}\" d=\"{}\"/>\n", of, path);
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

std::string Panel::frame(bool is_last) const {
  std::string grid, texts;
  const std::string width = coordinate_text(Picture::panel_width());
  const double first = std::ceil(y_.low / y_.step - 1e-9);
  for (double k = first; has_y_ticks_ && k * y_.step <= y_.high + 1e-9 * y_.step; ++k) {
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
