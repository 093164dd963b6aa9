#include "armtrue/calibration/evaluation.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <stdexcept>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/prediction.h"
#include "armtrue/calibration/unseen_scale.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/campaign/stated_covariance.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/statistics/distributions.h"
#include "support/oracle.h"

namespace armtrue::evaluation_test {
namespace {

constexpr const char* kSpindle = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";

TEST(Evaluation, MeanErrorOfNoiseIsThatOfThreeNormalAxes) {
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal(0, 0.095);
  double sum = 0;
  constexpr int kDraws = 200000;
  for (int i = 0; i < kDraws; ++i)
    sum += std::hypot(normal(random), normal(random), normal(random));
  EXPECT_NEAR(mean_error_of_noise(0.095), sum / kDraws, 0.0005);
}

// One axis: sqrt(2 / pi); two: Rayleigh's law, sqrt(pi / 2); three: sqrt(8 / pi).
TEST(Evaluation, MeanErrorOfNoiseOfFewerAxesIsLess) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  double one = 0, two = 0;
  constexpr int kDraws = 100000;
  for (int i = 0; i < kDraws; ++i) {
    one += std::abs(normal(random)) / kDraws;
    two += std::hypot(normal(random), normal(random)) / kDraws;
  }
  EXPECT_NEAR(mean_error_of_noise(1, 1), one, 0.01);
  EXPECT_NEAR(mean_error_of_noise(1, 2), two, 0.01);
}

// Each session's residual is along the axes of its own R_A.
TEST(Evaluation, ResidualsAreInTheFrameOfTheirSession) {
  Robot robot = read_robot(kSpindle).robot;
  robot.sessions["a"].base = robot.chain.base;
  robot.sessions["b"].base = {rotation_exp({0.1, -0.4, 1.2}), {2, -1, 0.5}};
  const Eigen::Vector3d off(1e-4, -2e-4, 3e-4);
  Campaign campaign;
  campaign.session_names = {"a", "b"};
  for (int row = 0; row < 2; ++row) {
    campaign.pose_ids.push_back(std::to_string(row));
    campaign.pose.push_back(row);
    campaign.session.push_back(row);
    campaign.q.emplace_back((JointVector(6) << 0.1, -1.2, 0.7, 0.9, 0.4, -0.3).finished());
    Robot there = robot;
    there.chain.base = robot.sessions.at(campaign.session_names[static_cast<size_t>(row)]).base;
    campaign.position.push_back(RobotModel(there).pose(campaign.context(row)).translation + off);
  }
  const Evaluation evaluation = evaluate(robot, campaign);
  for (const auto& residual : evaluation.residuals)
    EXPECT_LT((residual.head<3>() - off).norm(), 1e-12);
}

// Each pose read twice, a and -a off its own mean on every axis; the means differ from pose to
// pose.
struct ReadTwice {
  Campaign campaign;
  Evaluation evaluation;

  ReadTwice(int poses, double a) {
    for (int row = 0; row < 2 * poses; ++row) {
      const int pose = row / 2;
      if (row % 2 == 0) campaign.pose_ids.push_back(std::to_string(pose));
      campaign.pose.push_back(pose);
      campaign.q.emplace_back(JointVector::Zero(6));
      campaign.position.emplace_back(Eigen::Vector3d::Zero());
      Eigen::Matrix<double, 6, 1> residual = Eigen::Matrix<double, 6, 1>::Zero();
      residual.head<3>().setConstant(1e-3 * pose + (row % 2 == 0 ? a : -a));
      evaluation.residuals.push_back(residual);
    }
  }
};

// Of two readings, the deviations from their mean, times sqrt(2 / (2 - 1)), are all +-sqrt(2) a.
// The robust standard deviation of values of one size b is b / 0.9866: all lie within three of it.
TEST(NoiseFloor, OfReplicatesIsTheirScatterAboutThePose) {
  const ReadTwice readings(7, 1e-4);
  const NoiseFloor floor = noise_floor({}, readings.campaign, readings.evaluation);
  EXPECT_EQ(floor.source, NoiseFloor::Source::replicates);
  EXPECT_EQ(floor.degrees_of_freedom, 18);  // 0.864 x poses x axes x (2 - 1)
  EXPECT_NEAR(floor.position, std::sqrt(2) * 1e-4 / 0.9866, 1e-12);
}

// Under another load an arm stands elsewhere: rows of a pose with other payloads or forces are no
// repeats. Load cells scatter a little.
TEST(NoiseFloor, OfReplicatesIsThatUnderOneLoad) {
  constexpr double kNoise = 1e-4, kSag = 3e-3;
  for (const bool by_force : {false, true}) {
    ReadTwice readings(14, kNoise);
    for (int row = 0; row < 28; ++row) {
      const bool loaded = row % 4 >= 2;
      readings.campaign.pose[row] = row / 4;
      readings.evaluation.residuals[row].head<3>().setConstant((loaded ? -kSag : 0) +
                                                               (row % 2 == 0 ? kNoise : -kNoise));
      const double load = (loaded ? 50 : 0) + 0.1 * (row % 2);
      if (by_force)
        readings.campaign.force_n.emplace_back(0, 0, -10 * load);
      else
        readings.campaign.payload_kg.push_back(load);
    }
    const NoiseFloor floor = noise_floor({}, readings.campaign, readings.evaluation);
    EXPECT_EQ(floor.source, NoiseFloor::Source::replicates);
    EXPECT_NEAR(floor.position, std::sqrt(2) * kNoise / 0.9866, 1e-12) << by_force;
  }
}

// A table that holds each reading twice has no noise of zero, unless all that it reads is exact.
TEST(NoiseFloor, OfCopiesIsThatOfTheInstrument) {
  const ReadTwice copies(9, 0);
  Robot robot;
  robot.noise.position = 1e-4;
  const NoiseFloor floor = noise_floor(robot, copies.campaign, copies.evaluation);
  EXPECT_TRUE(floor.are_copies);
  EXPECT_EQ(floor.source, NoiseFloor::Source::instrument);
  EXPECT_EQ(floor.position, 1e-4);
  EXPECT_EQ(noise_floor({}, copies.campaign, copies.evaluation).source, NoiseFloor::Source::none);
  ReadTwice exact(9, 0);
  for (auto& residual : exact.evaluation.residuals) residual *= 1e-6;
  EXPECT_EQ(noise_floor(robot, exact.campaign, exact.evaluation).source,
            NoiseFloor::Source::replicates);
}

// Most readings of a scale of 0.1 mm agree, a third along x by chance not: sigma^2 = (0.1 mm)^2 / 2
// / 3 there, and none along y and z.
TEST(NoiseFloor, OfACoarseScaleIsTheMeanSquareOfItsSteps) {
  ReadTwice rounded(30, 0);
  for (size_t row = 0; row < 60; row += 6) rounded.evaluation.residuals[row].x() += 1e-4;
  const NoiseFloor floor = noise_floor({}, rounded.campaign, rounded.evaluation);
  EXPECT_FALSE(floor.are_copies);
  EXPECT_EQ(floor.source, NoiseFloor::Source::replicates);
  EXPECT_NEAR(floor.position, 1e-4 / std::sqrt(18), 1e-12);
}

// Readings that state twice the standard deviation scatter twice as far: one floor, of the median.
TEST(NoiseFloor, WeighsReadingsByTheirOwnDeviation) {
  ReadTwice readings(9, 1e-4);
  for (int row = 0; row < 18; ++row) {
    const bool is_coarse = row < 4;
    readings.campaign.sigma_position.push_back(is_coarse ? 2e-5 : 1e-5);
    if (is_coarse) readings.evaluation.residuals[static_cast<size_t>(row)] *= 2;
  }
  NoiseFloor floor = noise_floor({}, readings.campaign, readings.evaluation);
  EXPECT_NEAR(floor.position, std::sqrt(2) * 1e-4 / 0.9866, 1e-12);
  // The same of orientations.
  readings.campaign.sigma_orientation = readings.campaign.sigma_position;
  readings.campaign.sigma_position.assign(18, 1e-5);
  for (auto& residual : readings.evaluation.residuals) residual.tail<3>() = residual.head<3>();
  readings.campaign.orientation.assign(18, Eigen::Quaterniond::Identity());
  floor = noise_floor({}, readings.campaign, readings.evaluation);
  EXPECT_NEAR(floor.orientation, std::sqrt(2) * 1e-4 / 0.9866, 1e-12);
}

// A camera is worse along its line of sight. Two axes of 0.03 mm and one of 0.15 mm: the mean
// variance is 0.0081 mm^2, and they scatter as much as (0.0243)^2 / 0.00050787 = 1.163 equal axes.
// The scatter about the poses' means is noise alone, so its test rejects one null in a hundred at p
// = 0.01.
TEST(NoiseFloor, OfUnevenAxesIsTheirMeanVariance) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  double variance = 0, axes = 0;
  constexpr int kCampaigns = 200;
  for (int k = 0; k < kCampaigns; ++k) {
    ReadTwice readings(60, 0);
    for (auto& residual : readings.evaluation.residuals)
      residual.head<3>() = 1e-3 * Eigen::Vector3d(0.03 * normal(random), 0.03 * normal(random),
                                                  0.15 * normal(random));
    const NoiseFloor floor = noise_floor({}, readings.campaign, readings.evaluation);
    variance += floor.position * floor.position / kCampaigns;
    axes += floor.even_axes / kCampaigns;
    EXPECT_LT(floor.degrees_of_freedom, 0.6 * 0.864 * 180);
  }
  EXPECT_NEAR(variance, 8.1e-9, 0.4e-9);
  EXPECT_NEAR(axes, 1.163, 0.02);
}

// The instrument stood farther away on the second day. Noise of 0.05 and 0.15 mm: the mean variance
// is 0.0125 mm^2, and three axes scatter as much as 3 x 0.0125^2 / 0.00025625 = 1.829 equal ones.
// The robust deviation of the mixture would be less: it takes the far readings for blunders.
TEST(NoiseFloor, OfUnevenSessionsIsTheirMeanVariance) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  double variance = 0, axes = 0;
  constexpr int kCampaigns = 100, kPoses = 300;
  for (int k = 0; k < kCampaigns; ++k) {
    ReadTwice readings(kPoses, 0);
    Campaign& campaign = readings.campaign;
    campaign.session_names = {"near", "far"};
    for (int row = 0; row < campaign.rows(); ++row) {
      campaign.session.push_back(campaign.pose[row] % 2);
      const double deviation = campaign.session.back() == 0 ? 5e-5 : 15e-5;
      readings.evaluation.residuals[row].head<3>() =
          deviation * Eigen::Vector3d(normal(random), normal(random), normal(random));
    }
    const NoiseFloor floor = noise_floor({}, campaign, readings.evaluation);
    variance += floor.position * floor.position / kCampaigns;
    axes += floor.even_axes / kCampaigns;
  }
  EXPECT_NEAR(variance, 12.5e-9, 0.4e-9);
  EXPECT_NEAR(axes, 1.829, 0.03);
}

// Below 20 degrees of freedom the readings' own statement counts, then that of the robot file.
TEST(NoiseFloor, OfFewReplicatesIsWhatIsStated) {
  ReadTwice readings(6, 1e-4);
  Robot robot;
  EXPECT_EQ(noise_floor(robot, readings.campaign, readings.evaluation).source,
            NoiseFloor::Source::none);
  robot.noise.position = 5e-5;
  NoiseFloor floor = noise_floor(robot, readings.campaign, readings.evaluation);
  EXPECT_EQ(floor.source, NoiseFloor::Source::instrument);
  EXPECT_EQ(floor.position, 5e-5);
  readings.campaign.sigma_position = {1e-5, 2e-5, 3e-5, 4e-5, 5e-5, 6e-5,
                                      7e-5, 8e-5, 9e-5, 9e-5, 9e-5, 9e-5};
  floor = noise_floor(robot, readings.campaign, readings.evaluation);
  EXPECT_NEAR(floor.position, 6.5e-5, 1e-18);
}

// The lack-of-fit p of a calibration of the oracle's campaign that hides an effect of this family.
double lack_of_fit_p(const std::string& family, double size_mm, unsigned seed) {
  armtrue_oracle::CampaignPlan plan;
  plan.poses = 40;
  plan.seed = seed;
  std::string folder = std::filesystem::temp_directory_path() / "armtrue-fit-XXXXXX";
  if (!mkdtemp(folder.data())) throw std::runtime_error("cannot create " + folder);
  armtrue_oracle::write_campaign(armtrue_oracle::read_arm(kSpindle), family, size_mm, plan, folder);
  const Campaign campaign = read_campaign(folder + "/train.csv").campaign;
  std::filesystem::remove_all(folder);
  return assess(calibrate(read_robot(kSpindle).robot, campaign), campaign).lack_of_fit.value();
}

// Without replicates, by the noise that is stated: the sum of squares is chi-squared, of as many
// degrees of freedom as there are numbers, less those that the unknowns take up.
TEST(LackOfFit, OfStatedNoiseIsThatOfChiSquared) {
  constexpr int kPoses = 10;
  CalibrationResult fit;
  fit.robot.noise = {.position = 1e-4, .orientation = 2e-4};
  fit.determined = {5, 7};
  Campaign campaign;
  Evaluation evaluation;
  double position = 0, orientation = 0;
  for (int pose = 0; pose < kPoses; ++pose) {
    campaign.pose_ids.push_back(std::to_string(pose));
    campaign.pose.push_back(pose);
    campaign.q.emplace_back(JointVector::Zero(6));
    campaign.position.emplace_back(Eigen::Vector3d::Zero());
    campaign.orientation.push_back(Eigen::Quaterniond::Identity());
    Eigen::Matrix<double, 6, 1>& residual = evaluation.residuals.emplace_back();
    residual << 1e-4, -0.5e-4, 0.1e-4 * pose, 2e-4, -3e-4, 0.2e-4 * pose;
    position += residual.head<3>().squaredNorm() / 1e-8;
    orientation += residual.tail<3>().squaredNorm() / 4e-8;
  }
  const FitQuality quality = assess(fit, campaign, evaluation);
  EXPECT_NEAR(*quality.lack_of_fit, chi_squared_above(position + orientation, 6 * kPoses - 12),
              1e-9);
  EXPECT_NEAR(*quality.lack_of_fit_in_position, chi_squared_above(position, 3 * kPoses - 5), 1e-9);
}

// By replicates of uneven axes, the scatter of the means has as few degrees of freedom as that of
// the replicates, in proportion.
TEST(LackOfFit, OfReplicatesIsThatOfFisher) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  ReadTwice readings(20, 0);
  double squares = 0, within = 0;
  for (size_t row = 0; row < 40; row += 2) {
    Eigen::Matrix<double, 6, 1>*const first = &readings.evaluation.residuals[row], *const second =
                                                                                       first + 1;
    for (auto* residual : {first, second})
      residual->head<3>() =
          1e-4 * Eigen::Vector3d(normal(random), normal(random), 4 * normal(random));
    squares += 2 * ((*first + *second) / 2).squaredNorm();
    within += (*first - *second).squaredNorm() / 2;
  }
  CalibrationResult fit;
  fit.determined = {4, 0};
  const FitQuality quality = assess(fit, readings.campaign, readings.evaluation);
  const NoiseFloor& floor = quality.noise;
  ASSERT_EQ(floor.source, NoiseFloor::Source::replicates);
  ASSERT_LT(floor.even_axes, 2);
  const double freedom = 3 * 20 - 4, of_replicates = 3 * 20;
  EXPECT_NEAR(*quality.lack_of_fit,
              fisher_f_above(squares / freedom / (within / of_replicates),
                             freedom * floor.even_axes / 3, of_replicates * floor.even_axes / 3),
              1e-9);
}

// A pose that is off as a whole has a small weight, and its readings are no blunders.
TEST(Blunders, AreReadingsThatAreOffFromTheirPose) {
  ReadTwice readings(4, 1e-4);
  CalibrationResult fit;
  fit.degrees_of_freedom = 3;
  fit.weights = {0.01, 0.01, 1, 1, 1, 1, 1, 0.02};
  fit.weights_in_pose = {1, 1, 1, 1, 1, 1, 1, 0.02};
  EXPECT_EQ(assess(fit, readings.campaign, readings.evaluation).blunders, std::vector<int>{7});
}

// Where the model is true its p is uniform on [0, 1]: Kolmogorov and Smirnov's distance of 200
// draws exceeds 1.63 / sqrt(200) = 0.115 by chance once in a hundred times.
TEST(LackOfFit, IsUniformWhereTheModelLacksNothing) {
  constexpr int kCampaigns = 200;
  std::vector<double> p;
  for (unsigned seed = 1; seed <= kCampaigns; ++seed) p.push_back(lack_of_fit_p("null", 0, seed));
  std::sort(p.begin(), p.end());
  double distance = 0;
  for (size_t i = 0; i < p.size(); ++i)
    distance = std::max({distance, p[i] - static_cast<double>(i) / kCampaigns,
                         static_cast<double>(i + 1) / kCampaigns - p[i]});
  EXPECT_LT(distance, 1.63 / std::sqrt(kCampaigns));
}

TEST(LackOfFit, IsClearWhereAnEffectIsHidden) {
  for (unsigned seed = 1; seed <= 5; ++seed)
    EXPECT_LT(lack_of_fit_p("compliance", 0.12, seed), 1e-3) << seed;
}

// Exact readings of 20 poses, whose depth errs ten times as far as the other axes, as stated: p <
// 0.05 in one of 20. Taken for even noise, one in six.
TEST(LackOfFit, WhitensByStatedCovariances) {
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  const Eigen::Vector3d deviation(2e-5, 2e-5, 2e-4);
  constexpr int kPoses = 20, kCampaigns = 1000;
  Campaign campaign;
  PoseCovariance covariance = PoseCovariance::Identity();
  covariance.topLeftCorner<3, 3>() = deviation.cwiseAbs2().asDiagonal();
  for (int pose = 0; pose < kPoses; ++pose) {
    campaign.pose_ids.push_back(std::to_string(pose));
    campaign.pose.push_back(pose);
    campaign.q.emplace_back(JointVector::Zero(6));
    campaign.position.emplace_back(Eigen::Vector3d::Zero());
    ASSERT_TRUE(add_covariance(covariance, {.position = true, .rotation = false}, campaign));
  }
  CalibrationResult fit;
  fit.determined = {0, 0};
  fit.degrees_of_freedom = 0;
  Evaluation evaluation;
  evaluation.residuals.resize(kPoses);
  int small = 0;
  for (int k = 0; k < kCampaigns; ++k) {
    for (auto& residual : evaluation.residuals) {
      residual.setZero();
      for (int i = 0; i < 3; ++i) residual[i] = deviation[i] * normal(random);
    }
    small += assess(fit, campaign, evaluation).lack_of_fit.value() < 0.05;
  }
  EXPECT_GT(small, 0.03 * kCampaigns);
  EXPECT_LT(small, 0.08 * kCampaigns);
}

// Two touches of a point in three rows each, then one of a plane.
TEST(Evaluation, TheErrorOfATouchIsADistance) {
  Campaign campaign;
  campaign.pose_ids = {"a", "b", "c"};
  campaign.contact_names = {"spike", "table"};
  Evaluation evaluation;
  for (int row = 0; row < 7; ++row) {
    const bool is_plane = row == 6;
    campaign.pose.push_back(row / 3);
    campaign.line.push_back(row / 3 + 2);
    campaign.q.emplace_back(JointVector::Zero(6));
    campaign.distance.push_back(0);
    campaign.touch.push_back({is_plane ? 1 : 0, is_plane ? -1 : row % 3});
  }
  evaluation.position = {2e-3, 3e-3, 6e-3, 1e-3, 4e-3, 8e-3, 5e-3};
  evaluation.residuals.resize(7, Eigen::Matrix<double, 6, 1>::Zero());
  evaluation.first_rows = campaign.first_rows_of_readings();
  EXPECT_EQ(evaluation.first_rows, (std::vector<int>{0, 3, 6}));
  const std::vector<double> errors = evaluation.reading_errors();
  ASSERT_EQ(errors.size(), 3u);
  EXPECT_NEAR(errors[0], 7e-3, 1e-12);
  EXPECT_NEAR(errors[1], 9e-3, 1e-12);
  EXPECT_NEAR(errors[2], 5e-3, 1e-12);
  // A perfect model would miss two points and one plane.
  Robot robot;
  robot.noise.position = 1e-3;
  EXPECT_NEAR(noise_floor(robot, campaign, evaluation).mean_error(),
              (2 * mean_error_of_noise(1e-3, 3) + mean_error_of_noise(1e-3, 1)) / 3, 1e-12);
  // Without the row of a blunder the others are still one reading.
  EXPECT_EQ(campaign.select({0, 2, 3, 4, 5, 6}).first_rows_of_readings(),
            (std::vector<int>{0, 2, 5}));
  EXPECT_EQ(campaign.select({0, 3, 6}).first_rows_of_readings(), std::vector<int>());
}

// By KDL, with the base at the foot: 0.1 mm for each metre and 100 ppm, wherever the instrument is.
TEST(UnseenScale, CostsInProportionToTheDistanceFromTheFoot) {
  const std::array<std::array<double, 6>, 2> joints{
      {{0.3, -1.2, 1.5, 0.2, 0.6, -0.4}, {-1.0, -0.6, 0.9, 0.1, -0.8, 0.5}}};
  const armtrue_oracle::OracleArm arm = armtrue_oracle::read_arm(kSpindle);
  Campaign campaign;
  std::vector<double> distances;
  for (const auto& q : joints) {
    distances.push_back(armtrue_oracle::forward(arm, q).p.Norm());
    campaign.pose.push_back(static_cast<int>(campaign.pose_ids.size()));
    campaign.pose_ids.push_back(std::to_string(campaign.pose.back()));
    campaign.q.emplace_back(Eigen::Map<const Eigen::VectorXd>(q.data(), 6));
    campaign.position.emplace_back(Eigen::Vector3d::Zero());
  }
  Robot robot = read_robot(kSpindle).robot;
  robot.chain.base.translation = {5, -3, 1};
  const auto scale = unseen_scale(robot, campaign);
  ASSERT_TRUE(scale);
  EXPECT_NEAR(scale->mean_cost(), 1e-4 * (distances[0] + distances[1]) / 2, 1e-12);
  EXPECT_NEAR(scale->max_cost(), 1e-4 * std::max(distances[0], distances[1]), 1e-12);
  // Touches have no instrument.
  campaign.position.clear();
  campaign.distance.assign(2, 0);
  campaign.contact_names = {"table"};
  campaign.touch.assign(2, {0, -1});
  EXPECT_FALSE(unseen_scale(robot, campaign));
}

// By finite differences of the model, row by row.
TEST(MeanSquare, IsThatOfAQuadraticFormOfNormalErrors) {
  Robot robot = read_robot(kSpindle).robot;
  const std::vector<std::string> names{"A2.theta", "A3.theta", "A4.d"};
  Eigen::Matrix3d root;
  root << 2e-4, 0, 0, -1e-4, 3e-4, 0, 5e-5, 2e-5, 1e-4;
  robot.uncertainty = Uncertainty{.parameters = names, .root = root};
  Campaign campaign;
  Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
  for (const double turn : {-0.7, 0.1, 0.9}) {
    campaign.pose_ids.push_back(std::to_string(turn));
    campaign.pose.push_back(campaign.rows());
    campaign.q.push_back(
        (JointVector(6) << turn, -1.2 + 0.3 * turn, 0.9, turn, 0.5, -turn).finished());
    campaign.position.emplace_back(Eigen::Vector3d::Zero());
    Context context;
    context.q = campaign.q.back();
    Eigen::Matrix3d jacobian;
    for (int k = 0; k < 3; ++k) {
      constexpr double kStep = 1e-6;
      Robot more = robot, less = robot;
      const int parameter = *find_parameter(robot.chain, names[static_cast<size_t>(k)]);
      move_parameter(more.chain, parameter, kStep);
      move_parameter(less.chain, parameter, -kStep);
      jacobian.col(k) = (RobotModel(more).pose(context).translation -
                         RobotModel(less).pose(context).translation) /
                        (2 * kStep);
    }
    mean += (jacobian * root).transpose() * (jacobian * root) / 3;
  }
  const MeanSquare found = mean_square_by_uncertainty(robot, campaign);
  EXPECT_NEAR(found.expected, mean.trace(), 1e-6 * mean.trace());
  EXPECT_NEAR(found.freedom, mean.trace() * mean.trace() / (mean * mean).trace(), 1e-6);
}

// One instrument reads every fourth pose, eight times as coarse as the other, and the rows say so.
Campaign of_two_instruments(const Robot& robot, int poses, unsigned seed) {
  constexpr double kFine = 0.05e-3, kCoarse = 0.4e-3;
  SimulationOptions options;
  options.poses = poses;
  options.orientation = false;
  options.seed = seed;
  Campaign campaign = simulate(robot, robot, options);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (int row = 0; row < campaign.rows(); ++row) {
    const double sigma = campaign.pose[row] % 4 == 0 ? kCoarse : kFine;
    campaign.sigma_position.push_back(sigma);
    for (double& x : campaign.position[row]) x += sigma * normal(random);
  }
  return campaign;
}

// The bounds of each hold, and their errors are no surprise.
TEST(Prediction, EachReadingIsPredictedWithItsOwnNoise) {
  const Robot nominal = read_robot(kSpindle).robot;
  int unexpected = 0;
  double coarse = 0, inside_coarse = 0, fine = 0, inside_fine = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Campaign training = of_two_instruments(nominal, 60, seed),
                   others = of_two_instruments(nominal, 40, 100 + seed);
    const CalibrationResult fit = calibrate(nominal, training);
    Robot robot = fit.robot;
    robot.uncertainty = uncertainty_of(fit, training);
    unexpected += p_of_errors(robot, others) < 0.01;
    const std::vector<Prediction> predictions = predict(robot, others);
    const Evaluation evaluation = evaluate(robot, others);
    for (int row = 0; row < others.rows(); ++row) {
      const bool is_coarse = others.pose[row] % 4 == 0;
      (is_coarse ? coarse : fine) += 1;
      (is_coarse ? inside_coarse : inside_fine) +=
          evaluation.position[row] <= predictions[row].bound_95;
    }
  }
  EXPECT_LE(unexpected, 1);
  EXPECT_GT(inside_coarse / coarse, 0.88);
  EXPECT_GT(inside_fine / fine, 0.88);
}

// Held-out readings of another instrument than that of the floor.
TEST(NoiseFloor, OfOtherReadingsIsByWhatTheyState) {
  ReadTwice readings(9, 1e-4);
  readings.campaign.sigma_position.assign(18, 0.1e-3);
  const NoiseFloor floor = noise_floor({}, readings.campaign, readings.evaluation);
  Campaign others = readings.campaign;
  others.sigma_position.assign(18, 0.3e-3);
  EXPECT_NEAR(mean_error(floor, others), 3 * mean_error(floor, readings.campaign), 1e-12);
}

}  // namespace
}  // namespace armtrue::evaluation_test
