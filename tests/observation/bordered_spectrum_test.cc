#include "linear_algebra/bordered_spectrum.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numeric>
#include <random>

namespace armtrue::bordered_spectrum_test {
namespace {

constexpr int kBlocks = 40, kBorder = 7;

// Blocks of one to six rows, the border in the middle, rows of very different units.
struct Bordered {
  std::vector<std::vector<Eigen::Index>> blocks;
  Eigen::MatrixXd matrix;

  explicit Bordered(unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::vector<Eigen::Index> border(kBorder);
    std::iota(border.begin(), border.end(), Eigen::Index{30});
    Eigen::Index size = 0;
    for (int b = 0; b < kBlocks; ++b) {
      std::vector<Eigen::Index>& own = blocks.emplace_back();
      for (int k = 0; k < 1 + b % 6; ++k) {
        if (size == border.front()) size += kBorder;
        own.push_back(size++);
      }
    }
    Eigen::VectorXd unit(size);
    for (double& one : unit) one = std::pow(10, 0.6 * normal(random));
    matrix = Eigen::MatrixXd::Zero(size, size);
    for (const std::vector<Eigen::Index>& own : blocks) {
      std::vector<Eigen::Index> all = own;
      all.insert(all.end(), border.begin(), border.end());
      const Eigen::MatrixXd rows =
          Eigen::MatrixXd::NullaryExpr(20, std::ssize(all), [&] { return normal(random); }) *
          unit(all).asDiagonal();
      matrix(all, all) += rows.transpose() * rows;
    }
  }
};

TEST(BorderedSpectrum, IsThatOfTheWholeMatrix) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const Bordered bordered(seed);
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(bordered.matrix).eigenvalues();
    const auto spectrum = bordered_spectrum(bordered.matrix, bordered.blocks, 1e-15);
    ASSERT_TRUE(spectrum);
    const double largest = values.tail(1)[0];
    EXPECT_NEAR(spectrum->largest, largest, 1e-12 * largest);
    EXPECT_NEAR(spectrum->smallest, values[0], 1e-8 * values[0]);
    EXPECT_NEAR(spectrum->mean_log, values.array().log().mean(), 1e-9);
    const double sum = values.array().rsqrt().sum();
    EXPECT_NEAR(spectrum->sum_of_inverse_roots, sum, 1e-7 * sum);
  }
}

TEST(BorderedSpectrum, IsNothingOfMatricesThatAreHardlyDefinite) {
  Bordered bordered(4);
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(bordered.matrix).eigenvalues();
  const double share = values[0] / values.tail(1)[0];
  EXPECT_TRUE(bordered_spectrum(bordered.matrix, bordered.blocks, 0.9 * share));
  EXPECT_FALSE(bordered_spectrum(bordered.matrix, bordered.blocks, 1.1 * share));
  bordered.matrix.diagonal().array() -= 2 * values[0];
  EXPECT_FALSE(bordered_spectrum(bordered.matrix, bordered.blocks, 1e-15));
}

}  // namespace
}  // namespace armtrue::bordered_spectrum_test
