#include "search/cross_validation.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <numeric>
#include <random>
#include <vector>

namespace armtrue::cross_validation_test {
namespace {

constexpr int kPoses = 100, kRowSize = 3, kUnknowns = 6;

// The last column is what may be added; of the first, pose 7 shows nearly all.
Eigen::MatrixXd columns(double shown_by_others) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd columns = Eigen::MatrixXd::NullaryExpr(kPoses * kRowSize, kUnknowns + 1,
                                                         [&] { return normal(random); });
  columns.col(0) *= shown_by_others / columns.col(0).norm();
  columns(7 * kRowSize, 0) = 1;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
}

// Noise of unit variance and `size` along the last column, fitted by the others.
CrossValidation gain(const Eigen::MatrixXd& q, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto basis = q.leftCols(kUnknowns);
  Eigen::VectorXd residual = Eigen::VectorXd::NullaryExpr(q.rows(), [&] { return normal(random); });
  residual += size * q.rightCols<1>();
  residual -= (basis * (basis.transpose() * residual)).eval();
  std::vector<int> pose(kPoses);
  std::iota(pose.begin(), pose.end(), 0);
  return CrossValidation::of(pose, kRowSize, basis, q.rightCols<1>(), residual, seed);
}

TEST(CrossValidation, TellsWhatPredictsFromWhatDoesNot) {
  const Eigen::MatrixXd q = columns(1.0);
  int false_gains = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const CrossValidation strong = gain(q, 8, seed), none = gain(q, 0, seed);
    EXPECT_GT(strong.gain, strong.error) << seed;
    false_gains += none.gain > none.error;
  }
  EXPECT_LE(false_gains, 20);  // a gain beyond its standard error, one side of it
}

// A knot of a curve with one pose by it. Left out, nothing says what the curve does there, and what
// any value does to that pose is no matter of the column that may be added.
TEST(CrossValidation, IsNotDecidedByAPoseThatNoOtherStandsFor) {
  for (double shown_by_others : {1e-2, 1e-4, 1e-6}) {
    const Eigen::MatrixXd q = columns(shown_by_others);
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const CrossValidation strong = gain(q, 8, seed);
      EXPECT_GT(strong.gain, 2 * strong.error) << shown_by_others << ", seed " << seed;
      EXPECT_NEAR(strong.gain, 8.0 * 8 / (kPoses * kRowSize + 8 * 8), 0.1);
    }
  }
}

Eigen::VectorXd differences(int poses, double mean, std::mt19937& random) {
  std::normal_distribution<double> normal(mean, 1);
  return Eigen::VectorXd::NullaryExpr(poses, [&] { return normal(random); });
}

// Two models that predict equally well differ by chance in 1 of 1000 campaigns; of 50 poses the
// tails of Student's t are some 1.6 times as heavy.
TEST(ClearlyBetter, IsSaidByChanceOnceInAThousand) {
  std::mt19937 random(1);
  int said = 0;
  for (int campaign = 0; campaign < 40000; ++campaign)
    said += is_clearly_better(differences(50, 0, random));
  EXPECT_GE(said, 20);
  EXPECT_LE(said, 100);
}

TEST(ClearlyBetter, IsSaidWhereAllPosesGainALittleButNotWhereFewMakeTheSum) {
  std::mt19937 random(2);
  const Eigen::VectorXd all = differences(50, 1, random);
  EXPECT_TRUE(is_clearly_better(all));
  EXPECT_FALSE(is_clearly_better(-all));
  Eigen::VectorXd few = differences(50, 0, random);
  few.head(3).setConstant(40);
  EXPECT_GT(few.sum(), 2 * all.sum());
  EXPECT_FALSE(is_clearly_better(few));
}

}  // namespace
}  // namespace armtrue::cross_validation_test
