#include "search/cycle_nodes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "armtrue/statistics/random.h"

namespace armtrue::cycle_nodes_test {
namespace {

// Largest error of products with sines and cosines of many frequencies, against sums of the
// library's own, as a share of the sum of all |vector|.
template <typename Scalar>
double largest_error(double low, double high, double least, double most) {
  Random random(7);
  const Eigen::VectorXd x =
      Eigen::VectorXd::NullaryExpr(400, [&] { return random.uniform(low, high); });
  const Eigen::MatrixXd vectors =
      Eigen::MatrixXd::NullaryExpr(3, x.size(), [&] { return random.normal(); });
  const CycleNodes nodes(x, least, most);
  const auto of_nodes = nodes.products(Eigen::MatrixX<Scalar>(vectors.template cast<Scalar>()));
  double largest = 0;
  for (int k = 0; k <= 500; ++k) {
    const double n = least + k * (most - least) / 500;
    const Eigen::MatrixX2<Scalar> products = CycleNodes::at(nodes.near(n), of_nodes);
    const Eigen::VectorXd phase = n * x;
    const Eigen::VectorXd sines = vectors * phase.unaryExpr([](double t) { return std::sin(t); });
    const Eigen::VectorXd cosines = vectors * phase.unaryExpr([](double t) { return std::cos(t); });
    for (Eigen::Index row = 0; row < vectors.rows(); ++row) {
      const double all = vectors.row(row).cwiseAbs().sum();
      largest = std::max({largest, std::abs(products(row, 0) - sines[row]) / all,
                          std::abs(products(row, 1) - cosines[row]) / all});
    }
  }
  return largest;
}

TEST(CycleNodes, TellCyclesAtEveryFrequency) {
  EXPECT_LT(largest_error<double>(-3.0, 3.1, 0.9, 300.0), 1e-10);  // a joint
  EXPECT_LT(largest_error<double>(1.2, 2.0, 7.5, 300.0), 1e-10);   // a short part of its travel
  EXPECT_LT(largest_error<double>(0.0, 2.5, 0.4, 1250.0), 1e-10);  // a rail
  EXPECT_LT(largest_error<double>(-1.0, 1.0, 40.0, 41.0), 1e-10);  // nearly one frequency
  EXPECT_LT(largest_error<float>(-3.0, 3.1, 0.9, 300.0), 1e-5);
}

TEST(CycleNodes, AreFewerThanTheStepsOfAPeriodogram) {
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(300, -3, 3);
  const double covered = 6 / (2 * 3.14159265358979);  // turns; a step is a quarter of 1 / covered
  EXPECT_LT(CycleNodes(x, 1 / covered, 300).count(), 0.4 * 4 * covered * 300);
}

}  // namespace
}  // namespace armtrue::cycle_nodes_test
