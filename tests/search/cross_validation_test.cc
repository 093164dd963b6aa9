#include "search/cross_validation.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "linear_algebra/decompositions.h"

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
  return first_columns(qr.householderQ(), columns.cols());
}

// Noise of unit variance and `size` along the last column, fitted by the others.
Linearization noisy_fit(const Eigen::MatrixXd& q, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  LinearProblem problem;
  problem.pose.resize(kPoses);
  std::iota(problem.pose.begin(), problem.pose.end(), 0);
  problem.row_size = kRowSize;
  problem.fitted = q.leftCols(kUnknowns);
  problem.geometric = kUnknowns;
  problem.readings = Eigen::VectorXd::NullaryExpr(q.rows(), [&] { return normal(random); });
  problem.readings += size * q.rightCols<1>();
  return Linearization(std::move(problem));
}

GainLeftOut gain(const Eigen::MatrixXd& q, double size, unsigned seed) {
  const Linearization fit = noisy_fit(q, size, seed);
  return CrossValidation(fit, seed).of({q.rightCols<1>(), {}});
}

TEST(CrossValidation, TellsWhatPredictsFromWhatDoesNot) {
  const Eigen::MatrixXd q = columns(1.0);
  int false_gains = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const GainLeftOut strong = gain(q, 8, seed), none = gain(q, 0, seed);
    EXPECT_GT(strong.gain, strong.error) << seed;
    false_gains += none.gain > none.error;
  }
  EXPECT_LE(false_gains, 20);  // a gain beyond its standard error, one side of it
}

// The coefficient of a column that is ten times as long has a tenth of the standard deviation.
TEST(Linearization, StandardDeviationIsThatOfTheColumnsCoefficient) {
  const Eigen::MatrixXd q = columns(1.0);
  const Linearization fit = noisy_fit(q, 0, 1);
  const double unit = fit.standard_deviation(q.rightCols<1>());
  EXPECT_NEAR(unit, 1, 0.3);  // noise of unit variance, a column of unit length
  EXPECT_NEAR(fit.standard_deviation(10 * q.rightCols<1>()), unit / 10, 1e-9);
}

// A knot of a curve with one pose by it. Left out, nothing says what the curve does there, and what
// any value does to that pose is no matter of the column that may be added.
TEST(CrossValidation, IsNotDecidedByAPoseThatNoOtherStandsFor) {
  for (double shown_by_others : {1e-2, 1e-4, 1e-6}) {
    const Eigen::MatrixXd q = columns(shown_by_others);
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const GainLeftOut strong = gain(q, 8, seed);
      EXPECT_GT(strong.gain, 2 * strong.error) << shown_by_others << ", seed " << seed;
      EXPECT_NEAR(strong.gain, 8.0 * 8 / (kPoses * kRowSize + 8 * 8), 0.1);
    }
  }
}

// The same by its definition: each pose is predicted from the equations of the others, by
// least squares with the ridge, with and without the last columns.
GainLeftOut by_definition(const Eigen::MatrixXd& columns, Eigen::Index added,
                          const Eigen::VectorXd& readings) {
  constexpr double kRidge = 0.01;
  const Eigen::Index poses = readings.size() / kRowSize;
  Eigen::VectorXd gains(poses);
  double before = 0;
  for (Eigen::Index pose = 0; pose < poses; ++pose) {
    const auto squares = [&](Eigen::Index count) {
      Eigen::MatrixXd others = columns.leftCols(count);
      others.middleRows(pose * kRowSize, kRowSize).setZero();
      Eigen::MatrixXd normal = others.transpose() * others;
      normal.diagonal().array() += kRidge;
      const Eigen::VectorXd x = normal.ldlt().solve(others.transpose() * readings);
      return (readings - columns.leftCols(count) * x)
          .segment(pose * kRowSize, kRowSize)
          .squaredNorm();
    };
    const double without = squares(columns.cols() - added);
    before += without;
    gains[pose] = without - squares(columns.cols());
  }
  const double mean = gains.mean(), n = static_cast<double>(poses);
  const double deviation = std::sqrt((gains.array() - mean).square().sum() / (n - 1));
  return {mean / (before / n), deviation / std::sqrt(n) / (before / n)};
}

// Ten poses are left out one by one, whatever the order.
TEST(CrossValidation, IsThatOfTheOtherPosesByDefinition) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  LinearProblem problem;
  problem.pose.resize(10);
  std::iota(problem.pose.begin(), problem.pose.end(), 0);
  problem.row_size = kRowSize;
  const Eigen::MatrixXd all =
      Eigen::MatrixXd::NullaryExpr(10 * kRowSize, 9, [&] { return normal(random); });
  problem.fitted = all.leftCols(7);  // five parameters, an effect with two coefficients
  problem.geometric = 5;
  problem.coefficients_of_effect = {{0, 0}};
  problem.readings = Eigen::VectorXd::NullaryExpr(all.rows(), [&] { return 2 * normal(random); });
  problem.readings += all.col(6) + all.col(8);
  const Linearization fit(problem);
  const Eigen::MatrixXd q =
      first_columns(Eigen::HouseholderQR<Eigen::MatrixXd>(all).householderQ(), all.cols());
  const CrossValidation left_out(fit, 1);

  const GainLeftOut of_columns = left_out.of({q.rightCols(2), {}});
  const GainLeftOut columns = by_definition(q, 2, fit.residual());
  EXPECT_NEAR(of_columns.gain, columns.gain, 1e-10);
  EXPECT_NEAR(of_columns.error, columns.error, 1e-10);

  const GainLeftOut of_effect = left_out.of_effect(0);
  const Eigen::MatrixXd effect = q.middleCols(5, 2);
  const GainLeftOut expected = by_definition(
      q.leftCols(7), 2, fit.residual() + effect * (effect.transpose() * problem.readings));
  EXPECT_NEAR(of_effect.gain, expected.gain, 1e-10);
  EXPECT_NEAR(of_effect.error, expected.error, 1e-10);
}

}  // namespace
}  // namespace armtrue::cross_validation_test
