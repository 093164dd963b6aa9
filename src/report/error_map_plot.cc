#include "armtrue/report/error_map_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>

#include "armtrue/kinematics/units.h"
#include "report/gnuplot.h"

namespace armtrue {
namespace {

constexpr int kSlices = 3;
constexpr int kCellsPerSide = 60;  // of a slice; of more points some are shown
constexpr int kArrowsPerSide = 9;  // of a slice
constexpr int kMapWidth = 1000, kMapHeight = 720;
constexpr size_t kRowsShown = 4000;   // of a program
constexpr double kBarShare = 0.09;    // of the width, for the scale of colours
constexpr double kLeastShare = 0.25;  // of the largest value, that the colours span
constexpr double kLeastSide = 1;      // [mm], of what is drawn
constexpr double kOverlap = 1.02;     // of cells, so that no seams show between them
// Light is accurate; arrows stand out everywhere, and the order survives a print without colours.
constexpr const char* kPalette =
    "set palette defined (0 '#ffffd9', 1 '#fed976', 2 '#fd8d3c', 3 '#e31a1c', 4 '#a50026')\n";
constexpr const char* kAxes = "xyz";

double mm(double metres) { return metres / kMillimetre; }

// Every place along a side, or as many as are shown, both ends included.
std::vector<int> some_places(int count, int most) {
  std::vector<int> places;
  const int shown = std::min(count, most);
  for (int k = 0; k < shown; ++k)
    places.push_back(shown == 1 ? (count - 1) / 2 : k * (count - 1) / (shown - 1));
  return places;
}

// One value of a point, [m]; nothing where there is no prediction.
using ValueOf = std::function<std::optional<double>(const MapPoint&)>;

std::optional<double> before(const MapPoint& point) {
  return point.is_predicted ? std::optional(point.error.norm()) : std::nullopt;
}

std::optional<double> left(const MapPoint& point) {
  if (!point.is_predicted) return std::nullopt;
  return point.after ? *point.after : point.left_by_constants;
}

// Limits of the colours: all of the values, and no small differences as if they were large [mm].
std::array<double, 2> limits(const ErrorMap& map, const ValueOf& value_of) {
  double low = std::numeric_limits<double>::infinity(), high = 1e-6;
  for (const MapPoint& point : map.points)
    if (const auto value = value_of(point)) {
      low = std::min(low, mm(*value));
      high = std::max(high, mm(*value));
    }
  return {std::min(low, (1 - kLeastShare) * high), high};
}

// A round distance between tics, so that a side has no more than `most`.
double tics(double side, int most) {
  const double least = std::max(side, kLeastSide) / most;
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  for (double factor : {1.0, 2.0, 5.0})
    if (factor * decade >= least) return factor * decade;
  return 10 * decade;
}

std::string left_title(const ErrorMap& map) {
  const bool is_known = std::ranges::any_of(
      map.points, [](const MapPoint& point) { return point.after.has_value(); });
  return is_known ? "left with constants and effects (RMS), mm"
                  : "left with the identified constants alone, mm";
}

class GridPlot {
 public:
  explicit GridPlot(const ErrorMap& map) : map_(map), grid_(*map.grid) {
    const auto fewest = std::ranges::min_element(grid_.count, [](int a, int b) { return a < b; });
    across_ = static_cast<int>(fewest - grid_.count.begin());
    if (*fewest == grid_.count[2]) across_ = 2;  // the plan is what is read most easily
    right_ = across_ == 0 ? 1 : 0;
    up_ = across_ == 2 ? 1 : 2;
    slices_ = some_places(count(across_), kSlices);
  }

  std::string script() {
    script_.precision(6);
    script_ << "set multiplot\nset xtics nomirror\nset ytics nomirror\nset tics out\n"
            << "set style rectangle fillstyle noborder\n"
            << kPalette << "set key off\n";
    find_longest();
    script_ << "set xtics " << tics(mm(grid_.high[right_] - grid_.low[right_]), 4) << "\nset ytics "
            << tics(mm(grid_.high[up_] - grid_.low[up_]), 6) << "\n";
    std::ostringstream above;
    above.precision(3);
    above << "predicted error as it is, mm (arrows: along " << kAxes[right_] << " and "
          << kAxes[up_] << ", the longest " << longest_ << " mm)";
    row(0.5, limits(map_, before), before, above.str(), true);
    row(0, {0, limits(map_, before)[1]}, left, left_title(map_), false);
    script_ << "unset multiplot\n";
    return script_.str();
  }

 private:
  int count(int axis) const { return grid_.count[static_cast<size_t>(axis)]; }

  const MapPoint& at(int slice, int right, int up) const {
    std::array<int, 3> place{};
    place[static_cast<size_t>(across_)] = slice;
    place[static_cast<size_t>(right_)] = right;
    place[static_cast<size_t>(up_)] = up;
    return map_.points[static_cast<size_t>(grid_.point(place))];
  }

  double step(int axis, int shown) const {
    const double side = mm(grid_.high[axis] - grid_.low[axis]);
    return shown > 1 ? side / (shown - 1) : std::max(side, kLeastSide);
  }

  // The longest arrow [mm of error], which is drawn as long as the distance between two.
  void find_longest() {
    for (const MapPoint& point : map_.points)
      longest_ = std::max(longest_, std::hypot(mm(point.error[right_]), mm(point.error[up_])));
    const double side =
        std::max(mm(grid_.high[right_] - grid_.low[right_]), mm(grid_.high[up_] - grid_.low[up_]));
    if (longest_ > 0) arrow_scale_ = side / kArrowsPerSide / longest_;
  }

  // A panel for each slice, with one scale of colours beside the last.
  void row(double bottom, const std::array<double, 2>& colours, const ValueOf& value_of,
           const std::string& title, bool with_arrows) {
    script_ << "set cbrange [" << colours[0] << ":" << colours[1] << "]\nset label 1 "
            << quoted(title) << " at screen 0.5, screen " << bottom + 0.475
            << " center font ',13'\n";
    const auto panels = static_cast<double>(slices_.size());
    for (size_t k = 0; k < slices_.size(); ++k) {
      const bool is_last = k + 1 == slices_.size();
      const double width = (1 - kBarShare) / panels;
      script_ << "set size " << width << ", 0.46\nset origin " << static_cast<double>(k) * width
              << ", " << bottom << "\nset tmargin 2\nset lmargin at screen "
              << static_cast<double>(k) * width + 0.085 << "\nset rmargin at screen "
              << (static_cast<double>(k) + 1) * width - 0.015 << "\n"
              << (is_last ? "set colorbox user origin screen " : "unset colorbox\n");
      if (is_last)
        script_ << 1 - kBarShare + 0.005 << ", screen " << bottom + 0.09
                << " size screen 0.018, screen 0.29\n";
      panel(slices_[k], value_of, with_arrows, k);
      script_ << "unset label\n";
    }
  }

  void panel(int slice, const ValueOf& value_of, bool with_arrows, size_t number) {
    const std::vector<int> right = some_places(count(right_), kCellsPerSide);
    const std::vector<int> up = some_places(count(up_), kCellsPerSide);
    const double half_right = 0.5 * step(right_, static_cast<int>(right.size()));
    const double half_up = 0.5 * step(up_, static_cast<int>(up.size()));
    const std::string data = (with_arrows ? "$b" : "$a") + std::to_string(number);
    script_ << data << " << END\n";
    for (int v : up)
      for (int u : right)
        if (const auto value = value_of(at(slice, u, v)))
          script_ << mm(grid_.coordinate(right_, u)) << " " << mm(grid_.coordinate(up_, v)) << " "
                  << mm(*value) << "\n";
    script_ << "NaN NaN NaN\nEND\n";
    if (with_arrows) arrows(slice, number);
    script_ << "set title '" << kAxes[across_] << " = " << mm(grid_.coordinate(across_, slice))
            << " mm'\nset xlabel '" << kAxes[right_] << ", mm'\nset ylabel '" << kAxes[up_]
            << ", mm' offset 1.5\n"
            << (number > 0 ? "unset ylabel\n" : "") << "set xrange ["
            << mm(grid_.low[right_]) - half_right << ":" << mm(grid_.high[right_]) + half_right
            << "]\nset yrange [" << mm(grid_.low[up_]) - half_up << ":"
            << mm(grid_.high[up_]) + half_up
            << "]\nset object 1 rectangle from graph 0,0 to graph 1,1 behind fc rgb '#dddddd'\n"
            << "plot " << data << " using 1:2:(" << kOverlap * half_right << "):("
            << kOverlap * half_up << "):3 with boxxyerror fs solid 1 noborder lc palette";
    if (with_arrows && arrow_scale_ > 0)
      script_ << ", $v" << number
              << " using 1:2:3:4 with vectors head size screen 0.006,20 filled lw 1.2 lc rgb "
                 "'#000000'";
    script_ << "\n";
  }

  void arrows(int slice, size_t number) {
    script_ << "$v" << number << " << END\n";
    for (int v : some_places(count(up_), kArrowsPerSide))
      for (int u : some_places(count(right_), kArrowsPerSide)) {
        const MapPoint& point = at(slice, u, v);
        if (!point.is_predicted) continue;
        script_ << mm(grid_.coordinate(right_, u)) << " " << mm(grid_.coordinate(up_, v)) << " "
                << arrow_scale_ * mm(point.error[right_]) << " "
                << arrow_scale_ * mm(point.error[up_]) << "\n";
      }
    script_ << "NaN NaN NaN NaN\nEND\n";
  }

  const ErrorMap& map_;
  const Grid& grid_;
  int across_ = 2, right_ = 0, up_ = 1;
  std::vector<int> slices_;
  double longest_ = 0, arrow_scale_ = 0;
  std::ostringstream script_;
};

// Ends of the points along an axis, with a margin [mm].
std::array<double, 2> ends_along(const ErrorMap& map, int axis) {
  const auto [low, high] = std::ranges::minmax_element(
      map.points, {}, [&](const MapPoint& point) { return point.position[axis]; });
  const double width = mm(high->position[axis] - low->position[axis]);
  const double margin = std::max(0.05 * width, 0.5 * kLeastSide);
  return {mm(low->position[axis]) - margin, mm(high->position[axis]) + margin};
}

std::string program_script(const ErrorMap& map) {
  std::ostringstream script;
  script.precision(8);
  script << "$d << END\n";
  const size_t step = (map.points.size() + kRowsShown - 1) / kRowsShown;
  for (size_t k = 0; k < map.points.size(); k += step) {
    const MapPoint& point = map.points[k];
    script << k + 1;
    for (double x : point.position) script << " " << mm(x);
    for (const auto& value : {before(point), left(point)})
      script << " " << (value ? mm(*value) : std::nan(""));
    script << "\n";
  }
  const auto [low, high] = limits(map, before);
  const double size = map.points.size() > 200 ? 0.4 : 1;
  script << "END\nset multiplot\n"
         << kPalette << "set key off\nset tics out nomirror\nset cbrange [" << low << ":" << high
         << "]\nset cblabel 'mm'\nset title 'predicted error as it is'\nset size 0.5,0.55\n";
  const auto side = [&](const char* name, int axis, int most) {
    const auto [from, to] = ends_along(map, axis);
    script << "set " << name << "range [" << from << ":" << to << "]\nset " << name << "tics "
           << tics(to - from, most) << "\nset " << name << "label '" << kAxes[axis] << ", mm'\n";
  };
  const auto view = [&](double origin, int up) {
    script << "set origin " << origin << ",0.45\n";
    side("x", 0, 4);
    side("y", up, 6);
    script << "plot $d using 2:" << up + 2 << ":5 with points pt 7 ps " << size << " lc palette\n";
  };
  view(0, 1);
  view(0.5, 2);
  script << "set size 1,0.45\nset origin 0,0\nset xtics autofreq\nset ytics autofreq\nset xrange "
            "[*:*]\nset key "
            "tmargin center horizontal\nset grid\n"
            "set xlabel 'row'\nset ylabel 'mm'\nset yrange [0:*]\n"
            "plot $d using 1:5 with points pt 7 ps "
         << size
         << " lc rgb '#d62728' title 'predicted error as it is, mm', "
            "$d using 1:6 with points pt 7 ps "
         << size << " lc rgb '#1f77b4' title " << quoted(left_title(map)) << "\nunset multiplot\n";
  return script.str();
}

}  // namespace

std::string error_map_plot(const ErrorMap& map, PictureFormat format) {
  const std::string script = map.grid ? GridPlot(map).script() : program_script(map);
  return format == PictureFormat::svg ? plot_svg(script, kMapWidth, kMapHeight)
                                      : plot_png(script, kMapWidth, kMapHeight);
}

}  // namespace armtrue
