#include "armtrue/kinematics/pose.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

#include "kinematics/places.h"

namespace armtrue::pose_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr int kSamples = 60;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
// An entry of a product is a sum of three: each law is at most four products in a row.
constexpr double kRounding = 16 * kEpsilon;
const Matrix3d kOne = Matrix3d::Identity();

// Every law is tested at every place (places.h).
class PoseLaws : public testing::TestWithParam<Place> {
 protected:
  // Poses at the place, in threes; the second and third of every other three are at random.
  // Translations have the place's size, at most 3 m.
  struct Three {
    Pose a, b, c;
  };
  std::vector<Three> threes() {
    const std::vector<Vector3d> here = rotation_vectors(GetParam(), 3 * kSamples);
    const std::vector<Vector3d> anywhere = rotation_vectors(kPlaces[std::size(kPlaces) - 1], 9);
    std::vector<Three> result;
    for (size_t i = 0; i < kSamples; ++i) {
      const bool mixed = i % 2 != 0;
      result.push_back({pose(here[i]), pose(mixed ? anywhere[i % 9] : here[kSamples + i]),
                        pose(mixed ? anywhere[(i + 4) % 9] : here[2 * kSamples + i])});
    }
    return result;
  }
  Pose pose(const Vector3d& w) { return {rotation_exp(w), std::min(w.norm(), 3.0) * point()}; }
  Vector3d point() { return {uniform_(-1, 1), uniform_(-1, 1), uniform_(-1, 1)}; }

 private:
  armtrue_oracle::Uniform uniform_{1};
};

INSTANTIATE_TEST_SUITE_P(, PoseLaws, testing::ValuesIn(kPlaces), place_name);

double size(const Pose& pose) { return pose.translation.norm(); }

void expect_equal(const Pose& a, const Pose& b, double length) {
  EXPECT_LE((a.rotation - b.rotation).norm(), kRounding);
  EXPECT_LE((a.translation - b.translation).norm(), kRounding * length);
}

TEST_P(PoseLaws, ProductsAssociate) {
  for (const auto& [a, b, c] : threes())
    expect_equal((a * b) * c, a * (b * c), size(a) + size(b) + size(c));
}

TEST_P(PoseLaws, TheIdentityChangesNothing) {
  for (const auto& [a, b, c] : threes())
    for (const Pose& same : {a * Pose{}, Pose{} * a}) {
      EXPECT_EQ(same.rotation, a.rotation);
      EXPECT_EQ(same.translation, a.translation);
    }
  EXPECT_EQ(inverse(Pose{}).rotation, kOne);
  EXPECT_EQ(inverse(Pose{}).translation, Vector3d::Zero());
}

TEST_P(PoseLaws, TheInverseUndoes) {
  for (const auto& [a, b, c] : threes()) {
    expect_equal(a * inverse(a), {}, size(a));
    expect_equal(inverse(a) * a, {}, size(a));
    expect_equal(inverse(inverse(a)), a, size(a));
    expect_equal(inverse(a * b), inverse(b) * inverse(a), size(a) + size(b));
  }
}

TEST_P(PoseLaws, PointsFollow) {
  for (const auto& [a, b, c] : threes()) {
    const Vector3d p = point(), other = point();
    const double length = size(a) + size(b) + p.norm() + other.norm();
    EXPECT_LE(((a * b) * p - a * (b * p)).norm(), kRounding * length);
    EXPECT_LE((inverse(a) * (a * p) - p).norm(), kRounding * length);
    EXPECT_NEAR((a * p - a * other).norm(), (p - other).norm(), kRounding * length);
    EXPECT_EQ(a * Vector3d(0, 0, 0), a.translation);
    EXPECT_EQ(Pose{} * p, p);
    // A point is a pose without rotation.
    EXPECT_LE(((a * Pose{kOne, p}).translation - a * p).norm(), kRounding * length);
  }
}

TEST_P(PoseLaws, TheCrossMatrixIsTheCrossProduct) {
  for (const Vector3d& w : rotation_vectors(GetParam(), kSamples)) {
    const Vector3d u = point();
    EXPECT_LE((cross_matrix(w) * u - w.cross(u)).norm(), kRounding * w.norm());
    EXPECT_EQ(cross_matrix(w).transpose(), cross_matrix(-w));
  }
}

TEST_P(PoseLaws, ExpIsTheExponentialOfTheCrossMatrix) {
  for (const Vector3d& w : rotation_vectors(GetParam(), kSamples)) {
    const Matrix3d r = rotation_exp(w);
    // The matrix exponential squares what it sums: its own error.
    EXPECT_LE((r - cross_matrix(w).exp()).norm(), 2 * kRounding) << w.transpose();
    EXPECT_LE((r * r.transpose() - kOne).norm(), kRounding);
    EXPECT_NEAR(r.determinant(), 1, kRounding);
    EXPECT_EQ(rotation_exp(-w), r.transpose());
    EXPECT_LE((r * w - w).norm(), kRounding * w.norm());
  }
}

TEST_P(PoseLaws, LogUndoesExp) {
  for (const Vector3d& w : rotation_vectors(GetParam(), kSamples)) {
    const Vector3d back = rotation_log(rotation_exp(w));
    // At pi, w and -w are the same rotation. Elsewhere, also at 1e-8, all digits come back.
    const double error =
        w.norm() < pi - 1e-15 ? (back - w).norm() : std::min((back - w).norm(), (back + w).norm());
    EXPECT_LE(error, kRounding * w.norm()) << w.transpose();
  }
}

TEST_P(PoseLaws, ExpUndoesLog) {
  for (const auto& [a, b, c] : threes())
    for (const Matrix3d& r : {a.rotation, Matrix3d(a.rotation * b.rotation)}) {
      const Vector3d w = rotation_log(r);
      EXPECT_LE((rotation_exp(w) - r).norm(), kRounding) << w.transpose();
      EXPECT_LE(w.norm(), pi + kRounding);
    }
}

// Central differences of rotations: a step of 1e-5 truncates step^2 / 6 = 2e-11 and rounds
// epsilon / step = 2e-11.
constexpr double kStep = 1e-5, kDifferenced = 1e-10;

TEST_P(PoseLaws, ThePerturbationStandsOnTheLeft) {
  for (const Vector3d& w : rotation_vectors(GetParam(), kSamples)) {
    const Matrix3d r = rotation_exp(w);
    for (int k = 0; k < 3; ++k) {
      const Vector3d axis = Vector3d::Unit(k), e = kStep * axis;
      const Matrix3d plus = rotation_exp(e) * r, minus = rotation_exp(-e) * r;
      EXPECT_LE(((plus - minus) / (2 * kStep) - cross_matrix(axis) * r).norm(), kDifferenced);
      EXPECT_LE((rotation_log(plus * r.transpose()) - e).norm(), kRounding);
      // On the right the same rotation is about the axis that r has turned: r exp(e) = exp(r e) r.
      EXPECT_LE((r * rotation_exp(e) - rotation_exp(r * e) * r).norm(), kRounding);
    }
  }
}

TEST_P(PoseLaws, InverseRightJacobianIsTheDerivativeOfTheLogarithm) {
  for (const Vector3d& w : rotation_vectors(GetParam(), kSamples)) {
    // Jr(w) from exp(w + e) = exp(w) exp(Jr(w) e), which is smooth where the logarithm jumps.
    const Matrix3d back = rotation_exp(w).transpose();
    Matrix3d jacobian;
    for (int k = 0; k < 3; ++k) {
      const Vector3d e = kStep * Vector3d::Unit(k);
      jacobian.col(k) =
          (rotation_log(back * rotation_exp(w + e)) - rotation_log(back * rotation_exp(w - e))) /
          (2 * kStep);
    }
    // Its factor stays, beyond 3.1 rad, as it is there.
    const double bound = w.norm() < 3.1 ? kDifferenced * pi : 0.01;
    EXPECT_LE((inverse_right_jacobian(w) * jacobian - kOne).norm(), bound) << w.transpose();
    EXPECT_LE((inverse_right_jacobian(w) * w - w).norm(), kRounding * w.norm());
  }
}

// R = Rz(a) Ry(b) Rx(c), written out.
Matrix3d written_out(double a, double b, double c) {
  Matrix3d z, y, x;
  z << std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a), 0, 0, 0, 1;
  y << std::cos(b), 0, std::sin(b), 0, 1, 0, -std::sin(b), 0, std::cos(b);
  x << 1, 0, 0, 0, std::cos(c), -std::sin(c), 0, std::sin(c), std::cos(c);
  return z * y * x;
}

TEST(Pose, TheShortestRotationTurnsOneDirectionIntoTheOther) {
  armtrue_oracle::Uniform uniform(3);
  const auto any = [&] { return Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)); };
  for (int i = 0; i < 300; ++i) {
    const Vector3d from = any(), across = from.cross(any()).normalized();
    // From the same to the opposite direction, and closer to both than a sum of squares resolves.
    for (double angle : {0.0, 1e-12, 1e-8, 1e-3, uniform(0, pi), pi - 1e-8, pi - 1e-12, pi}) {
      const Vector3d to =
          uniform(0.1, 3) * (std::cos(angle) * from + std::sin(angle) * across.cross(from));
      const Matrix3d r = shortest_rotation(from, to);
      EXPECT_LE((r * from.normalized() - to.normalized()).norm(), kRounding) << angle;
      EXPECT_NEAR(std::acos(std::clamp((r.trace() - 1) / 2, -1.0, 1.0)), angle, 3e-8);
      EXPECT_LE((r.transpose() * r - Matrix3d::Identity()).norm(), kRounding);
      EXPECT_NEAR(r.determinant(), 1, kRounding);
    }
  }
}

TEST_P(PoseLaws, KukaAnglesComeBack) {
  for (const auto& [first, b, c] : threes())
    for (const Matrix3d& r : {first.rotation, Matrix3d(first.rotation.transpose())}) {
      const Vector3d abc = abc_from_rotation(r);
      const Matrix3d back = rotation_from_abc(abc[0], abc[1], abc[2]);
      EXPECT_LE((back - written_out(abc[0], abc[1], abc[2])).norm(), kRounding);
      // Angles a and c rest on entries of the size of cos b.
      const double cosine = std::cos(abc[1]);
      EXPECT_LE((back - r).norm(), kRounding / (cosine < 1e-12 ? 1 : cosine)) << abc.transpose();
      EXPECT_LE(std::abs(abc[1]), pi / 2);
      if (cosine < 1e-12) {
        EXPECT_EQ(abc[2], 0);
      }
    }
}

TEST(Pose, KukaAnglesAreThoseThatMadeTheRotation) {
  armtrue_oracle::Uniform uniform(2);
  for (int i = 0; i < 300; ++i) {
    const Vector3d abc(uniform(-pi, pi), uniform(-1.5, 1.5), uniform(-pi, pi));
    const Vector3d back = abc_from_rotation(rotation_from_abc(abc[0], abc[1], abc[2]));
    EXPECT_LE((back - abc).norm(), kRounding / std::cos(abc[1])) << abc.transpose();
    // Upright, a -+ c alone is defined.
    const double side = i % 2 ? 1 : -1;
    const Vector3d upright = abc_from_rotation(rotation_from_abc(abc[0], side * pi / 2, abc[2]));
    EXPECT_NEAR(std::remainder(upright[0] - (abc[0] - side * abc[2]), 2 * pi), 0, kRounding);
    EXPECT_NEAR(upright[1], side * pi / 2, kRounding);
    EXPECT_EQ(upright[2], 0);
  }
}

}  // namespace
}  // namespace armtrue::pose_test
