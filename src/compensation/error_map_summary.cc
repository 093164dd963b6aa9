#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "armtrue/compensation/error_map.h"

namespace armtrue {
namespace {

constexpr double kDefaultPartShare = 0.5;  // of the box: size of a part, if nobody says it
constexpr double kOnAPoint = 1e-9;         // of a step: the part ends on a point
constexpr double kErrorsAlike = 0.01;      // of the mean: no place is better than another

// Sums over boxes of a grid, each in eight steps (summed-area table, Crow 1984).
class BoxSums {
 public:
  template <typename ValueOf>
  BoxSums(const Grid& grid, const ValueOf& value_of) : count_(grid.count) {
    sums_.assign(static_cast<size_t>(count_[0] + 1) * static_cast<size_t>(count_[1] + 1) *
                     static_cast<size_t>(count_[2] + 1),
                 0.0);
    for (int point = 0; point < grid.points(); ++point) {
      const auto [x, y, z] = grid.place(point);
      sums_[index(x + 1, y + 1, z + 1)] =
          value_of(point) + at(x, y + 1, z + 1) + at(x + 1, y, z + 1) + at(x + 1, y + 1, z) -
          at(x, y, z + 1) - at(x, y + 1, z) - at(x + 1, y, z) + at(x, y, z);
    }
  }

  // Over the points from `low` on, `size` of them along each side.
  double sum(const std::array<int, 3>& low, const std::array<int, 3>& size) const {
    const auto [a, b, c] = low;
    const int x = a + size[0], y = b + size[1], z = c + size[2];
    return at(x, y, z) - at(a, y, z) - at(x, b, z) - at(x, y, c) + at(a, b, z) + at(a, y, c) +
           at(x, b, c) - at(a, b, c);
  }

 private:
  size_t index(int x, int y, int z) const {
    return static_cast<size_t>(x) +
           static_cast<size_t>(count_[0] + 1) *
               (static_cast<size_t>(y) +
                static_cast<size_t>(count_[1] + 1) * static_cast<size_t>(z));
  }
  double at(int x, int y, int z) const { return sums_[index(x, y, z)]; }

  std::array<int, 3> count_;
  std::vector<double> sums_;
};

// Points along each side that a part covers.
std::array<int, 3> points_covered(const Grid& grid, const Eigen::Vector3d& part) {
  std::array<int, 3> covered{1, 1, 1};
  for (int axis = 0; axis < 3; ++axis) {
    const int steps = grid.count[axis] - 1;
    if (steps == 0) continue;
    const double step = (grid.high[axis] - grid.low[axis]) / steps;
    const double covers = std::min<double>(steps, part[axis] / step + kOnAPoint);
    covered[axis] = static_cast<int>(covers) + 1;
  }
  return covered;
}

struct BestAndWorst {
  std::optional<PartPlace> best, worst;
};

// The places of a part in the grid with the smallest and the largest mean.
template <typename ValueOf>
BestAndWorst placements(const ErrorMap& map, const Eigen::Vector3d& part, const ValueOf& value_of) {
  const Grid& grid = *map.grid;
  const std::array<int, 3> size = points_covered(grid, part);
  const int points = size[0] * size[1] * size[2];
  const BoxSums values(grid, [&](size_t point) {
    return map.points[point].is_predicted ? value_of(map.points[point]) : 0.0;
  });
  const BoxSums predicted(grid,
                          [&](size_t point) { return map.points[point].is_predicted ? 1.0 : 0.0; });
  BestAndWorst found;
  std::array<int, 3> low{};
  for (low[2] = 0; low[2] + size[2] <= grid.count[2]; ++low[2])
    for (low[1] = 0; low[1] + size[1] <= grid.count[1]; ++low[1])
      for (low[0] = 0; low[0] + size[0] <= grid.count[0]; ++low[0]) {
        if (std::lround(predicted.sum(low, size)) != points) continue;
        PartPlace here;
        here.mean = values.sum(low, size) / points;
        for (int axis = 0; axis < 3; ++axis) {
          const size_t side = axis;
          here.low[axis] = grid.coordinate(axis, low[side]);
          here.high[axis] = grid.coordinate(axis, low[side] + size[side] - 1);
        }
        if (!found.best || here.mean < found.best->mean) found.best = here;
        if (!found.worst || here.mean > found.worst->mean) found.worst = here;
      }
  return found;
}

template <typename ValueOf>
ErrorSummary over_predicted(const ErrorMap& map, const ValueOf& value_of) {
  std::vector<double> values;
  for (const MapPoint& point : map.points)
    if (point.is_predicted) values.push_back(value_of(point));
  return summarize(std::move(values));
}

void add_causes(const ErrorMap& map, ErrorMapSummary& summary) {
  double squares = 0;
  for (const MapPoint& point : map.points) squares += point.error.squaredNorm();
  for (size_t cause = 0; cause < map.causes.size(); ++cause) {
    CauseSummary& one = summary.causes.emplace_back();
    one.cause = map.causes[cause];
    double product = 0;
    for (size_t k = 0; k < map.points.size(); ++k) {
      if (!map.points[k].is_predicted) continue;
      const Eigen::Vector3d& part = map.part(k, cause);
      one.mean += part.norm();
      one.max = std::max(one.max, part.norm());
      product += part.dot(map.points[k].error);
    }
    one.mean /= summary.predicted;
    one.share = squares > 0 ? product / squares : 0;
  }
}

void add_direction(const ErrorMap& map, ErrorMapSummary& summary) {
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (size_t k = 0; k < map.points.size(); ++k) {
    const MapPoint& point = map.points[k];
    if (!point.is_predicted) continue;
    const auto number = static_cast<int>(k);
    const auto length = [&](int other) { return map.points[other].error.norm(); };
    if (summary.best < 0 || point.error.norm() < length(summary.best)) summary.best = number;
    if (summary.worst < 0 || point.error.norm() > length(summary.worst)) summary.worst = number;
    summary.mean_error += point.error / summary.predicted;
    moments += point.error * point.error.transpose() / summary.predicted;
  }
  if (moments.trace() <= 0) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments);
  summary.axis = solver.eigenvectors().col(2);
  Eigen::Index largest = 0;
  summary.axis.cwiseAbs().maxCoeff(&largest);
  if (summary.axis[largest] < 0) summary.axis = -summary.axis;
  summary.axis_share = solver.eigenvalues()[2] / moments.trace();
}

void add_placements(const ErrorMap& map, ErrorMapSummary& summary) {
  const auto before =
      placements(map, summary.part, [](const MapPoint& point) { return point.error.norm(); });
  summary.best_before = before.best;
  summary.worst_before = before.worst;
  if (!summary.after) return;
  const auto after =
      placements(map, summary.part, [](const MapPoint& point) { return *point.after; });
  summary.best_after = after.best;
  summary.worst_after = after.worst;
}

std::string millimetres(double metres) { return fmt::format("{:.3g}", metres / kMillimetre); }

// `x 1400 to 1800, y ...`, in mm.
std::string box_text(const PartPlace& placement) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis)
    text += fmt::format("{}{} {:.6g} to {:.6g}", axis > 0 ? ", " : "", "xyz"[axis],
                        placement.low[axis] / kMillimetre, placement.high[axis] / kMillimetre);
  return text;
}

}  // namespace

ErrorMapSummary summarize(const ErrorMap& map, const std::optional<Eigen::Vector3d>& part) {
  ErrorMapSummary summary;
  summary.predicted = static_cast<int>(std::ranges::count_if(map.points, &MapPoint::is_predicted));
  if (summary.predicted == 0)
    throw std::invalid_argument(
        "no point can be reached within the travel of the joints; check frame and unit of the "
        "points, --base, --tool and --orientation, and that --start is of the branch that is "
        "meant");
  summary.before = over_predicted(map, [](const MapPoint& p) { return p.error.norm(); });
  summary.turn = over_predicted(map, [](const MapPoint& p) { return p.turn; });
  summary.left_by_constants =
      over_predicted(map, [](const MapPoint& p) { return p.left_by_constants; });
  const auto known = [](const MapPoint& point) { return point.deviation.has_value(); };
  if (std::ranges::any_of(map.points, known)) {
    summary.after = over_predicted(map, [](const MapPoint& p) { return *p.after; });
    summary.deviation = over_predicted(map, [](const MapPoint& p) { return *p.deviation; });
  }
  add_causes(map, summary);
  add_direction(map, summary);
  if (!map.grid) return summary;
  summary.part = part.value_or(kDefaultPartShare * (map.grid->high - map.grid->low));
  add_placements(map, summary);
  return summary;
}

std::string error_map_sentence(const ErrorMap& map, const ErrorMapSummary& summary) {
  std::string text = fmt::format(
      "{} of {} points can be reached; there the arm errs by {} mm in the mean and {} mm at most",
      summary.predicted, map.points.size(), millimetres(summary.before.mean),
      millimetres(summary.before.max));
  if (map.effects > 0)
    text += fmt::format("; with the identified constants alone {} mm would be left in the mean",
                        millimetres(summary.left_by_constants.mean));
  if (summary.after)
    text += fmt::format("{} {} mm",
                        map.effects > 0 ? ", with its effects too"
                                        : "; with the identified constants there would be left",
                        millimetres(summary.after->mean));
  const double alike = kErrorsAlike * summary.before.mean;
  if (summary.best_before && summary.worst_before->mean - summary.best_before->mean > alike)
    text += fmt::format(
        ". As it is, the part stands best at {} mm: {} mm in the mean, against {} mm at the worst "
        "place",
        box_text(*summary.best_before), millimetres(summary.best_before->mean),
        millimetres(summary.worst_before->mean));
  if (map.grid && !summary.best_before)
    text += ". No place in the box can be reached as a whole by a part of this size";
  return text + ".";
}

}  // namespace armtrue
