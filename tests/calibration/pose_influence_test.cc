#include "calibration/pose_influence.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <numeric>
#include <vector>

namespace armtrue::pose_influence_test {
namespace {

Eigen::MatrixXd orthonormal(int rows, int columns) {
  std::srand(5);  // of Eigen's Random()
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(Eigen::MatrixXd::Random(rows, columns));
  return qr.householderQ() * Eigen::MatrixXd::Identity(rows, columns);
}

// Independent errors of unit variance leave residuals of covariance 1 - Q Q^T; given back what the
// fit took of them, those of one pose have unit covariance again.
TEST(Unfitted, ResidualsOfAPoseScatterAsTheErrors) {
  constexpr int kRows = 40, kUnknowns = 9;
  const Eigen::MatrixXd basis = orthonormal(kRows, kUnknowns);
  for (int own : {4, 9, 25}) {
    const Eigen::MatrixXd of_pose = basis.topRows(own);
    Eigen::MatrixXd root(own, own);  // it is linear in the residual
    for (int k = 0; k < own; ++k)
      root.col(k) = leverage_corrected_residual(of_pose, Eigen::VectorXd::Unit(own, k));
    const Eigen::MatrixXd left =
        Eigen::MatrixXd::Identity(own, own) - of_pose * of_pose.transpose();
    EXPECT_LT((root * left * root.transpose() - Eigen::MatrixXd::Identity(own, own)).norm(), 1e-10)
        << own << " rows";
  }
}

// Nothing is left in a direction that only this pose shows, and nothing is made up for it.
TEST(Unfitted, WhatOnlyOnePoseShowsStaysZero) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3, 2);
  rows(0, 0) = 1;
  rows(1, 1) = 0.6;
  const Eigen::Vector3d given = leverage_corrected_residual(rows, Eigen::Vector3d(0, 0.8, 2));
  EXPECT_LT((given - Eigen::Vector3d(0, 1, 2)).norm(), 1e-12) << given.transpose();
}

// Poses of many sessions change few unknowns each, some change all; the sums of several blocks,
// joined, are those of all poses.
TEST(InfluenceSums, OfFewUnknownsAreThoseOfAll) {
  constexpr int kUnknowns = 40, kPoses = 30, kBlocks = 3;
  std::srand(6);
  Eigen::MatrixXd changes = Eigen::MatrixXd::Zero(kUnknowns, kPoses);
  Eigen::MatrixXd alone = Eigen::MatrixXd::Zero(kUnknowns, kUnknowns);
  InfluenceSums sums(kUnknowns);
  for (int block = 0; block < kBlocks; ++block) {
    InfluenceSums part;
    for (int pose = block * kPoses / kBlocks; pose < (block + 1) * kPoses / kBlocks; ++pose) {
      const bool changes_all = pose % 7 == 5;
      std::vector<Eigen::Index> own(changes_all ? kUnknowns : 6);
      std::iota(own.begin(), own.end(), changes_all ? 0 : 29 - pose);  // the last unknowns first
      const Eigen::Index count = std::ssize(own);
      const PoseInfluence influence{Eigen::VectorXd::Random(count),
                                    Eigen::MatrixXd::Random(count, pose % 5 == 4 ? 2 : 0)};
      changes(own, pose) = influence.change;
      alone(own, own) += influence.alone * influence.alone.transpose();
      part.add(influence, own, kUnknowns);
    }
    sums.add(part);
  }
  const Eigen::MatrixXd scattered = changes.colwise() - changes.rowwise().mean();
  const Eigen::MatrixXd expected =
      (kPoses - 1.0) / kPoses / (0.8 * 0.8) * scattered * scattered.transpose() + 0.3 * alone;
  EXPECT_LT((sums.covariance(0.8, 0.3) - expected).norm(), 1e-12 * expected.norm());
}

}  // namespace
}  // namespace armtrue::pose_influence_test
