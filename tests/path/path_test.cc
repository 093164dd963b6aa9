#include "armtrue/path/path.h"

#include <gtest/gtest.h>

namespace armtrue::path_test {
namespace {

// Stands, moves along x, stands, moves along y, stands.
Path corner() {
  Path path;
  path.time = Eigen::VectorXd::LinSpaced(9, 0, 0.8);
  path.position = Eigen::Matrix3Xd::Zero(3, 9);
  path.position.row(0) << 0, 0, 0, 1, 2, 2, 2, 2, 2;
  path.position.row(1) << 0, 0, 0, 0, 0, 0, 0, 3, 3;
  return path;
}

TEST(Path, ArcLengthIsThatOfThePolygon) {
  const Eigen::VectorXd length = arc_length(corner());
  EXPECT_EQ(length[2], 0);
  EXPECT_EQ(length[4], 2);
  EXPECT_EQ(length[8], 5);
}

TEST(Path, StandstillHasTheTangentOfTheNearestMotion) {
  const Eigen::Matrix3Xd tangent = tangents(corner());
  for (const int i : {0, 1, 2, 3, 4, 5}) EXPECT_EQ(tangent.col(i), Eigen::Vector3d::UnitX()) << i;
  for (const int i : {6, 7, 8}) EXPECT_EQ(tangent.col(i), Eigen::Vector3d::UnitY()) << i;
}

TEST(Path, APathThatStandsHasNoTangent) {
  Path path = corner();
  path.position.setOnes();
  EXPECT_TRUE(tangents(path).isZero());
}

}  // namespace
}  // namespace armtrue::path_test
