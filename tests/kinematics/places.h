#pragma once

// Where the laws of rotations are tested: at the identity, at 1e-15, 1e-8 and 1e-3, near pi and at
// pi, where KUKA's angles are singular (b = +-90 degrees) and near there, and at random.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <ostream>
#include <vector>

#include "support/random_chain.h"

namespace armtrue {

struct Place {
  enum class Kind { angle, upright, random };
  const char* name;
  Kind kind;
  double value = 0;  ///< angle of the rotation; or by how much b is less than pi/2
};

inline void PrintTo(const Place& place, std::ostream* out) { *out << place.name; }

inline const Place kPlaces[] = {
    {"identity", Place::Kind::angle, 0},
    {"near_identity_1e15", Place::Kind::angle, 1e-15},
    {"near_identity_1e8", Place::Kind::angle, 1e-8},
    {"near_identity_1e3", Place::Kind::angle, 1e-3},
    {"small_9e3", Place::Kind::angle, 9e-3},
    {"near_pi_1e3", Place::Kind::angle, std::numbers::pi - 1e-3},
    {"near_pi_1e8", Place::Kind::angle, std::numbers::pi - 1e-8},
    {"pi", Place::Kind::angle, std::numbers::pi},
    {"near_upright_1e3", Place::Kind::upright, 1e-3},
    {"near_upright_1e8", Place::Kind::upright, 1e-8},
    {"upright", Place::Kind::upright, 0},
    {"random", Place::Kind::random},
};

inline std::string place_name(const testing::TestParamInfo<Place>& info) { return info.param.name; }

inline Eigen::Vector3d random_axis(armtrue_oracle::Uniform& uniform) {
  Eigen::Vector3d axis;
  do axis = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
  while (axis.norm() < 0.1 || axis.norm() > 1);
  return axis.normalized();
}

/// Rotation vectors, norm at most pi, that lie at a place: first about the axes of the frame, both
/// ways, then about others.
inline std::vector<Eigen::Vector3d> rotation_vectors(const Place& place, int count) {
  using Eigen::Vector3d;
  armtrue_oracle::Uniform uniform(101);
  std::vector<Vector3d> result;
  for (int i = 0; i < count; ++i) {
    const Vector3d axis =
        i < 6 ? Vector3d((i < 3 ? 1 : -1) * Vector3d::Unit(i % 3)) : random_axis(uniform);
    if (place.kind == Place::Kind::upright) {
      const double b = (i % 2 ? 1 : -1) * (std::numbers::pi / 2 - place.value);
      const double a = i < 6 ? 0 : uniform(-3, 3), c = i < 3 ? 0 : uniform(-3, 3);
      const Eigen::AngleAxisd turn(Eigen::AngleAxisd(a, Vector3d::UnitZ()) *
                                   Eigen::AngleAxisd(b, Vector3d::UnitY()) *
                                   Eigen::AngleAxisd(c, Vector3d::UnitX()));
      const double angle = std::remainder(turn.angle(), 2 * std::numbers::pi);
      result.push_back(angle * turn.axis());
    } else {
      const bool random = place.kind == Place::Kind::random;
      result.push_back((random ? uniform(0, std::numbers::pi) : place.value) * axis);
    }
  }
  return result;
}

}  // namespace armtrue
