#include "calibration/pose_influence.h"

#include <gtest/gtest.h>

#include <Eigen/QR>

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

}  // namespace
}  // namespace armtrue::pose_influence_test
