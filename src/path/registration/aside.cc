#include "armtrue/path/registration/aside.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"
#include "linear_algebra/decompositions.h"
#include "path/registration/formatted.h"

namespace armtrue {
namespace {

using Eigen::Index;

// The normal of the plane in which a path bends; it points to the positive side of the axis along
// which it is longest. Nothing for a straight path, and for one that leaves its plane.
std::optional<Eigen::Vector3d> normal_of_bends(const Path& path) {
  constexpr double kBends = 1e-3, kLeaves = 0.1;  // of the extent before
  const Eigen::MatrixXd off = path.position.colwise() - path.position.rowwise().mean();
  const Eigen::JacobiSVD<Eigen::MatrixXd> axes(off * off.transpose(), Eigen::ComputeFullU);
  const Eigen::VectorXd extents = axes.singularValues().cwiseSqrt();
  if (extents[1] < kBends * extents[0] || extents[2] > kLeaves * extents[1]) return std::nullopt;
  Eigen::Vector3d normal = axes.matrixU().col(2);
  Index longest = 0;
  normal.cwiseAbs().maxCoeff(&longest);
  return normal[longest] < 0 ? Eigen::Vector3d(-normal) : normal;
}

// Sides of a polygon without those of no length.
struct Sides {
  explicit Sides(const Path& path) {
    std::vector<Index> kept{0};
    for (Index i = 1; i < path.samples(); ++i)
      if ((path.position.col(i) - path.position.col(kept.back())).norm() > kStandstill)
        kept.push_back(i);
    vertex = path.position(Eigen::all, kept);
    along = vertex.rightCols(vertex.cols() - 1) - vertex.leftCols(vertex.cols() - 1);
    length = along.colwise().norm().transpose();
    along.colwise().normalize();
  }

  Eigen::Matrix3Xd vertex, along;
  Eigen::VectorXd length;
};

// From the nearest place of the polygon to a point, with the direction of travel there.
struct Departure {
  Eigen::Vector3d off, along;
};

Departure departure(const Sides& sides, const Eigen::Vector3d& point) {
  Departure nearest{Eigen::Vector3d::Constant(INFINITY), Eigen::Vector3d::Zero()};
  for (Index k = 0; k < sides.along.cols(); ++k) {
    const Eigen::Vector3d from = point - sides.vertex.col(k), along = sides.along.col(k);
    const Eigen::Vector3d off = from - std::clamp(from.dot(along), 0.0, sides.length[k]) * along;
    if (off.squaredNorm() < nearest.off.squaredNorm()) nearest = {off, along};
  }
  return nearest;
}

// The angle by which a path turns to the left in all [rad].
double turn_to_left(const Sides& sides, const Eigen::Vector3d& normal) {
  double turn = 0;
  for (Index k = 1; k < sides.along.cols(); ++k) {
    const Eigen::Vector3d before = sides.along.col(k - 1), after = sides.along.col(k);
    turn += std::atan2(normal.dot(before.cross(after)), before.dot(after));
  }
  return turn;
}

}  // namespace

bool Aside::explains(double earlier) const {
  return std::abs(earlier - shorter) < std::abs(earlier) / 2;
}

std::optional<Aside> find_aside(const Path& programmed, const Path& measured) {
  constexpr Index kPlaces = 300;  // of the record: enough for a median
  constexpr double kMostOff = 1.0 / 3, kBetter = 0.5;
  const auto normal = normal_of_bends(programmed);
  if (!normal) return std::nullopt;
  const Sides sides(programmed);
  const Index step = std::max<Index>(1, measured.samples() / kPlaces);
  std::vector<double> left;
  std::vector<Eigen::Vector3d> off;
  for (Index i = 0; i < measured.samples(); i += step) {
    const Departure place = departure(sides, measured.position.col(i));
    const Eigen::Vector3d across = place.off - normal->dot(place.off) * *normal;
    left.push_back(std::copysign(across.norm(), normal->cross(place.along).dot(across)));
    off.push_back(across);
  }
  Aside aside{median(left), 0, *normal, 0};
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& across : off) shift += across / std::ssize(off);
  std::vector<double> apart;
  double square = 0, of_shift = 0;
  for (size_t i = 0; i < left.size(); ++i) {
    apart.push_back(std::abs(left[i] - aside.left));
    square += apart.back() * apart.back();
    of_shift += (off[i] - shift).squaredNorm();
  }
  aside.within = quantile(std::move(apart), 0.9);
  aside.shorter = aside.left * turn_to_left(sides, *normal);
  if (aside.within > kMostOff * std::abs(aside.left) || square > kBetter * kBetter * of_shift)
    return std::nullopt;
  return aside;
}

std::string in_words(const Aside& aside) {
  Index axis = 0;
  aside.from.cwiseAbs().maxCoeff(&axis);
  return "runs " + formatted("%.3g", std::abs(aside.left) / kMillimetre) + " mm to the " +
         (aside.left > 0 ? "left" : "right") + " of travel all along the program, seen from +" +
         std::string(1, "xyz"[axis]) + " (nine of ten samples within " +
         formatted("%.2g", aside.within / kMillimetre) +
         " mm): is one of them that of the edge of the tool, the other that of its centre? A "
         "radius is no deviation of the arm; give the program of the point that was recorded";
}

}  // namespace armtrue
