// The model of a reading against that of a robot, and its derivatives against differences.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "armtrue/effects/sampling.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/observation/observation.h"
#include "armtrue/statistics/random.h"

namespace armtrue::model_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

Effect constant_error(const std::string& parameter, double value) {
  return {parameter, parameter, *parse_driver("position"), Shape{}, {{"c", value}}};
}

// An arm with two reflectors before an instrument that errs.
Robot robot_of_test() {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  robot.instrument = {4, -1, 0.5};
  robot.chain.targets = {{"1", {0.1, 0.2, 0.3}}, {"2", {-0.2, 0.1, 0.15}}};
  robot.chain.anchors = {{"a", {2.5, 1.5, 0.2}, 0.01}, {"b", {2.0, -1.5, 0.4}, -0.02}};
  robot.effects = {constant_error("instrument.scale", 0.05),
                   constant_error("instrument.range", 1e-5),
                   constant_error("instrument.elevation", 2e-5),
                   {"grown", "target 1.y", *parse_driver("payload"), Shape{}, {{"c", 1e-4}}},
                   {"longer", "anchor b.zero", *parse_driver("payload"), Shape{}, {{"c", 2e-4}}},
                   {"pulled", "anchor a.z", *parse_driver("payload"), Shape{}, {{"c", -3e-4}}}};
  return robot;
}

enum class Read { points, poses, distances, mixed };

// Six visits with a payload, two reflectors and two anchors in turn.
Campaign campaign_of_test(const Robot& robot, Read read) {
  Campaign campaign;
  campaign.target_names = {"1", "2"};
  const std::vector<JointVector> poses = sample_joint_space(robot.chain, 6);
  for (int row = 0; row < 6; ++row) {
    campaign.pose.push_back(row);
    campaign.pose_ids.push_back(std::to_string(row));
    campaign.line.push_back(row + 2);
    campaign.q.push_back(poses[static_cast<size_t>(row)]);
    campaign.payload_kg.push_back(2);
    campaign.target.push_back(row % 2);
    if (read != Read::distances) campaign.position.emplace_back(1.5 + 0.1 * row, -0.3, 1.1);
    if (read == Read::poses) {
      const Eigen::Matrix3d turn = rotation_exp({0.4, -0.3, 0.2 + 0.1 * row});
      campaign.orientation.emplace_back(turn *
                                        RobotModel(robot).pose(campaign.context(row)).rotation);
    }
    if (read == Read::distances || read == Read::mixed) {
      campaign.distance.push_back(read == Read::mixed && row % 3 != 0 ? 0 : 1.7);
      campaign.anchor.push_back(row % 4 / 2);
    }
  }
  if (!campaign.distance.empty()) campaign.anchor_names = {"a", "b"};
  if (read == Read::mixed) points_to_coordinates(campaign);
  return campaign;
}

TEST(ObservationModel, PredictsWhatTheModelOfTheRobotDoes) {
  const Robot robot = robot_of_test();
  const RobotModel model(robot);
  for (const Read read : {Read::points, Read::distances, Read::mixed}) {
    const Campaign campaign = campaign_of_test(robot, read);
    const ObservationModel observed(campaign, robot, {}, {1, 1});
    const auto at = observed.at(Eigen::VectorXd::Zero(observed.unknowns()));
    for (int row = 0; row < campaign.rows(); ++row) {
      const auto r = static_cast<size_t>(row);
      const Context context = campaign.context(row);
      const Eigen::Vector3d point = model.point(context, campaign.target[r]);
      Vector6 expected = Vector6::Zero();
      if (campaign.kind(row) == ReadingKind::point)
        expected.head<3>() = campaign.position[r] - point;
      else if (campaign.kind(row) == ReadingKind::coordinate)
        expected[0] = campaign.length(row) - point[campaign.coordinate[r]->axis];
      else
        expected[0] =
            campaign.distance[r] - model.distance(context, campaign.target[r], campaign.anchor[r]);
      EXPECT_LT((at.residual(row) - expected).norm(), 1e-12) << row;
    }
  }
}

// At unknowns away from zero and orientations far from the model's, in an R_A that is turned
// against the instrument's own.
TEST(ObservationModel, DerivativesAreThoseOfTheResiduals) {
  const Robot robot = robot_of_test();
  const ParameterLayout layout = layout_of(robot.chain);
  std::vector<int> parameters;
  for (int k = 0; k < parameter_count(robot.chain); ++k)
    if (layout.has_constant(k)) parameters.push_back(k);
  const Pose common_from_own{rotation_exp({0.3, -0.2, 0.5}), {0.1, 0.2, 0.3}};
  for (const Read read : {Read::points, Read::poses, Read::distances, Read::mixed}) {
    const Campaign campaign = campaign_of_test(robot, read);
    const ReadingSigma sigma{2e-4, 2e-4};
    const ObservationModel model(campaign, robot, parameters, sigma, kAllEffects, common_from_own);
    const int p = model.unknowns(), size = model.row_size();
    Eigen::VectorXd x(p);
    for (int k = 0; k < p; ++k) x[k] = k < model.geometric_count() ? 0.02 * std::sin(k) : 0;
    const auto at = model.at(x);
    Eigen::MatrixXd block(size, p + 1);
    for (int row = 0; row < model.rows(); ++row) {
      at.block(row, block);
      for (int k = 0; k < p; ++k) {
        constexpr double kStep = 1e-6;
        const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(p, k);
        const Vector6 change =
            (model.at(x - step).residual(row) - model.at(x + step).residual(row)) / (2 * kStep);
        // The direction in which the instrument errs turns with the point, by 1e-5 in all.
        EXPECT_LT((block.col(k) * sigma.position - change.head(size)).norm(), 2e-4)
            << model.unknown_names()[static_cast<size_t>(k)] << " of row " << row;
      }
    }
  }
}

// Between two visits of a pose the arm was loaded.
TEST(ObservationModel, AVisitWithAnotherPayloadHasItsOwnTorque) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  robot.effects = {
      {"compliance", "A2.theta", *parse_driver("gravity-torque 2"), Shape{}, {{"c", 1e-7}}}};
  const RobotModel model(robot);
  Campaign campaign;
  campaign.pose_ids = {"P"};
  for (const double payload : {0.0, 200.0}) {
    campaign.pose.push_back(0);
    campaign.line.push_back(2);
    campaign.q.push_back((JointVector(6) << 0.1, -1.2, 0.7, 0.9, 0.4, -0.3).finished());
    campaign.position.push_back(Eigen::Vector3d::Zero());
    campaign.payload_kg.push_back(payload);
  }
  const ObservationModel observed(campaign, robot, {}, {1, 1});
  const auto at = observed.at(Eigen::VectorXd::Zero(observed.unknowns()));
  for (int row = 0; row < 2; ++row)
    EXPECT_LT((at.residual(row).head<3>() + model.pose(campaign.context(row)).translation).norm(),
              1e-12)
        << row;
  EXPECT_GT((at.residual(0) - at.residual(1)).norm(), 1e-4);
}

// Poses that state the covariance L L^T of position and rotation, each of its own size.
struct Stated {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  Campaign campaign;
  std::vector<Matrix6> root;  // L

  explicit Stated(const std::vector<int>& poses) {
    Random random(4);
    for (size_t row = 0; row < poses.size(); ++row) {
      campaign.pose.push_back(poses[row]);
      campaign.line.push_back(2);
      campaign.q.push_back((JointVector(6) << 0.1, -1.2, 0.7, 0.9, 0.4, -0.3).finished());
      campaign.position.push_back(Eigen::Vector3d::Zero());
      campaign.orientation.push_back(Eigen::Quaterniond::Identity());
      Matrix6 any;
      for (double& value : any.reshaped()) value = random.normal();
      any.topRows<3>() *= 1e-4 * static_cast<double>(row + 1);
      any.bottomRows<3>() *= 3e-4 * static_cast<double>(row * row + 1);
      add(any * any.transpose());
    }
    campaign.pose_ids.resize(static_cast<size_t>(poses.back() + 1));
  }

  void add(const Matrix6& covariance) {
    root.push_back(covariance.llt().matrixL());
    campaign.sigma_position.push_back(std::sqrt(covariance.topLeftCorner<3, 3>().trace() / 3));
    campaign.sigma_orientation.push_back(
        std::sqrt(covariance.bottomRightCorner<3, 3>().trace() / 3));
    Vector6 deviations;
    deviations << Eigen::Vector3d::Constant(campaign.sigma_position.back()),
        Eigen::Vector3d::Constant(campaign.sigma_orientation.back());
    campaign.whitening.push_back(root.back().inverse() * deviations.asDiagonal());
  }
};

// The covariance of a row is L diag(k_p^2, k_o^2) L^T with k_p and k_o the factors from what the
// row in the middle states to the sigma of the fit.
TEST(ObservationModel, WhitensByTheStatedCovarianceTimesTheFactorsOfTheFit) {
  const Stated stated({0, 1, 2});
  constexpr double kPosition = 1.7, kOrientation = 0.6;
  const ReadingSigma sigma{kPosition * stated.campaign.sigma_position[1],
                           kOrientation * stated.campaign.sigma_orientation[1]};
  const ObservationModel model(stated.campaign, stated.robot, {}, sigma);
  const Vector6 residual = (Vector6() << 1e-4, -2e-4, 3e-4, 5e-4, -1e-4, 2e-4).finished();
  for (int row = 0; row < 3; ++row) {
    Vector6 expected = stated.root[static_cast<size_t>(row)].inverse() * residual;
    expected.head<3>() /= kPosition;
    expected.tail<3>() /= kOrientation;
    EXPECT_LT((model.whitened(row, residual) - expected).norm(), 1e-9 * expected.norm()) << row;
  }
}

// Two readings of one pose are replicates only if their noise is the same, too.
TEST(ObservationModel, ReadingsWithOtherCovariancesAreNoReplicates) {
  Stated stated({0, 0});
  Campaign& campaign = stated.campaign;
  campaign.sigma_position[1] = campaign.sigma_position[0];
  campaign.sigma_orientation[1] = campaign.sigma_orientation[0];
  const ObservationModel others(campaign, stated.robot, {}, {1e-4, 1e-4});
  EXPECT_FALSE(others.has_replicates());
  campaign.whitening[1] = campaign.whitening[0];
  const ObservationModel alike(campaign, stated.robot, {}, {1e-4, 1e-4});
  EXPECT_TRUE(alike.has_replicates());
}

}  // namespace
}  // namespace armtrue::model_test
