#include "support/path_plant.h"

#include <gtest/gtest.h>

#include <cmath>

namespace plant {
namespace {

class EveryShape : public testing::TestWithParam<Shape> {};
INSTANTIATE_TEST_SUITE_P(Plant, EveryShape,
                         testing::Values(Shape::line, Shape::arc, Shape::corner, Shape::spiral));

TEST_P(EveryShape, RunsAtItsSpeedAndStandsAtBothEnds) {
  const Program path = program(GetParam());
  const Eigen::Index n = path.time.size();
  double fastest = 0;
  for (Eigen::Index i = 1; i < n; ++i)
    fastest = std::max(fastest, (path.position.col(i) - path.position.col(i - 1)).norm() / 0.016);
  EXPECT_NEAR(fastest, 0.027, 1e-5);
  EXPECT_EQ(path.position.col(0), path.position.col(62));
  EXPECT_EQ(path.position.col(n - 1), path.position.col(n - 62));
}

TEST_P(EveryShape, WithoutEffectsTheToolIsWhereItIsTold) {
  const Program path = program(GetParam());
  const Record record = run(path, path.position, ideal());
  EXPECT_LT((record.true_position - path.position).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT(mean_distance(path, record.true_position), 1e-12);
  EXPECT_EQ(record.force.cwiseAbs().maxCoeff(), 0);
  EXPECT_NEAR(static_cast<double>(record.time.size()), path.time[path.time.size() - 1] / 0.032, 1);
}

TEST_P(EveryShape, DeviatesLikeARoughingPass) {
  const Program path = program(GetParam());
  const double deviation = mean_distance(path, run(path, path.position, {}).true_position);
  EXPECT_GT(deviation, 0.5e-3);
  EXPECT_LT(deviation, 1.2e-3);
}

TEST(Plant, CommandingTheOppositeOfTheDeviationRemovesIt) {
  const Program path = program(Shape::line);
  Options options = ideal();
  options.depth = 0.008;
  const Eigen::Matrix3Xd first = run(path, path.position, options).true_position;
  const Eigen::Matrix3Xd again = run(path, 2 * path.position - first, options).true_position;
  EXPECT_GT(mean_distance(path, first), 0.5e-3);
  EXPECT_LT(mean_distance(path, again), 1e-9);
}

TEST(Plant, ClockOffsetAndRateAreThoseOfTheInstrument) {
  const Program path = program(Shape::line);
  Options options = ideal();
  options.clock_offset = 0.7;
  options.clock_rate = 1e-3;
  const Record record = run(path, path.position, options);
  // Half way along x the program is at its middle.
  const double middle = 0.5 * path.time[path.time.size() - 1];
  Eigen::Index i = 0;
  while (record.position(0, i + 1) < 1.65) ++i;
  const double u =
      (1.65 - record.position(0, i)) / (record.position(0, i + 1) - record.position(0, i));
  const double seen = record.time[i] + u * (record.time[i + 1] - record.time[i]);
  EXPECT_NEAR(seen, 0.7 + 1.001 * middle, 0.016);  // the program ends on a whole sample
  EXPECT_NEAR(record.time[1] - record.time[0], 0.032, 1e-12);
}

TEST(Plant, AReversalIsAStepOfItsSize) {
  const Program path = program(Shape::corner);
  Options options = ideal();
  options.axes_angle = 0;
  options.reversal_step = {0.2e-3, 0};
  const Record record = run(path, path.position, options);
  const Eigen::Matrix3Xd error = record.true_position - path.position;
  EXPECT_NEAR(error(0, 0), 0.1e-3, 1e-9);  // came from beyond the start
  EXPECT_NEAR(error(0, error.cols() / 2 - 50), -0.1e-3, 1e-9);
  EXPECT_EQ(error.bottomRows<2>().cwiseAbs().maxCoeff(), 0);
}

TEST(Plant, ASecondPassRepeatsThePartButNotTheNoise) {
  const Program path = program(Shape::arc);
  Options options;
  const Record first = run(path, path.position, options);
  options.pass_seed = 2;
  const Record second = run(path, path.position, options);
  EXPECT_EQ(first.true_position, second.true_position);
  EXPECT_NE(first.position.col(5), second.position.col(5));
  options.repeatability = 0.03e-3;
  const Eigen::Matrix3Xd change =
      run(path, path.position, options).true_position - first.true_position;
  EXPECT_NEAR(std::sqrt(change.array().square().mean()), 0.03e-3, 0.015e-3);
}

}  // namespace
}  // namespace plant
