// Uncertainties and bounds against closed forms.

#include "armtrue/calibration/prediction.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/random.h"
#include "calibration/covariance.h"
#include "calibration/prior.h"

namespace armtrue::prediction_test {
namespace {

Robot spindle() { return read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot; }

constexpr double kBase = 1e-4, kReading = 2e-4;
constexpr int kPoses = 8;  // of the calibration

// An arm whose base alone is uncertain, alike along x, y and z.
Robot with_uncertain_base(double tail = 1) {
  Robot robot = spindle();
  robot.uncertainty = Uncertainty{.parameters = {"base.x", "base.y", "base.z"},
                                  .root = kBase * Eigen::Matrix3d::Identity(),
                                  .reading = {.position = kReading},
                                  .tail = tail,
                                  .largest_variance = 6 * kBase * kBase,
                                  .poses = kPoses};
  return robot;
}

Campaign points(const Robot& robot, int poses) {
  SimulationOptions options;
  options.poses = poses;
  options.orientation = false;
  return simulate(robot, robot, options);
}

// All three axes alike: |error|^2 / (3 (b^2 + tail^2 r^2)) is F with 3 degrees of freedom and those
// of the sum: 7 of the base, from the scatter of poses, 21 of the reading (Satterthwaite).
TEST(Prediction, OfABaseThatIsUncertainAlike) {
  constexpr double kTail = 1.5;
  const Robot robot = with_uncertain_base(kTail);
  const double of_base = 3 * kBase * kBase, of_reading = 3 * std::pow(kTail * kReading, 2);
  const double sum = of_base + of_reading;
  const double freedom =
      sum * sum / (of_base * of_base / (kPoses - 1) + of_reading * of_reading / (3 * (kPoses - 1)));
  const double bound = std::sqrt(sum * fisher_f_quantile(0.95, 3, freedom));
  for (const Prediction& one : predict(robot, points(spindle(), 5))) {
    EXPECT_NEAR(one.deviation, std::sqrt(of_base + 3 * kReading * kReading), 1e-12);
    EXPECT_NEAR(one.bound_95, bound, 1e-9);
    EXPECT_NEAR(one.leverage, 0.5, 1e-9);
  }
}

// The squares of the errors over the variance, |e|^2 / r^2 = 30, lie beyond 3 F_0.95(3, 6) = 14.3:
// three poses of three, 0.05^3.
TEST(Prediction, ErrorsAreJudgedByThePosesThatTellTheirScatter) {
  Robot robot = spindle();
  robot.uncertainty = Uncertainty{.parameters = {"base.x"},
                                  .root = Eigen::MatrixXd::Constant(1, 1, 1e-9),
                                  .reading = {.position = kReading},
                                  .poses = 3};
  Campaign campaign = points(robot, 3);
  for (Eigen::Vector3d& position : campaign.position)
    position += std::sqrt(10.0) * kReading * Eigen::Vector3d(1, -1, 1);
  EXPECT_NEAR(p_of_errors(robot, campaign), std::pow(0.05, 3), 1e-9);
}

// The base takes up what d of link 2 moves in the mean: with m the mean motion of the readings by
// d, cov = [s^2 m m^T + r^2 / n, -s^2 m; -s^2 m^T, s^2].
TEST(Prediction, ABaseFittedAgainMakesUpForTheOthers) {
  constexpr double kDeviation = 3e-4;
  Robot robot = spindle();
  robot.uncertainty = Uncertainty{.parameters = {"A2.d"},
                                  .root = Eigen::MatrixXd::Constant(1, 1, kDeviation),
                                  .reading = {.position = kReading},
                                  .poses = kPoses};
  const Campaign campaign = points(robot, 5);
  Robot more = robot, less = robot;
  constexpr double kStep = 1e-5;
  const int parameter = *find_parameter(robot.chain, "A2.d");
  move_parameter(more.chain, parameter, kStep);
  move_parameter(less.chain, parameter, -kStep);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int row = 0; row < 5; ++row)
    mean += (RobotModel(more).pose(campaign.context(row)).translation -
             RobotModel(less).pose(campaign.context(row)).translation) /
            (2 * kStep) / 5;
  const Uncertainty found = after_refit(
      robot, campaign, {kFirstBaseParameter, kFirstBaseParameter + 1, kFirstBaseParameter + 2});
  EXPECT_EQ(found.parameters, (std::vector<std::string>{"base.x", "base.y", "base.z", "A2.d"}));
  Eigen::Vector4d moved;
  moved << -mean, 1;
  Eigen::Matrix4d expected = kDeviation * kDeviation * moved * moved.transpose();
  expected.topLeftCorner<3, 3>() += kReading * kReading / 5 * Eigen::Matrix3d::Identity();
  EXPECT_LT((found.root * found.root.transpose() - expected).norm(), 1e-6 * expected.norm());
  EXPECT_GT(mean.norm(), 0.1);
}

Campaign noisy(const Robot& robot, int poses, int repeats, unsigned seed) {
  SimulationOptions options;
  options.poses = poses;
  options.repeats = repeats;
  options.orientation = false;
  options.noise_position = 1e-4;
  options.seed = seed;
  return simulate(robot, robot, options);
}

// Of few poses that were read often the unknowns take a part of the scatter between poses alone.
TEST(Prediction, TheDeviationOfAReadingIsThatOfItsNoise) {
  const Robot robot = spindle();
  double variance = 0;
  constexpr int kCampaigns = 10;
  for (unsigned seed = 1; seed <= kCampaigns; ++seed) {
    const Campaign campaign = noisy(robot, 15, 5, seed);
    const double deviation = uncertainty_of(calibrate(robot, campaign), campaign).reading.position;
    variance += deviation * deviation / kCampaigns;
  }
  EXPECT_NEAR(variance, 1e-8, 0.1e-8);
}

// Readings state what they are, some eight times the others: the model lacks nothing, and the
// uncertainty is that of the information, widened at most by the scatter about the model.
TEST(Prediction, OfACompleteModelIsThatOfTheInformation) {
  const Robot robot = spindle();
  Campaign campaign = noisy(robot, 60, 1, 1);
  Random random(3);
  for (int row = 0; row < campaign.rows(); ++row) {
    const double sigma = row % 4 == 0 ? 8e-4 : 1e-4;
    campaign.sigma_position.push_back(sigma);
    if (row % 4 == 0) campaign.position[static_cast<size_t>(row)] += 8e-4 * random.normal3();
  }
  const CalibrationResult fit = calibrate(robot, campaign);
  const Eigen::MatrixXd root = uncertainty_if_complete(fit, campaign).uncertainty.root;
  const double expected = (fit.inverse_root * fit.inverse_root.transpose()).trace();
  // Student's sigma lies some way below the scatter; the RMS of what the rows state is four times
  // their median, which would count sixteen times.
  const double times = (root * root.transpose()).trace() / expected;
  EXPECT_GE(times, 1 - 1e-9);
  EXPECT_LT(times, 2);
}

// Bell and McCaffrey 2002: (t_0.975(n) / t_0.975(poses - 1))^2, and poses / (poses - 1) for the
// mean of the poses.
TEST(SingleNumbers, WidenByTheDegreesOfFreedomOfWhatIsEstimated) {
  constexpr int kReadings = 12;
  Robot robot = spindle();
  robot.chain.anchors = {{"wire", {2.5, 1.5, 0.2}}};
  SimulationOptions options;
  options.poses = kReadings;
  options.orientation = false;
  const Campaign campaign = simulate(robot, robot, options);
  ASSERT_EQ(campaign.rows(), kReadings);
  const SessionModels models(campaign, robot, {0, 1, 7, 12}, {1e-4, 1e-4});
  ASSERT_EQ(models.row_size(), 1);
  Priors priors;
  priors.widths = {{"lengths", 3e-4, 0.5, 3e-4}, {"angles", 3e-4, 0.4, 3e-4}};
  priors.of_unknowns = {{0, 1e-3}, {1, 3e-4, 0, 0}, {2, 3e-4, 0, 0}, {3, 3e-4, 0, 1}};
  const Eigen::Vector4d share(1, 0.6, 0.9, 0.2);
  const auto single = single_numbers(models, priors, share, 5.2);
  ASSERT_TRUE(single);
  const auto widening = [](double n) {
    return std::pow(student_t_975(n) / student_t_975(kReadings - 1), 2);
  };
  EXPECT_NEAR(single->of_readings, widening(5) * kReadings / (kReadings - 1), 1e-9);
  ASSERT_EQ(single->of_priors.size(), 4u);
  EXPECT_EQ(single->of_priors[0], 1);
  // 0.6 + 0.9 + 1 / (2 0.25) = 3.5, 0.2 + 1 / (2 0.16) = 3.325
  EXPECT_NEAR(single->of_priors[1], widening(std::round(3.5)), 1e-9);
  EXPECT_NEAR(single->of_priors[2], widening(std::round(3.5)), 1e-9);
  EXPECT_NEAR(single->of_priors[3], widening(3), 1e-9);
}

// s = 0.2 of the readings of ten poses: 40 poses give as much as the prior, 30 more.
TEST(NearNominal, PosesUntilReadingsAndPriorCountAlike) {
  CalibrationResult fit;
  fit.set.kept = {6, 7, 8};
  fit.share_of_readings = Eigen::Vector3d(0.2, 0.9, 0.005);
  Campaign campaign;
  campaign.pose_ids.resize(10);
  const NearNominal found = near_nominal(fit, campaign);
  EXPECT_EQ(found.parameters, (std::vector<int>{0, 2}));
  EXPECT_EQ(found.poses, 30);
}

// Of few poses the interval of a coefficient is that of Student's t.
TEST(Coefficient, HasTheIntervalOfStudentsT) {
  Robot robot = spindle();
  robot.identify = {"base.x", "base.y", "base.z"};
  robot.effects = {
      {"compliance", "A2.theta", *parse_driver("gravity-torque 2"), Shape{}, {{"c", 1e-7}}}};
  const Campaign campaign = noisy(robot, 6, 1, 2);
  const CalibrationResult fit = calibrate(robot, campaign);
  const Coefficient& c = fit.robot.effects.front().coefficients.front();
  EXPECT_NEAR((c.ci95[1] - c.ci95[0]) / 2, student_t_975(5) * c.std, 1e-9 * c.std);
  EXPECT_NEAR(c.std, std::sqrt(fit.covariance(3, 3)), 1e-9 * c.std);
}

}  // namespace
}  // namespace armtrue::prediction_test
