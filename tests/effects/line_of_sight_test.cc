#include "armtrue/effects/line_of_sight.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "armtrue/effects/arrival.h"
#include "armtrue/kinematics/units.h"

namespace armtrue::line_of_sight_test {
namespace {

using Eigen::Vector3d;

const Vector3d kInstrument{3.5, -2.0, 1.2};

// The point at a distance and two angles, z up, azimuth from x.
Vector3d at_angles(double range, double azimuth, double elevation) {
  return kInstrument + range * Vector3d(std::cos(elevation) * std::cos(azimuth),
                                        std::cos(elevation) * std::sin(azimuth),
                                        std::sin(elevation));
}

TEST(LineOfSight, MeasuresSphericalCoordinates) {
  for (const auto& [azimuth, elevation] : {std::pair{0.3, 0.2}, {-2.9, -1.1}, {3.0, 1.5}}) {
    const LineOfSight sight(kInstrument, Vector3d::UnitZ(), at_angles(4.2, azimuth, elevation));
    EXPECT_NEAR(sight.range(), 4.2, 1e-14);
    EXPECT_NEAR(sight.azimuth(), azimuth, 1e-13);
    EXPECT_NEAR(sight.elevation(), elevation, 1e-13);
  }
}

TEST(LineOfSight, ZeroOfTheAzimuthStaysWhereTheVerticalTiltsALittle) {
  constexpr double kTilt = 1e-3;
  for (const Vector3d& tilt :
       {Vector3d(kTilt, 0, 0), {-kTilt, 0, 0}, {0, kTilt, 0}, {0, -kTilt, 0}}) {
    const Vector3d up = (Vector3d::UnitZ() + tilt).normalized();
    const LineOfSight sight(kInstrument, up, at_angles(4.2, 0.3, 0.2));
    EXPECT_NEAR(sight.azimuth(), 0.3, 2 * kTilt);
  }
}

// An instrument on its side, with x or y of R_A upwards: the azimuth counts from the other one.
TEST(LineOfSight, ZeroOfTheAzimuthIsHorizontalWhicheverAxisIsUpright) {
  const Vector3d ray(0.7, -0.4, 1.3);
  const auto azimuth = [&](const Vector3d& up) {
    return LineOfSight(kInstrument, up, kInstrument + ray).azimuth();
  };
  EXPECT_NEAR(azimuth(Vector3d::UnitX()), std::atan2(ray.z(), ray.y()), 1e-14);
  EXPECT_NEAR(azimuth(Vector3d::UnitY()), std::atan2(-ray.z(), ray.x()), 1e-14);
}

TEST(LineOfSight, DerivativesAreThoseOfTheCoordinates) {
  constexpr double kStep = 1e-6;
  for (const auto& [azimuth, elevation] : {std::pair{0.3, 0.2}, {-2.9, -1.1}, {3.0, 1.5}}) {
    const LineOfSight sight(kInstrument, Vector3d::UnitZ(), at_angles(4.2, azimuth, elevation));
    for (int k = 0; k < 3; ++k) {
      const Vector3d step = Vector3d::Unit(k) * kStep;
      const Vector3d difference =
          (at_angles(4.2 + step[0], azimuth + step[1], elevation + step[2]) -
           at_angles(4.2 - step[0], azimuth - step[1], elevation - step[2])) /
          (2 * kStep);
      EXPECT_LT((sight.derivatives().col(k) - difference).norm(), 1e-9);
    }
  }
}

TEST(LineOfSight, DoesNotDependOnTheFrame) {
  const Eigen::Matrix3d turn = rotation_exp({0.4, -0.9, 1.7});
  const Vector3d point = at_angles(2.5, 1.1, -0.4);
  const LineOfSight sight(kInstrument, Vector3d::UnitZ(), point);
  const LineOfSight turned(turn * kInstrument, turn.col(2), turn * point);
  EXPECT_NEAR(turned.elevation(), sight.elevation(), 1e-14);
  EXPECT_LT((turned.derivatives() - turn * sight.derivatives()).norm(), 1e-13);
}

TEST(LineOfSight, StaysFiniteAtTheInstrumentAndAboveIt) {
  const LineOfSight at(kInstrument, Vector3d::UnitZ(), kInstrument);
  EXPECT_EQ(at.range(), 0);
  EXPECT_TRUE(at.derivatives().isZero());
  const LineOfSight above(kInstrument, Vector3d::UnitZ(), kInstrument + Vector3d(0, 0, 2));
  EXPECT_NEAR(above.elevation(), std::numbers::pi / 2, 1e-14);
  EXPECT_TRUE(above.derivatives().allFinite());
}

TEST(LineOfSight, IncidenceIsZeroWhereTheAxisPointsBack) {
  const LineOfSight sight(kInstrument, Vector3d::UnitZ(), kInstrument + Vector3d(2, 0, 0));
  EXPECT_NEAR(sight.incidence(-Vector3d::UnitX()), 0, 1e-7);
  EXPECT_NEAR(sight.incidence(Vector3d::UnitY()), std::numbers::pi / 2, 1e-14);
}

TEST(Arrival, StrokesAddUpUntilTheJointReverses) {
  const auto at = [](double degrees) { return JointVector::Constant(6, degrees * kDegree); };
  Arrival arrival(at(0));
  EXPECT_EQ(arrival.direction()[0], 0);
  EXPECT_EQ(arrival.stroke()[0], 0);
  // Way since the reversal, in deg, at each visit; a rounding of 1e-5 deg is no motion.
  for (const auto& [angle, way] : {std::pair{10.0, 10.0},
                                   {25.0, 25.0},
                                   {25.00001, 25.0},
                                   {20.0, -5.0},
                                   {-10.0, -35.0},
                                   {-9.0, 1.0}}) {
    arrival.go_to(at(angle));
    EXPECT_NEAR(arrival.stroke()[3] / kDegree, way, 2e-5) << angle;
    EXPECT_EQ(arrival.direction()[3], way > 0 ? 1 : -1) << angle;
  }
}

}  // namespace
}  // namespace armtrue::line_of_sight_test
