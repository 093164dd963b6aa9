// Each pose against the definition: its error given those of the poses before it, by the joint
// normal law of all errors.

#include "calibration/pose_after_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <random>
#include <vector>

namespace armtrue {
namespace {

constexpr int kUnknowns = 12;
constexpr double kNoise = 0.4, kGross = 30;

std::vector<PoseError> random_poses(int count, int axes) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto draw = [&](Eigen::Index rows, Eigen::Index columns) {
    return Eigen::MatrixXd(
        Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); }));
  };
  const Eigen::VectorXd truth = draw(kUnknowns, 1);
  std::vector<PoseError> poses;
  for (int k = 0; k < count; ++k) {
    PoseError& pose = poses.emplace_back();
    pose.readings = 1 + k % 3;
    pose.moved = draw(axes, kUnknowns);
    pose.residual = pose.moved * truth + kNoise * draw(axes, 1);
    if (k % 17 == 11) pose.residual[0] += 20;
    pose.moved *= pose.readings;
    pose.residual *= pose.readings;
  }
  return poses;
}

// With the covariance M M^T + noise^2 I of the errors of all poses.
std::vector<double> squares_by_definition(const std::vector<PoseError>& poses) {
  const Eigen::Index axes = poses.front().residual.size();
  Eigen::MatrixXd moved(std::ssize(poses) * axes, kUnknowns);
  Eigen::VectorXd errors(moved.rows());
  for (size_t k = 0; k < poses.size(); ++k) {
    moved.middleRows(static_cast<Eigen::Index>(k) * axes, axes) =
        poses[k].moved / poses[k].readings;
    errors.segment(static_cast<Eigen::Index>(k) * axes, axes) =
        poses[k].residual / poses[k].readings;
  }
  Eigen::MatrixXd covariance = moved * moved.transpose();
  covariance.diagonal().array() += kNoise * kNoise;
  std::vector<double> squares;
  std::vector<Eigen::Index> before;
  for (Eigen::Index own = 0; own < moved.rows(); own += axes) {
    std::vector<Eigen::Index> rows;
    for (Eigen::Index axis = 0; axis < axes; ++axis) rows.push_back(own + axis);
    Eigen::VectorXd error = errors(rows);
    Eigen::MatrixXd variance = covariance(rows, rows);
    if (!before.empty()) {
      const Eigen::MatrixXd with = covariance(rows, before);
      const Eigen::LDLT<Eigen::MatrixXd> known{Eigen::MatrixXd(covariance(before, before))};
      error -= with * known.solve(Eigen::VectorXd(errors(before)));
      variance -= with * known.solve(Eigen::MatrixXd(with.transpose()));
    }
    squares.push_back(error.dot(variance.ldlt().solve(error)));
    if (squares.back() <= kGross) before.insert(before.end(), rows.begin(), rows.end());
  }
  return squares;
}

TEST(PoseAfterPose, GivesTheErrorOfEachGivenThoseBeforeIt) {
  for (int axes : {1, 3}) {
    const std::vector<PoseError> poses = random_poses(90, axes);
    const std::vector<double> expected = squares_by_definition(poses);
    EXPECT_GE(std::ranges::count_if(expected, [](double s) { return s > kGross; }), 3);
    for (size_t at_once : {1, 7, 32, 90}) {
      PoseAfterPose judged(kUnknowns, kNoise);
      std::vector<double> squares;
      for (size_t first = 0; first < poses.size(); first += at_once) {
        const auto last = std::min(poses.size(), first + at_once);
        const std::vector<double> some =
            judged.squares_of({poses.begin() + static_cast<std::ptrdiff_t>(first),
                               poses.begin() + static_cast<std::ptrdiff_t>(last)},
                              kGross);
        squares.insert(squares.end(), some.begin(), some.end());
      }
      ASSERT_EQ(squares.size(), expected.size());
      for (size_t k = 0; k < squares.size(); ++k)
        EXPECT_NEAR(squares[k], expected[k], 1e-9 * (1 + expected[k])) << k << ", " << at_once;
    }
  }
}

}  // namespace
}  // namespace armtrue
