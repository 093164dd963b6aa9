#include "programs/division.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr int kMaxDepth = 40;  // deeper pieces are halved: the time stays O(n log n)

struct Piece {
  size_t first, last;
  int depth;
};

// Divides every piece at the knot that deviates most, while that is more than the tolerance.
// `deviation(first, last)` returns the function that gives the deviation of a knot of that piece.
template <class Deviation>
std::vector<size_t> divide(const std::vector<Knot>& knots, double tolerance, double shortest,
                           Deviation deviation) {
  std::vector<size_t> divisions{0};
  std::vector<Piece> open{{0, knots.size() - 1, 0}};
  while (!open.empty()) {
    const Piece piece = open.back();
    open.pop_back();
    const auto deviation_at = deviation(piece.first, piece.last);
    size_t worst = piece.first;
    double most = tolerance;
    const auto may_divide = [&](size_t k) {
      constexpr double kRounding = 1 - 1e-9;
      return k > piece.first && k < piece.last &&
             knots[k].t - knots[piece.first].t >= kRounding * shortest &&
             knots[piece.last].t - knots[k].t >= kRounding * shortest;
    };
    for (size_t k = piece.first + 1; k < piece.last; ++k) {
      if (!may_divide(k)) continue;
      if (const double here = deviation_at(k); here > most) {
        most = here;
        worst = k;
      }
    }
    if (worst == piece.first) {
      divisions.push_back(piece.last);
      continue;
    }
    const size_t middle = (piece.first + piece.last) / 2;
    if (piece.depth > kMaxDepth && may_divide(middle)) worst = middle;
    open.push_back({worst, piece.last, piece.depth + 1});
    open.push_back({piece.first, worst, piece.depth + 1});
  }
  return divisions;
}

}  // namespace

Eigen::Vector3d displacement_at(const std::vector<Knot>& knots, double t) {
  const auto next = std::lower_bound(knots.begin(), knots.end(), t,
                                     [](const Knot& knot, double value) { return knot.t < value; });
  if (next == knots.begin()) return next->displacement;
  const Knot& before = *std::prev(next);
  if (next == knots.end()) return before.displacement;
  return before.displacement +
         (t - before.t) / (next->t - before.t) * (next->displacement - before.displacement);
}

std::vector<size_t> divide_line(const std::vector<Knot>& knots, double tolerance, double shortest) {
  return divide(knots, tolerance, shortest, [&](size_t first, size_t last) {
    const Knot a = knots[first], b = knots[last];
    return [&knots, a, b](size_t k) {
      const double share = (knots[k].t - a.t) / (b.t - a.t);
      return (a.displacement + share * (b.displacement - a.displacement) - knots[k].displacement)
          .norm();
    };
  });
}

std::vector<size_t> divide_arc(const Arc& arc, double via, const std::vector<Knot>& knots,
                               double tolerance, double shortest) {
  const auto displaced = [&](double t) -> Eigen::Vector3d {
    return arc.at(t) + displacement_at(knots, t);
  };
  return divide(knots, tolerance, shortest, [&](size_t first, size_t last) {
    const bool whole = first == 0 && last + 1 == knots.size();
    const double middle = whole ? via : (knots[first].t + knots[last].t) / 2;
    const auto piece =
        arc_through(displaced(knots[first].t), displaced(middle), displaced(knots[last].t));
    return [&knots, &arc, piece](size_t k) {
      // Three points on a line define no arc: divide.
      const Eigen::Vector3d wanted = arc.at(knots[k].t) + knots[k].displacement;
      return piece ? piece->distance(wanted) : std::numeric_limits<double>::infinity();
    };
  });
}

bool is_straight(const Arc& arc, const std::vector<Knot>& knots, size_t first, size_t last,
                 double tolerance) {
  const auto displaced = [&](double t) -> Eigen::Vector3d {
    return arc.at(t) + displacement_at(knots, t);
  };
  const Eigen::Vector3d start = displaced(knots[first].t);
  const Eigen::Vector3d along = (displaced(knots[last].t) - start).normalized();
  const auto near = [&](double t) { return along.cross(displaced(t) - start).norm() <= tolerance; };
  for (size_t k = first + 1; k < last; ++k)
    if (!near(knots[k].t)) return false;
  return near((knots[first].t + knots[last].t) / 2);
}

}  // namespace armtrue
