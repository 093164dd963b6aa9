#include "armtrue/kinematics/joint_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

namespace armtrue::joint_rows_test {
namespace {

JointVector row_of(double first) { return Eigen::Vector3d(first, first + 1, first + 2); }

TEST(JointRows, AreUsedLikeAVectorOfThem) {
  JointRows rows{row_of(1), row_of(4)};
  rows.push_back(row_of(7));
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(JointVector(rows.back()), row_of(7));
  rows[1] = row_of(10);
  for (auto row : rows) row[0] *= 2;
  EXPECT_EQ(rows[0][0], 2);
  EXPECT_EQ(rows[1][0], 20);
  EXPECT_EQ(rows[1][2], 12);
  const auto largest = std::max_element(rows.begin(), rows.end(),
                                        [](const auto& a, const auto& b) { return a[0] < b[0]; });
  EXPECT_EQ(largest - rows.begin(), 1);
  rows.resize(5, row_of(0));
  EXPECT_EQ(JointVector(rows[4]), row_of(0));
  rows.resize(1, row_of(0));
  EXPECT_EQ(rows.size(), 1u);
  rows.clear();
  rows.emplace_back();  // of an arm without joints
  EXPECT_EQ(rows.size(), 1u);
}

TEST(JointRows, HaveOneNumberOfJoints) {
  JointRows rows{row_of(1)};
  EXPECT_THROW(rows.push_back(JointVector::Zero(6)), std::invalid_argument);
}

// Side by side: a vector of JointVectors has room for kMaxJoints in each row.
TEST(JointRows, TakeTheMemoryOfTheirNumbers) {
  const JointRows rows(2, row_of(1));
  EXPECT_EQ(rows[1].data() - rows[0].data(), 3);
}

}  // namespace
}  // namespace armtrue::joint_rows_test
