#include <gtest/gtest.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/identifiability.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/observation/session_models.h"
#include "calibration/covariance.h"
#include "calibration/fit_statistics.h"
#include "calibration/pose_influence.h"
#include "calibration/prior.h"
#include "linear_algebra/sparse_cholesky.h"

// Many sessions, of which some have so few readings that they do not determine what is their own.
namespace armtrue::few_readings_test {
namespace {

// Own unknowns of groups, which meet only the common ones, from `rows` of each group.
struct Groups {
  static constexpr int kGroups = 100, kOwn = 4, kCommon = 6, kSize = kGroups * kOwn + kCommon;
  SparseCholesky::Blocks blocks;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(kSize, kSize);

  // `rows`: of a group. `weak`: of the last own column of each third group, beside a multiple of
  // the one before it.
  Groups(const std::vector<int>& rows, double weak) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    std::vector<Eigen::Index> common(kCommon);
    std::iota(common.begin(), common.end(), Eigen::Index{50});  // in the middle
    for (int g = 0; g < kGroups; ++g) {
      std::vector<Eigen::Index>& own = blocks.emplace_back();
      for (int k = g * kOwn; k < (g + 1) * kOwn; ++k) own.push_back(k + (k >= 50 ? kCommon : 0));
      std::vector<Eigen::Index> all = own;
      all.insert(all.end(), common.begin(), common.end());
      Eigen::MatrixXd derivatives =
          Eigen::MatrixXd::NullaryExpr(rows[static_cast<size_t>(g) % rows.size()], kOwn + kCommon,
                                       [&] { return normal(random); });
      if (g % 3 == 0)
        derivatives.col(kOwn - 1) =
            2 * derivatives.col(kOwn - 2) + weak * derivatives.col(kOwn - 1).eval();
      matrix(all, all) += derivatives.transpose() * derivatives;
    }
    blocks.push_back(common);
  }
};

void expect_pseudoinverse(const Groups& groups, Eigen::Index rank, double tolerance) {
  const Eigen::MatrixXd dense = inverse_root(groups.matrix);
  const Eigen::MatrixXd inverse = dense * dense.transpose();
  const SparseCholesky factor(groups.matrix, {}, groups.blocks);
  ASSERT_TRUE(factor.succeeded());
  EXPECT_TRUE(factor.is_clear());
  EXPECT_EQ(factor.rank(), rank);
  EXPECT_EQ(dense.cols(), rank);
  const SparseRows root = factor.inverse_root();
  EXPECT_LT(root.nonZeros(), groups.matrix.cols() * (2 * Groups::kOwn + Groups::kCommon));
  const Eigen::MatrixXd by_blocks = root * root.transpose();
  const Eigen::VectorXd unit = inverse.diagonal().cwiseSqrt().cwiseInverse();
  EXPECT_LT((unit.asDiagonal() * (by_blocks - inverse) * unit.asDiagonal()).cwiseAbs().maxCoeff(),
            tolerance);
  for (Eigen::Index k = 0; k < inverse.cols(); k += 7)
    EXPECT_NEAR(factor.variance(k), inverse(k, k), tolerance * inverse(k, k));
}

TEST(BlocksOfCholesky, LeaveOutWhatTheyDoNotDetermine) {
  // The groups of 12 rows determine all, those of 3 three of their four own unknowns.
  expect_pseudoinverse(Groups({12, 3}, 1), Groups::kSize - 50, 1e-9);
  // One column of each third group is a multiple of another.
  expect_pseudoinverse(Groups({12}, 0), Groups::kSize - 34, 1e-9);
}

TEST(BlocksOfCholesky, KeepWhatIsWeak) {
  constexpr double kWeak = 2e-5;
  const Groups groups({12}, kWeak);
  EXPECT_FALSE(SparseCholesky(groups.matrix).is_clear());
  // Of the matrix in columns of unit length the largest eigenvalue is some 5, and the smallest ones
  // are kWeak^2 / 10 to kWeak^2 / 100: rounding makes both decompositions uncertain by as much.
  constexpr double kRounding = 500 * std::numeric_limits<double>::epsilon() / (kWeak * kWeak);
  expect_pseudoinverse(groups, Groups::kSize, kRounding);
}

Robot shipped(const std::string& name) {
  return read_robot(ARMTRUE_CONFIG "/robots/" + name + ".yaml").robot;
}

// Points of `sessions` sessions; their numbers of poses are `sizes`, in turn.
Campaign measured(int sessions, const std::vector<int>& sizes) {
  SimulationOptions options;
  options.poses = 0;
  for (int s = 0; s < sessions; ++s) options.poses += sizes[static_cast<size_t>(s) % sizes.size()];
  options.seed = 3;
  options.noise_position = 1e-4;
  options.orientation = false;
  Campaign campaign = simulate(shipped("kr360-spindle"), shipped("kr360-table4"), options);
  for (int s = 0; s < sessions; ++s) {
    campaign.session_names.push_back("day " + std::to_string(s));
    campaign.session.insert(campaign.session.end(),
                            static_cast<size_t>(sizes[static_cast<size_t>(s) % sizes.size()]), s);
  }
  return campaign;
}

// The fit at the solution, so that turns of base and tool are zero.
CalibrationResult fit_of(const Robot& robot, const Campaign& campaign, const IdentifiableSet& set) {
  CalibrationOptions options;
  options.robust = false;
  options.tolerance = 1e-14;
  return calibrate(calibrate(robot, campaign, set, options).robot, campaign, set, options);
}

// The statistics of a fit against those of dense matrices. `undetermined`: directions.
void expect_dense_statistics(const Campaign& campaign, const CalibrationResult& fit,
                             int undetermined_directions) {
  const SessionModels models(campaign, fit.robot, fit.set.kept, fit.sigma);
  const Eigen::Index p = models.unknowns();
  const Eigen::MatrixXd blocks = models.blocks(), jacobian = blocks.leftCols(p);
  const Eigen::MatrixXd of_readings = jacobian.transpose() * jacobian;
  ASSERT_TRUE(is_sparse(of_readings));
  Eigen::MatrixXd information = of_readings;
  information.diagonal() += fit.prior_weight.cwiseAbs2();
  const Eigen::MatrixXd root = inverse_root(information), inverse = root * root.transpose();
  const Eigen::MatrixXd by_root = fit.inverse_root * fit.inverse_root.transpose();
  ASSERT_EQ(root.cols(), p - undetermined_directions);
  EXPECT_EQ(fit.inverse_root.cols(), root.cols());

  std::vector<Prior> priors;
  for (Eigen::Index k = 0; k < p; ++k)
    if (fit.prior_weight[k] > 0) priors.push_back({static_cast<int>(k), 1 / fit.prior_weight[k]});
  const double variance = std::max(1.0, blocks.col(p).squaredNorm() / (3.0 * campaign.rows()));
  const Eigen::MatrixXd covariance =
      covariance_by_pose(models, priors, Eigen::VectorXd::Zero(p),
                         std::vector<double>(campaign.pose.size(), 1.0), 0, root, variance, {});
  // What a session lacks may be an unknown: then its row is zero.
  const auto deviation = [](const Eigen::MatrixXd& matrix, Eigen::Index k) {
    return std::sqrt(std::max(matrix(k, k), 1e-30));
  };
  double off_inverse = 0, off_covariance = 0;
  for (Eigen::Index k = 0; k < p; ++k)
    for (Eigen::Index i = 0; i < p; ++i) {
      off_inverse = std::max(off_inverse, std::abs(by_root(k, i) - inverse(k, i)) /
                                              (deviation(inverse, k) * deviation(inverse, i)));
      off_covariance =
          std::max(off_covariance, std::abs(fit.covariance(k, i) - covariance(k, i)) /
                                       (deviation(covariance, k) * deviation(covariance, i)));
    }
  EXPECT_LT(off_inverse, 1e-6);
  EXPECT_LT(off_covariance, 1e-6);
  for (const Prior& prior : priors)
    EXPECT_NEAR(fit.share_of_readings[prior.unknown],
                1 - inverse(prior.unknown, prior.unknown) / std::pow(prior.deviation, 2), 1e-6);

  const Eigen::MatrixXd unit = jacobian.colwise().normalized();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> columns;
  columns.setThreshold(1e-10);
  columns.compute(unit);
  EXPECT_EQ(fit.rank, columns.rank());
  EXPECT_EQ(fit.rank, p - undetermined_directions);
  if (undetermined_directions > 0) {
    EXPECT_TRUE(std::isinf(fit.condition));
    EXPECT_EQ(fit.observability[1], 0);
    return;
  }
  const Eigen::VectorXd singular =
      Eigen::BDCSVD<Eigen::MatrixXd>(jacobian).singularValues() * fit.sigma.position;
  EXPECT_NEAR(fit.condition, singular[0] / singular[p - 1], 1e-5 * fit.condition);
  EXPECT_NEAR(fit.observability[4], 1 / singular.cwiseInverse().sum(), 1e-5 * fit.observability[4]);
}

class FewReadings : public testing::TestWithParam<std::vector<int>> {};

TEST_P(FewReadings, AreThoseOfDenseMatrices) {
  constexpr int kSessions = 60;
  const Robot robot = shipped("kr360-spindle");
  const Campaign campaign = measured(kSessions, GetParam());
  Campaign of_one = campaign;
  of_one.session.clear();
  of_one.session_names.clear();
  const IdentifiableSet set = choose_identifiable(robot, of_one);
  // The base has six unknowns; one point shows three of them, two points five.
  int undetermined_directions = 0;
  for (int s = 0; s < kSessions; ++s) {
    const int poses = GetParam()[static_cast<size_t>(s) % GetParam().size()];
    undetermined_directions += poses == 1 ? 3 : poses == 2 ? 1 : 0;
  }
  expect_dense_statistics(campaign, fit_of(robot, campaign, set), undetermined_directions);
}

INSTANTIATE_TEST_SUITE_P(Sessions, FewReadings,
                         testing::Values(std::vector{12, 3}, std::vector{12, 2, 4, 1},
                                         std::vector{12, 3, 2}));

}  // namespace
}  // namespace armtrue::few_readings_test
