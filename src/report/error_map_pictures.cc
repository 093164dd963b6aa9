#include "report/error_map_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "armtrue/kinematics/units.h"
#include "report/prediction_parts.h"
#include "report/residual_pictures.h"

namespace armtrue {
namespace {

constexpr int kSlices = 3;
constexpr int kCellsPerSide = 26;  // of a slice; of more points some are shown
constexpr int kArrowsPerSide = 9;
constexpr Eigen::Index kPathArrows = 60;  // of a path; more would overlap
constexpr double kSliceHeight = 230;

std::optional<double> left_of(const MapPoint& point) {
  if (!point.is_predicted) return std::nullopt;
  return point.after ? *point.after : point.left_by_constants;
}

std::string left_name(const ErrorMap& map) {
  const bool is_known = std::ranges::any_of(
      map.points, [](const MapPoint& point) { return point.after.has_value(); });
  return is_known ? "left with constants and effects" : "left with the constants alone";
}

// Draws slices of a grid across the side with the fewest points.
class GridPictures {
 public:
  explicit GridPictures(const ErrorMap& map) : map_(map), grid_(*map.grid) {
    const auto fewest = std::ranges::min_element(grid_.count);
    across_ = static_cast<int>(fewest - grid_.count.begin());
    if (*fewest == grid_.count[2]) across_ = 2;  // the view from above is read most easily
    right_ = across_ == 0 ? 1 : 0;
    up_ = across_ == 2 ? 1 : 2;
    for (const MapPoint& point : map.points) {
      if (!point.is_predicted) continue;
      const std::array<double, 2> values{point.error.norm(), *left_of(point)};
      for (size_t k = 0; k < 2; ++k) {
        low_[k] = std::min(low_[k], values[k]);
        high_[k] = std::max(high_[k], values[k]);
      }
      longest_ = std::max(longest_, std::hypot(point.error[right_], point.error[up_]));
    }
  }

  Drawing picture(bool is_before) const {
    const double step_right = step(right_), step_up = step(up_);
    const double factor = round_magnification(longest_, (grid_.high - grid_.low).maxCoeff());
    const double arrow = factor * longest_ / kMillimetre;
    const Eigen::Vector2d half(std::max(0.5 * step_right, arrow), std::max(0.5 * step_up, arrow));
    const MapAxes axes = map_axes(corner(grid_.low) - half, corner(grid_.high) + half,
                                  fmt::format("{}, mm", "xyz"[right_]),
                                  fmt::format("{}, mm", "xyz"[up_]), kSliceHeight);
    const std::string note =
        is_before ? fmt::format(
                        " Arrows along {} and {} are {:g} times as long as the errors; the "
                        "longest is {:.3g} mm.",
                        "xyz"[right_], "xyz"[up_], factor, longest_ / kMillimetre)
                  : " Colours and sizes count from 0 to the largest error as it is.";
    auto picture = std::make_shared<Picture>(
        is_before ? "map-before" : "map-after",
        is_before ? "Predicted error as it is" : "Error " + left_name(map_),
        "Larger squares with a stronger colour err more; where there is none, the arm is not "
        "predicted." +
            note + thinned(),
        axes.x);
    const auto [low, high] = limits(is_before);
    picture->heat_legend(low / kMillimetre, high / kMillimetre, "mm");
    for (const int slice : evenly(count(across_), kSlices)) {
      Axis y = axes.y;
      y.label += fmt::format(" (at {} = {:g} mm)", "xyz"[across_], mm(across_, slice));
      draw(picture->panel(y, axes.height), slice, is_before, factor);
    }
    return picture;
  }

 private:
  int count(int axis) const { return grid_.count[axis]; }

  double mm(int axis, int place) const { return grid_.coordinate(axis, place) / kMillimetre; }

  Eigen::Vector2d corner(const Eigen::Vector3d& v) const {
    return Eigen::Vector2d(v[right_], v[up_]) / kMillimetre;
  }

  // Ends of the colour classes. Before: all values, over at least a quarter of the largest, so that
  // small differences do not look large. After: from 0 to the largest of both pictures, so that
  // they show the gain.
  std::array<double, 2> limits(bool is_before) const {
    constexpr double kLeastShare = 0.25;
    if (!is_before) return {0, std::max(high_[0], high_[1])};
    return {std::min(low_[0], (1 - kLeastShare) * high_[0]), high_[0]};
  }

  // Distance between the cells that are drawn [mm].
  double step(int axis) const {
    constexpr double kLeastStep = 1;
    const int shown = std::min(count(axis), kCellsPerSide);
    const double side = (grid_.high[axis] - grid_.low[axis]) / kMillimetre;
    return std::max(kLeastStep, shown > 1 ? side / (shown - 1) : side);
  }

  std::string thinned() const {
    const Eigen::Index most = std::max(count(right_), count(up_));
    return most > kCellsPerSide || count(across_) > kSlices
               ? fmt::format(" Of {} points some are drawn, evenly spread.", map_.points.size())
               : std::string();
  }

  const MapPoint& at(int slice, int right, int up) const {
    std::array<int, 3> place{};
    place[across_] = slice;
    place[right_] = right;
    place[up_] = up;
    return map_.points[grid_.point(place)];
  }

  void draw(Panel& panel, int slice, bool is_before, double factor) const {
    const auto [low, high] = limits(is_before);
    Points centres;
    std::vector<int> classes;
    std::vector<std::string> texts;
    for (const int v : evenly(count(up_), kCellsPerSide))
      for (const int u : evenly(count(right_), kCellsPerSide)) {
        const MapPoint& point = at(slice, u, v);
        if (!point.is_predicted) continue;
        const double value = is_before ? point.error.norm() : *left_of(point);
        centres.emplace_back(mm(right_, u), mm(up_, v));
        const Eigen::Vector3d place = point.position / kMillimetre;
        texts.push_back(fmt::format("{:.3g} mm at {:g}, {:g}, {:g} mm", value / kMillimetre,
                                    place.x(), place.y(), place.z()));
        classes.push_back(std::min(kHeatClasses - 1,
                                   static_cast<int>(kHeatClasses * (value - low) / (high - low))));
      }
    panel.cells(centres, classes, step(right_), step(up_), texts);
    Points from, to;
    for (const int v : evenly(count(up_), kArrowsPerSide))
      for (const int u : evenly(count(right_), kArrowsPerSide)) {
        const MapPoint& point = at(slice, u, v);
        if (!is_before || !point.is_predicted) continue;
        from.emplace_back(mm(right_, u), mm(up_, v));
        to.emplace_back(from.back() + factor * corner(point.error));
      }
    panel.vectors(from, to, Look::before, "");
  }

  const ErrorMap& map_;
  const Grid& grid_;
  int across_ = 2, right_ = 0, up_ = 1;
  // Of the error before and of what is left; the longest arrow [m].
  std::array<double, 2> low_{1e300, 1e300}, high_{1e-9, 1e-9};
  double longest_ = 0;
};

}  // namespace

std::vector<Drawing> error_map_pictures(const ErrorMap& map) {
  if (map.grid) {
    const GridPictures grid(map);
    return {grid.picture(true), grid.picture(false)};
  }
  std::vector<Eigen::Vector3d> places, errors;
  const Eigen::Index rows = map.points.size();
  std::vector<std::string> predicted;  // names of the places
  const double none = std::numeric_limits<double>::quiet_NaN();
  Eigen::VectorXd before = Eigen::VectorXd::Constant(rows, none), after = before;
  for (Eigen::Index k = 0; k < rows; ++k) {
    const MapPoint& point = map.points[k];
    if (!point.is_predicted) continue;
    places.push_back(point.position);
    predicted.push_back(map.names[k]);
    errors.push_back(point.error);
    before[k] = point.error.norm() / kMillimetre;
    after[k] = *left_of(point) / kMillimetre;
  }
  std::vector<Drawing> pictures =
      field_maps(places, {{"error as it is", Look::before, errors}},
                 {"map", "Predicted error", "the program's frame", "Error of each point.", "errors",
                  kPathArrows, predicted});
  pictures.push_back(rows_picture(before, after, {.after = left_name(map), .names = map.names}));
  return pictures;
}

}  // namespace armtrue
