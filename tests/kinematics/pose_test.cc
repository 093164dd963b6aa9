#include "armtrue/kinematics/pose.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "support/random_chain.h"

namespace armtrue {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Pose random_pose(armtrue_oracle::Uniform& uniform) {
  return {rotation_exp({uniform(-2, 2), uniform(-2, 2), uniform(-1, 1)}),
          {uniform(-3, 3), uniform(-3, 3), uniform(-3, 3)}};
}

TEST(Pose, InverseUndoesAndProductsAssociate) {
  armtrue_oracle::Uniform uniform(1);
  for (int i = 0; i < 100; ++i) {
    const Pose a = random_pose(uniform), b = random_pose(uniform), c = random_pose(uniform);
    const Pose unit = a * inverse(a);
    EXPECT_NEAR((unit.rotation - Matrix3d::Identity()).norm(), 0, 1e-14);
    EXPECT_NEAR(unit.translation.norm(), 0, 1e-14);
    const Pose left = (a * b) * c, right = a * (b * c);
    EXPECT_NEAR((left.rotation - right.rotation).norm(), 0, 1e-14);
    EXPECT_NEAR((left.translation - right.translation).norm(), 0, 1e-13);
  }
}

TEST(Pose, KukaAnglesComeBackAlsoUpright) {
  constexpr double kRight = std::numbers::pi / 2;
  armtrue_oracle::Uniform uniform(2);
  for (int i = 0; i < 300; ++i) {
    double b = uniform(-kRight, kRight);
    if (i % 3 == 0) b = i % 2 ? kRight : -kRight;
    const Matrix3d r = rotation_from_abc(uniform(-3, 3), b, uniform(-3, 3));
    const Vector3d abc = abc_from_rotation(r);
    EXPECT_NEAR((rotation_from_abc(abc[0], abc[1], abc[2]) - r).norm(), 0, 2e-12) << "b = " << b;
  }
  // R = Rz(A) Ry(B) Rx(C): A alone turns x towards y.
  EXPECT_NEAR(rotation_from_abc(kRight, 0, 0)(1, 0), 1, 1e-15);
}

TEST(Pose, LogAndExpAreInverseFromZeroToPi) {
  const Vector3d axis = Vector3d(0.6, -0.5, 0.62).normalized();
  for (double angle : {0.0, 1e-12, 1e-8, 1e-3, 1.0, 3.0, std::numbers::pi - 1e-7})
    EXPECT_NEAR((rotation_log(rotation_exp(angle * axis)) - angle * axis).norm(), 0, 1e-9)
        << "angle " << angle;
}

TEST(Pose, InverseRightJacobianIsTheDerivativeOfTheLogarithm) {
  armtrue_oracle::Uniform uniform(3);
  constexpr double kStep = 1e-6;
  for (double size : {0.0, 1e-5, 0.1, 1.0, 2.5}) {
    const Vector3d w = size * Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized();
    for (int k = 0; k < 3; ++k) {
      const Vector3d e = kStep * Vector3d::Unit(k);
      const Vector3d numeric = (rotation_log(rotation_exp(w) * rotation_exp(e)) -
                                rotation_log(rotation_exp(w) * rotation_exp(-e))) /
                               (2 * kStep);
      EXPECT_NEAR((inverse_right_jacobian(w).col(k) - numeric).norm(), 0, 1e-8) << "size " << size;
    }
  }
}

}  // namespace
}  // namespace armtrue
