#include "report/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "report/svg_layout.h"

namespace armtrue {
namespace {

constexpr double kKeyWidth = 26;  // of the sample before a name in a legend
constexpr double kTitleHeight = 24;
constexpr double kTextGap = 7;  // between text and the uppermost tick

double round_step(double length, int most) {
  const double least = length / most;
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  for (double factor : {1.0, 2.0, 5.0})
    if (factor * decade >= least * (1 - 1e-9)) return factor * decade;
  return 10 * decade;
}

std::string text_svg(double x, double y, const char* anchor, const std::string& text,
                     const char* type = "") {
  return fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"{}\"{}>{}</text>\n", coordinate_text(x),
                     coordinate_text(y), anchor, type, escaped(text));
}

// Breaks a title at a space, where it is longer than a line.
std::vector<std::string> title_lines(const std::string& title) {
  constexpr size_t kLetters = 50;
  if (title.size() <= kLetters) return {title};
  const size_t space = title.rfind(' ', kLetters);
  if (space == std::string::npos) return {title};
  return {title.substr(0, space), title.substr(space + 1)};
}

// A sample of a look, about (x, y), for a legend.
std::string sample_svg(const std::string& kind, const char* look, double x, double y) {
  const std::string at = coordinate_text(y);
  if (kind == "bar" || kind == "band")
    return fmt::format("<rect class=\"{} {}\" x=\"{}\" y=\"{}\" width=\"18\" height=\"10\"/>\n",
                       kind, look, coordinate_text(x), coordinate_text(y - 5));
  if (kind == "point")
    return fmt::format("<path class=\"{} {}\" d=\"{}\"/>\n", kind, look, mark_path(look, x + 9, y));
  if (kind == "vector")
    return fmt::format(
        "<path class=\"line {0}\" d=\"M{1} {2}h14\"/><path class=\"head {0}\" d=\"M{3} {2}l-7 "
        "-3.5v7z\"/>\n",
        look, coordinate_text(x), at, coordinate_text(x + 19));
  return fmt::format("<path class=\"{} {}\" d=\"M{} {}h18\"/>\n", kind, look, coordinate_text(x),
                     at);
}

}  // namespace

std::string coordinate_text(double value) {
  std::string text = fmt::format("{:.1f}", value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text == "-0" ? "0" : text;
}

const char* class_of(Look look) {
  switch (look) {
    case Look::nominal:
      return "nominal";
    case Look::before:
      return "before";
    case Look::after:
      return "after";
    case Look::mark:
      break;
  }
  return "mark";
}

std::string mark_path(const std::string& look, double x, double y) {
  const std::string cx = coordinate_text(x), cy = coordinate_text(y);
  if (look == "nominal")
    return fmt::format("M{} {}l6 6m0 -6l-6 6", coordinate_text(x - 3), coordinate_text(y - 3));
  if (look == "before")
    return fmt::format("M{} {}a3 3 0 1 0 6 0a3 3 0 1 0 -6 0", coordinate_text(x - 3), cy);
  if (look == "after") return fmt::format("M{} {}h0", cx, cy);
  return fmt::format("M{} {}l4 7h-8z", cx, coordinate_text(y - 4));
}

Axis exact_axis(double low, double high, const std::string& label, int most) {
  constexpr double kLeastHalf = 1e-3;  // of an axis of errors that are all 0 or all the same
  if (low == 0 && high == 0) high = kLeastHalf;
  if (!(high > low)) {
    const double half = std::max(kLeastHalf, 0.05 * std::abs(low));
    low -= half;
    high += half;
  }
  return {low, high, round_step(high - low, most), label};
}

Axis round_axis(double low, double high, const std::string& label, int most) {
  Axis axis = exact_axis(low, high, label, most);
  axis.low = axis.step * std::floor(axis.low / axis.step + 1e-9);
  axis.high = axis.step * std::ceil(axis.high / axis.step - 1e-9);
  return axis;
}

Axis count_axis(double high, const std::string& label, int most) {
  Axis axis = round_axis(0, std::max(1.0, high), label, most);
  axis.step = std::max(1.0, axis.step);
  return axis;
}

std::string tick_text(double value, double step) {
  if (std::abs(value) < 1e-9 * step) value = 0;
  if (step >= 1e4 || step < 1e-4) return fmt::format("{:g}", value);
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  return fmt::format("{:.{}f}", value, decimals);
}

std::vector<int> evenly(Eigen::Index rows, Eigen::Index most) {
  const Eigen::Index count = std::min(rows, most);
  std::vector<int> kept(count);
  std::iota(kept.begin(), kept.end(), 0);
  if (rows > most)
    for (int& k : kept) k = static_cast<int>(k * (rows - 1) / std::max<Eigen::Index>(1, count - 1));
  return kept;
}

std::vector<Eigen::Index> peaks_kept(const Eigen::VectorXd& values, Eigen::Index most) {
  const Eigen::Index n = values.size(), stretches = most / 2;
  const std::vector<int> all = evenly(n, most);
  if (n <= most) return {all.begin(), all.end()};
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < stretches; ++k) {
    const Eigen::Index begin = k * n / stretches, end = (k + 1) * n / stretches;
    Eigen::Index least = 0, largest = 0;
    values.segment(begin, end - begin).minCoeff(&least);
    values.segment(begin, end - begin).maxCoeff(&largest);
    kept.push_back(begin + std::min(least, largest));
    if (least != largest) kept.push_back(begin + std::max(least, largest));
  }
  return kept;
}

MapAxes map_axes(Eigen::Vector2d low, Eigen::Vector2d high, const std::string& x_label,
                 const std::string& y_label, double most_height) {
  constexpr double kLeastHeight = 150, kLeastSide = 1e-3;
  const double width = Picture::panel_width();
  Eigen::Vector2d size = (high - low).cwiseMax(kLeastSide);
  const double height = std::clamp(width * size.y() / size.x(), kLeastHeight, most_height);
  const double scale = std::max(size.x() / width, size.y() / height);
  const Eigen::Vector2d middle = 0.5 * (low + high);
  const Eigen::Vector2d half = 0.5 * scale * Eigen::Vector2d(width, height);
  return {exact_axis(middle.x() - half.x(), middle.x() + half.x(), x_label, 5),
          exact_axis(middle.y() - half.y(), middle.y() + half.y(), y_label, 5),
          static_cast<int>(height)};
}

Picture::Picture(std::string name, std::string title, std::string description, Axis x)
    : name_(std::move(name)),
      title_(std::move(title)),
      description_(std::move(description)),
      x_(std::move(x)) {}

double Picture::panel_width() { return kPictureWidth - kLeft - kRight; }

Panel& Picture::panel(const Axis& y, int height) {
  panels_.push_back(Panel(*this, x_, y, height));
  return panels_.back();
}

Panel& Picture::space(int height) {
  Panel& panel = this->panel({}, height);
  panel.is_space_ = true;
  return panel;
}

void Picture::heat_legend(double low, double high, const std::string& unit) {
  heat_ = {fmt::format("{:.3g} {}", low, unit), fmt::format("{:.3g} {}", high, unit)};
}

void Picture::legend(const std::string& kind, Look look, const std::string& name) {
  const auto same = [&](const Entry& entry) { return entry.name == name; };
  if (!name.empty() && std::ranges::none_of(entries_, same)) entries_.push_back({kind, look, name});
}

std::string Picture::legend_svg(double& top) const {
  std::string svg;
  double x = 2;
  for (const Entry& entry : entries_) {
    const double width = kKeyWidth + width_of(entry.name);
    if (x > 2 && x + width > kPictureWidth) {
      x = 2;
      top += kRowHeight;
    }
    svg += sample_svg(entry.kind, class_of(entry.look), x, top + 9);
    svg += text_svg(x + kKeyWidth - 2, top + 13.5, "start", entry.name);
    x += width + 8;
  }
  if (!entries_.empty()) top += kRowHeight;
  if (heat_[0].empty()) return svg;
  const double left = 10 + width_of(heat_[0]);
  svg += text_svg(2, top + 13.5, "start", heat_[0]);
  for (int k = 0; k < kHeatClasses; ++k)
    svg += fmt::format("<rect class=\"h{}\" x=\"{}\" y=\"{}\" width=\"17\" height=\"12\"/>\n", k,
                       coordinate_text(left + 18 * k), coordinate_text(top + 3));
  svg += text_svg(left + 18 * kHeatClasses + 6, top + 13.5, "start", heat_[1]);
  top += kRowHeight;
  return svg;
}

std::string Picture::x_axis(double top) const {
  if (panels_.back().is_space_) return "";
  const double scale = panel_width() / x_.length();
  std::string svg;
  for (const auto& [x, word] : words_)
    svg += text_svg(kLeft + (x - x_.low) * scale, top + 15, "middle", word);
  const double first = std::ceil(x_.low / x_.step - 1e-9);
  for (double k = first; words_.empty() && k * x_.step <= x_.high + 1e-9 * x_.step; ++k) {
    const std::string text = tick_text(k * x_.step, x_.step);
    const double x = kLeft + (k * x_.step - x_.low) * scale;
    const bool is_cut = x + 0.5 * width_of(text) > kPictureWidth;
    svg += text_svg(is_cut ? kPictureWidth : x, top + 15, is_cut ? "end" : "middle", text,
                    " class=\"tick\"");
  }
  if (!x_.label.empty())
    svg += text_svg(kPictureWidth - kRight, top + 32, "end", x_.label, " class=\"quiet\"");
  return svg;
}

Picture::Content Picture::content() const {
  std::string svg =
      "<title>" + escaped(title_) + "</title><desc>" + escaped(description_) + "</desc>\n";
  double top = 0;
  for (const std::string& line : title_lines(title_)) {
    svg += text_svg(2, top + 16, "start", line, " class=\"title\"");
    top += kTitleHeight - 4;
  }
  top += 4;
  svg += legend_svg(top);
  if (panels_.empty() || panels_.front().y_.label.empty()) top += kTextGap;
  for (size_t k = 0; k < panels_.size(); ++k) {
    const Panel& panel = panels_[k];
    if (!panel.y_.label.empty()) {
      svg += text_svg(2, top + 13, "start", panel.y_.label, " class=\"quiet\"");
      top += kRowHeight + kTextGap;
    }
    svg += fmt::format("<g transform=\"translate({} {})\">\n{}{}</g>\n", coordinate_text(kLeft),
                       coordinate_text(top), panel.frame(k + 1 == panels_.size()), panel.body_);
    top += panel.height_ + (k + 1 < panels_.size() ? kPanelGap : 0);
  }
  svg += x_axis(top);
  top += x_.label.empty() ? 22 : 38;
  return {top, svg};
}

std::string Picture::svg() const {
  const Content inner = content();
  return fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" class=\"picture\">{}</svg>\n",
                     kPictureWidth, coordinate_text(inner.height), inner.svg);
}

std::string stand_alone(const std::vector<Drawing>& pictures) {
  constexpr double kBetween = 24;
  double top = 0, row_height = 0;
  std::string svg;
  for (size_t k = 0; k < pictures.size(); ++k) {
    const Picture::Content inner = pictures[k]->content();
    const bool is_left = k % 2 == 0;
    if (is_left && k > 0) top += row_height + kBetween;
    row_height = is_left ? inner.height : std::max(row_height, inner.height);
    svg += fmt::format(
        "<svg class=\"picture\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\">{}</svg>\n",
        is_left ? 0 : kPictureWidth + kBetween, coordinate_text(top), kPictureWidth,
        coordinate_text(inner.height), inner.svg);
  }
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" data-by=\"armtrue\" role=\"img\" "
             "viewBox=\"-8 -8 {} {}\">",
             (pictures.size() > 1 ? 2 * kPictureWidth + kBetween : kPictureWidth) + 16,
             coordinate_text(top + row_height + 16)) +
         "<style>" + picture_style() + "svg{background:var(--paper)}</style>\n" + svg + "</svg>\n";
}

}  // namespace armtrue
