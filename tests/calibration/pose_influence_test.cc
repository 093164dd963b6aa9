#include "calibration/pose_influence.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <numeric>
#include <vector>

#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "linear_algebra/decompositions.h"

namespace armtrue::pose_influence_test {
namespace {

Eigen::MatrixXd orthonormal(int rows, int columns) {
  std::srand(5);  // of Eigen's Random()
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(Eigen::MatrixXd::Random(rows, columns));
  return first_columns(qr.householderQ(), columns);
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

// Where a pose shows little the inverse is a series; two terms are exact to the square of the
// leverage.
TEST(PoseInfluence, OfASmallLeverageIsThatOfTheInverse) {
  std::srand(7);
  for (const double size : {0.16, 0.18, 0.5}) {  // sqrt(0.03) = 0.173
    Eigen::MatrixXd rows = Eigen::MatrixXd::Random(3, 5);
    rows *= size / rows.norm();
    const Eigen::Vector3d residual(1, -2, 0.5);
    const Eigen::VectorXd expected =
        rows.transpose() * Eigen::MatrixXd(identity(3) - rows * rows.transpose())
                               .ldlt()
                               .solve(Eigen::VectorXd(residual));
    EXPECT_LT((influence_of_pose(rows, residual).change - expected).norm(), 1e-3 * expected.norm())
        << size;
  }
}

// Replicates as one row move the fit as all of them do.
TEST(PoseInfluence, OfReplicatesIsThatOfTheirReadings) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  SimulationOptions options{
      .poses = 12, .repeats = 6, .noise_position = 1e-4, .noise_orientation = 2e-4};
  Campaign campaign = simulate(robot, robot, options);
  for (const int row : {0, 12, 25}) campaign.q[static_cast<size_t>(row)][1] += 0.01;
  const SessionModels models(campaign, robot, {6, 7, 9, 13, 15, 19, 21}, {1e-4, 2e-4});
  const SessionModels::At at = models.at(Eigen::VectorXd::Zero(models.unknowns()));
  const int p = models.unknowns(), size = models.row_size();
  std::vector<double> weights;
  Eigen::MatrixXd all = models.blocks();
  for (int row = 0; row < models.rows(); ++row) {
    weights.push_back(row % 5 == 0 ? 0.2 : 1 + 0.01 * row);
    all.middleRows(row * size, size) *= std::sqrt(weights.back());
  }
  const Eigen::MatrixXd root = inverse_root(all.leftCols(p).transpose() * all.leftCols(p));
  const GroupedRows rows = grouped_rows(campaign.pose);
  for (int pose = 0; pose < rows.groups(); ++pose) {
    Eigen::MatrixXd apart(std::ssize(rows.rows(pose)) * size, p + 1);
    Eigen::Index top = 0;
    for (int row : rows.rows(pose)) {
      apart.middleRows(top, size) = all.middleRows(row * size, size);
      top += size;
    }
    const Eigen::MatrixXd merged = weighted_rows(at, weights, rows.rows(pose));
    EXPECT_LT(merged.rows(), apart.rows());
    const Eigen::VectorXd of_apart =
        influence_of_pose(apart.leftCols(p) * root, apart.col(p)).change;
    const Eigen::VectorXd of_merged =
        influence_of_pose(merged.leftCols(p) * root, merged.col(p)).change;
    EXPECT_LT((of_merged - of_apart).norm(), 1e-9 * of_apart.norm()) << pose;
  }
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

// The divergence of psi by differences, over the number of dimensions.
TEST(MeanPsiDerivative, IsThatOfDifferences) {
  constexpr double kFreedom = 4, kStep = 1e-5;
  for (const int dimension : {3, 6}) {
    const auto weight = [&](const Eigen::VectorXd& r) {
      return (kFreedom + dimension) / (kFreedom + r.squaredNorm());
    };
    std::vector<double> weights;
    double slopes = 0, sum = 0;
    for (const double size : {0.1, 0.8, 2.0, 7.0}) {
      const Eigen::VectorXd r = size * Eigen::VectorXd::Ones(dimension);
      for (int k = 0; k < dimension; ++k) {
        const Eigen::VectorXd more = r + kStep * Eigen::VectorXd::Unit(dimension, k);
        const Eigen::VectorXd less = r - kStep * Eigen::VectorXd::Unit(dimension, k);
        slopes += (weight(more) * more[k] - weight(less) * less[k]) / (2 * kStep) / dimension;
      }
      weights.push_back(weight(r));
      sum += weights.back();
    }
    EXPECT_NEAR(mean_psi_derivative(weights, kFreedom, dimension), slopes / sum, 1e-8);
    EXPECT_EQ(mean_psi_derivative(weights, 0, dimension), 1) << "Gaussian";
  }
}

}  // namespace
}  // namespace armtrue::pose_influence_test
