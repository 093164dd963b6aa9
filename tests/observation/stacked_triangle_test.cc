#include "linear_algebra/stacked_triangle.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <random>

namespace armtrue {
namespace {

Eigen::MatrixXd random_rows(int rows, int columns, std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd all(rows, columns);
  for (double& number : all.reshaped()) number = normal(random);
  return all;
}

// With a diagonal that is not negative.
Eigen::MatrixXd with_signs(Eigen::MatrixXd triangle) {
  for (Eigen::Index i = 0; i < triangle.rows(); ++i)
    if (triangle(i, i) < 0) triangle.row(i) *= -1;
  return triangle;
}

Eigen::MatrixXd triangle_of(const Eigen::MatrixXd& rows) {
  const Eigen::MatrixXd r = Eigen::HouseholderQR<Eigen::MatrixXd>(rows).matrixQR();
  return with_signs(r.topRows(rows.cols()).triangularView<Eigen::Upper>());
}

// Columns that do and do not fill the groups of reflections, rows that do and do not fill lanes.
TEST(StackedTriangle, IsThatOfAllRows) {
  std::mt19937 random(1);
  for (const int columns : {1, 3, 4, 6, 13, 31})
    for (const int rows : {1, 5, 64, 203}) {
      const Eigen::MatrixXd first = random_rows(columns + 9, columns, random);
      const Eigen::MatrixXd second = random_rows(rows, columns, random);
      Eigen::MatrixXd all(first.rows() + rows, columns);
      all << first, second;
      Eigen::MatrixXd triangle = Eigen::MatrixXd::Zero(columns, columns);
      for (Eigen::MatrixXd block : {first, second}) fold_rows(triangle, block);
      EXPECT_TRUE(triangle.isUpperTriangular(0));
      EXPECT_LT((with_signs(triangle) - triangle_of(all)).norm(), 1e-12 * all.norm())
          << rows << " rows, " << columns << " columns";
    }
}

// Their products have lost the last column: its part of its own is 1e-9 of it.
TEST(StackedTriangle, KeepsWhatNearlyDependentColumnsHaveOfTheirOwn) {
  std::mt19937 random(2);
  Eigen::MatrixXd rows = random_rows(300, 6, random);
  rows.col(5) = rows.leftCols(5).rowwise().sum() + 1e-9 * rows.col(5);
  Eigen::MatrixXd triangle = Eigen::MatrixXd::Zero(6, 6);
  for (int first = 0; first < 300; first += 100) {
    Eigen::MatrixXd block = rows.middleRows(first, 100);
    fold_rows(triangle, block);
  }
  const double expected = triangle_of(rows)(5, 5);
  EXPECT_NEAR(std::abs(triangle(5, 5)), expected, 1e-5 * expected);
}

TEST(StackedTriangle, LeavesZerosZero) {
  Eigen::MatrixXd triangle = Eigen::MatrixXd::Zero(5, 5), rows = Eigen::MatrixXd::Zero(9, 5);
  rows.col(2).setConstant(-2);
  fold_rows(triangle, rows);
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(5, 5);
  expected(2, 2) = 6;
  EXPECT_LT((with_signs(triangle) - expected).norm(), 1e-14);
}

}  // namespace
}  // namespace armtrue
