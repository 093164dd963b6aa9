// The values of a design by groups against those of dense matrices of all unknowns.

#include "planning/information.h"

#include <gtest/gtest.h>

#include <cmath>

#include "armtrue/calibration/identifiability.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/planning/pose_cloud.h"
#include "linear_algebra/decompositions.h"
#include "planning/choose_by_exchange.h"

namespace armtrue::information_test {
namespace {

constexpr int kPoses = 9;
constexpr double kPlace = 0.1;  // m

Robot with_targets(int count) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  for (int k = 0; k < count; ++k)
    robot.chain.targets.push_back(
        {std::to_string(k),
         kPlace * Eigen::Vector3d(std::sin(k), std::cos(2 * k), std::sin(3 * k + 1))});
  return robot;
}

// What some poses read of all targets.
struct Problem {
  explicit Problem(int targets) : cloud(pose_cloud(with_targets(targets), {})) {
    poses.assign(cloud.poses.begin(), cloud.poses.begin() + kPoses);
    campaign = readings(cloud, poses);
  }

  Eigen::MatrixXd rows() const {  // by all unknowns, those of a pose together
    const Eigen::MatrixXd all =
        SessionModels(campaign, cloud.robot, cloud.unknowns, cloud.noise).blocks();
    return all.leftCols(all.cols() - 1);
  }

  PoseCloud cloud;
  std::vector<PlannedPose> poses;
  Campaign campaign;
};

// The rows of all groups by the own unknowns of each, then by the common ones.
Eigen::MatrixXd dense(const GroupedDerivatives& derivatives) {
  const Eigen::Index common = derivatives.groups.front().common.cols();
  Eigen::Index rows = 0, own = 0;
  for (const GroupRows& group : derivatives.groups) {
    rows += group.own.rows();
    own += group.own.cols();
  }
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(rows, own + common);
  rows = own = 0;
  for (const GroupRows& group : derivatives.groups) {
    all.block(rows, own, group.own.rows(), group.own.cols()) = group.own;
    all.bottomRightCorner(all.rows() - rows, common).topRows(group.own.rows()) = group.common;
    rows += group.own.rows();
    own += group.own.cols();
  }
  return all;
}

void expect_values_of_dense_matrices(int targets) {
  const Problem problem(targets);
  const SessionModels models(problem.campaign, problem.cloud.robot, problem.cloud.unknowns,
                             problem.cloud.noise, kAllEffects, SessionModels::Split::by_target);
  const UnknownGroups groups(models);
  EXPECT_EQ(groups.groups(), targets > 10 ? static_cast<size_t>(targets) : 1u);

  const Scaling scaling(groups.triangles(models), 1);
  GroupedDerivatives candidates = groups.derivatives(models), aim = groups.triangles(models);
  scaling.apply(candidates);
  GroupedDerivatives none = aim;
  for (GroupRows& group : none.groups) group = {0 * group.own, 0 * group.common};
  for (GroupRows& group : aim.groups) group.common *= 3;  // another weight of some unknowns
  const Eigen::MatrixXd dense_aim = dense(aim);
  scaling.apply(aim);

  // The same by matrices of all unknowns, scaled by one triangle: that of the groups, but for signs.
  std::vector<int> order;  // own unknowns of each group, then the common ones
  for (size_t g = 0; g < groups.groups(); ++g)
    order.insert(order.end(), groups.own(g).begin(), groups.own(g).end());
  order.insert(order.end(), groups.common().begin(), groups.common().end());
  const Eigen::MatrixXd rows = problem.rows()(Eigen::all, order);
  const Eigen::Index p = rows.cols(), of_pose = rows.rows() / kPoses;
  const Eigen::MatrixXd triangle = upper_triangle(rows);
  const Eigen::MatrixXd whole = divided_by(rows, triangle).transpose();
  const Eigen::MatrixXd aimed = divided_by(dense_aim, triangle);
  const auto information = [&](std::initializer_list<int> chosen) {
    Eigen::MatrixXd sum = kKnownFromStart * Eigen::MatrixXd::Identity(p, p);
    for (int pose : chosen) {
      const auto block = whole.middleCols(pose * of_pose, of_pose);
      sum += block * block.transpose();
    }
    return sum;
  };
  const auto log_det = [](const Eigen::MatrixXd& m) {
    return 2 * Eigen::LLT<Eigen::MatrixXd>(m).matrixLLT().diagonal().array().log().sum();
  };
  const auto variance = [&](const Eigen::MatrixXd& m) {
    return Eigen::LLT<Eigen::MatrixXd>(m).solve(aimed.transpose() * aimed).trace();
  };

  Information determinant(candidates, kPoses, none, {}), trace(candidates, kPoses, none, aim);
  for (int chosen : {0, 1, 2, 3, 4, 5}) {
    determinant.set_chosen(chosen, true);
    trace.set_chosen(chosen, true);
  }
  determinant.set_chosen(1, false);
  trace.set_chosen(1, false);
  const Eigen::VectorXd gains = determinant.values_of_adding(), falls = trace.values_of_adding();
  const Eigen::MatrixXd before = information({0, 2, 3, 4, 5}), after = information({0, 2, 3, 4, 5, 7});
  EXPECT_NEAR(gains[7], log_det(after) - log_det(before), 1e-6 * gains[7]);
  EXPECT_NEAR(falls[7], variance(before) - variance(after), 1e-6 * falls[7]);
}

TEST(Information, OfOneGroupIsThatOfDenseMatrices) { expect_values_of_dense_matrices(1); }
TEST(Information, OfManyTargetsIsThatOfDenseMatrices) { expect_values_of_dense_matrices(20); }

}  // namespace
}  // namespace armtrue::information_test
