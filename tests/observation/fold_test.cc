#include "armtrue/observation/fold.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <thread>

#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "kinematics/six_axes.h"

namespace armtrue::fold_test {
namespace {

struct Setting {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  Campaign campaign;
  std::vector<int> parameters;

  // `numbers` of each reading: 1, the distance from an anchor; 3, a point; 6, a pose. Replicates
  // are near the model, where their derivatives are one: see ObservationModel::At.
  explicit Setting(int poses, int numbers = 6, int repeats = 1) {
    SimulationOptions options;
    options.orientation = numbers == 6;
    options.poses = poses;
    options.repeats = repeats;
    options.noise_position = 1e-4;
    options.noise_orientation = 2e-4;
    Robot truth = read_robot(ARMTRUE_CONFIG "/robots/kr360-table4.yaml").robot;
    if (numbers == 1)
      for (Robot* of : {&robot, &truth})
        of->chain.anchors.push_back({.name = "wire", .position = {2.5, 1.5, 0.2}});
    campaign = simulate(robot, truth, options);
    if (repeats > 1) robot = truth;
    for (int k = 0; k < kGeometricParameters; ++k) parameters.push_back(k);
  }
};

// Student's t with poses that are off as a whole, some beyond what counts.
ReadingLaw law_of_poses(int rows) {
  ReadingLaw law{4, {}, 16};
  for (int row = 0; row < rows; ++row) law.variance.push_back(row % 3 == 0 ? 1 : row % 3 * 40 - 35);
  return law;  // 1, 5 and 45
}

// The triangle of the fold against the stacked rows it stands for.
void expect_fold_of_all_rows(const ObservationModel& model) {
  const auto at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
  for (const ReadingLaw& law : {ReadingLaw{0, {}}, ReadingLaw{4, {}}, law_of_poses(model.rows())}) {
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(model.unknowns() + 1, model.unknowns() + 1);
    double loss = 0;
    Eigen::MatrixXd block(6, model.unknowns() + 1);
    for (int row = 0; row < model.rows(); ++row) {
      at.block(row, block);
      const double squared = block.rightCols<1>().squaredNorm();
      loss += law.loss(squared, 6, law.variance_of(row));
      gram += law.weight(squared, 6, law.variance_of(row)) * block.transpose() * block;
    }
    const Fold by_qr = fold(at, model, law, FoldBy::qr);
    EXPECT_TRUE(by_qr.factor.isUpperTriangular());
    EXPECT_LT((by_qr.factor.transpose() * by_qr.factor - gram).norm(), 1e-10 * gram.norm());
    EXPECT_NEAR(by_qr.loss, loss, 1e-9 * loss);
    const Fold by_products = fold(at, model, law, FoldBy::normal_equations);
    const Eigen::MatrixXd products = by_products.products.selfadjointView<Eigen::Upper>();
    EXPECT_LT((products - gram).norm(), 1e-10 * gram.norm());
    EXPECT_NEAR(by_products.loss, loss, 1e-9 * loss);
    EXPECT_NEAR(total_loss(at, model, law), loss, 1e-9 * loss);
  }
}

TEST(Fold, KeepsTheNormalEquationsOfAllRows) {
  for (const int repeats : {1, 4}) {
    const Setting setting(300 / repeats, 6, repeats);
    const ObservationModel model(setting.campaign, setting.robot, setting.parameters, {1e-4, 2e-4});
    EXPECT_EQ(model.rows_by_prediction().groups(), 300 / repeats);
    expect_fold_of_all_rows(model);
  }
}

// Each compared with all others of its pose would take a hundred times as long.
TEST(Fold, TellsReadingsWithDeviationsOfTheirOwnApartInLinearTime) {
  constexpr int kReadings = 40000;
  constexpr double kMostSeconds = 1;  // of a processor
  const Setting setting(1, 3);
  Campaign one_pose = setting.campaign.select(std::vector<int>(kReadings, 0));
  for (int row = 0; row < kReadings; ++row) one_pose.sigma_position.push_back(1e-4 + 1e-9 * row);
  const std::clock_t begin = std::clock();
  const ObservationModel model(one_pose, setting.robot, {}, {1e-4, 2e-4});
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, kMostSeconds);
  EXPECT_FALSE(model.has_replicates());
}

// Readings of one pose that are not replicates: other joint angles, and a time that moves the
// model.
TEST(Fold, KeepsRowsApartThatThePredictionTellsApart) {
  Setting setting(30, 6, 4);
  setting.campaign.q[7][2] += 1e-3;
  const auto predictions = [&] {
    const ObservationModel model(setting.campaign, setting.robot, setting.parameters, {1e-4, 2e-4});
    expect_fold_of_all_rows(model);
    return model.rows_by_prediction().groups();
  };
  EXPECT_EQ(predictions(), 31);
  Effect& drift = setting.robot.effects.emplace_back();
  drift = {"drift", "A2.theta", {DriverKind::time, -1, -1, ""}, {}, {}};
  drift.coefficients = {{"c", 1e-6}};
  EXPECT_EQ(predictions(), 120);
}

// The change of the gradient -w(s) J^T r with the model linear, by finite differences.
TEST(Fold, KnowsTheSecondDerivativeOfTheLoss) {
  const Setting setting(300);
  const ObservationModel model(setting.campaign, setting.robot, setting.parameters, {1e-4, 2e-4});
  const int p = model.unknowns();
  const auto at = model.at(Eigen::VectorXd::Zero(p));
  const ReadingLaw law = law_of_poses(model.rows());
  const Eigen::VectorXd step = 1e-7 * Eigen::VectorXd::Ones(p);
  Eigen::VectorXd change = Eigen::VectorXd::Zero(p);
  Eigen::MatrixXd block(6, p + 1);
  for (int row = 0; row < model.rows(); ++row) {
    at.block(row, block);
    const auto jacobian = block.leftCols(p);
    const auto gradient = [&](double sign) {
      const Eigen::VectorXd r = block.col(p) - sign * jacobian * step;
      return Eigen::VectorXd(-law.weight(r.squaredNorm(), 6, law.variance_of(row)) *
                             (jacobian.transpose() * r));
    };
    change += (gradient(1) - gradient(-1)) / 2;
  }
  const Fold folded = fold(at, model, law, FoldBy::normal_equations);
  const Eigen::MatrixXd weighted =
      folded.products.topLeftCorner(p, p).selfadjointView<Eigen::Upper>();
  const Eigen::MatrixXd bend = folded.bend.selfadjointView<Eigen::Upper>();
  EXPECT_LT(((weighted - bend) * step - change).norm(), 1e-5 * change.norm());
  EXPECT_GT((weighted * step - change).norm(), 0.1 * change.norm());
}

// With few unknowns and with many, most of them knots of curves that a row does not reach: the sums
// against all rows written out, and the same from derivatives that were kept at another sigma; and
// the slopes alone, beside another x.
void expect_kept_fold(int numbers, int repeats) {
  for (const int knots : {4, 60}) {
    Setting setting(300 / repeats, numbers, repeats);
    for (const int joint : {1, 2, 4}) {
      Effect& curve = setting.robot.effects.emplace_back();
      curve = {"curve",
               "A" + std::to_string(joint + 1) + ".theta",
               {DriverKind::joint_angle, joint, -1, ""},
               series_shape(SeriesBasis::spline, knots, -2, 2),
               {}};
      curve.coefficients.resize(static_cast<size_t>(knots));
    }
    ObservationModel model(setting.campaign, setting.robot, setting.parameters, {3e-4, 1e-4});
    const int p = model.unknowns();
    const auto at = model.at(Eigen::VectorXd::Zero(p));
    const KeptDerivatives kept = keep_derivatives(at, model);
    model.set_sigma({1e-4, 2e-4});
    const ReadingLaw law = law_of_poses(model.rows());
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(p + 1, p + 1), bend = Eigen::MatrixXd::Zero(p, p);
    Eigen::MatrixXd block(numbers, p + 1);
    double loss = 0;
    for (int row = 0; row < model.rows(); ++row) {
      at.block(row, block);
      const double squared = block.rightCols<1>().squaredNorm(), variance = law.variance_of(row),
                   weight = law.weight(squared, numbers, variance);
      loss += law.loss(squared, numbers, variance);
      gram += weight * block.transpose() * block;
      const Eigen::VectorXd slope = block.leftCols(p).transpose() * block.col(p);
      bend += 2 * weight * weight / ((4 + numbers) * std::min(variance, 16.0)) * slope *
              slope.transpose();
    }
    const Eigen::MatrixXd whole = gram.topLeftCorner(p, p);
    for (const Fold& folded :
         {fold(at, model, law, kept), fold(at, model, law, FoldBy::normal_equations)}) {
      const Eigen::MatrixXd products = folded.products.selfadjointView<Eigen::Upper>();
      const Eigen::MatrixXd bent = folded.bend.selfadjointView<Eigen::Upper>();
      EXPECT_LT((products - gram).norm(), 1e-12 * gram.norm()) << knots;
      EXPECT_LT((bent - bend).norm(), 1e-12 * bend.norm()) << knots;
      EXPECT_LT((folded.information() - whole).norm(), 1e-12 * whole.norm()) << knots;
      EXPECT_NEAR(folded.loss, loss, 1e-12 * loss) << knots;
    }
    EXPECT_LT((fold(at, model, law).information() - whole).norm(), 1e-10 * whole.norm()) << knots;

    const Fold beside = fold(model.at(Eigen::VectorXd::Constant(p, 1e-4)), model, law, kept);
    const Fold slopes = fold(at, model, law, kept, beside);
    // Readings near the model lose digits in the difference.
    EXPECT_LT((slopes.products.col(p) - gram.col(p)).norm(), 1e-11 * gram.col(p).norm()) << knots;
    EXPECT_NEAR(slopes.loss, loss, 1e-12 * loss) << knots;
    EXPECT_TRUE(slopes.products.leftCols(p) == beside.products.leftCols(p)) << knots;
    EXPECT_TRUE(slopes.bend == beside.bend) << knots;
    EXPECT_GT((beside.products.col(p) - gram.col(p)).norm(), 1e-3 * gram.col(p).norm()) << knots;
  }
}

TEST(Fold, OfKeptDerivativesIsThatOfTheRows) {
  for (const int repeats : {1, 10})
    for (const int numbers : {1, 3, 6}) {
      SCOPED_TRACE(numbers);
      SCOPED_TRACE(repeats);
      expect_kept_fold(numbers, repeats);
    }
}

// Far from the solution, where the derivatives of an orientation turn with its residual.
TEST(Fold, HasTheGradientOfEachReplicate) {
  Setting setting(20, 6, 5);
  setting.robot.chain.tool.rotation =
      rotation_exp({0.02, -0.03, 0.01}) * setting.robot.chain.tool.rotation;
  const ObservationModel model(setting.campaign, setting.robot, setting.parameters, {1e-4, 2e-4});
  const int p = model.unknowns();
  const auto at = model.at(Eigen::VectorXd::Zero(p));
  const ReadingLaw law = law_of_poses(model.rows());
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(p);
  Eigen::MatrixXd block(6, p + 1);
  for (int row = 0; row < model.rows(); ++row) {
    at.block(row, block);
    gradient += law.weight(block.col(p).squaredNorm(), 6, law.variance_of(row)) *
                block.leftCols(p).transpose() * block.col(p);
  }
  const Fold folded = fold(at, model, law, FoldBy::normal_equations);
  EXPECT_LT((folded.products.col(p).head(p) - gradient).norm(), 1e-10 * gradient.norm());
}

TEST(Fold, GivesTheSameBytesEveryTime) {
  const Setting setting(9000);  // several blocks, over the threads there are
  const ObservationModel model(setting.campaign, setting.robot, {0, 1, 7, 12, 20, 30, 41}, {1, 1});
  const auto at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
  for (FoldBy by : {FoldBy::qr, FoldBy::normal_equations}) {
    const Fold first = fold(at, model, {4, {}}, by);
    for (int i = 0; i < 3; ++i) {
      const Fold again = fold(at, model, {4, {}}, by);
      EXPECT_EQ(first.loss, again.loss);
      EXPECT_TRUE(first.factor == again.factor);
      EXPECT_TRUE(first.products == again.products);
    }
  }
}

TEST(Fold, WeightIsTheDerivativeOfTheLoss) {
  const ReadingLaw law{5, {}, 16};
  for (double variance : {1.0, 5.0, 45.0})
    for (double s : {0.1, 1.0, 6.0, 400.0}) {
      const double h = 1e-6 * s;
      EXPECT_NEAR((law.loss(s + h, 6, variance) - law.loss(s - h, 6, variance)) / (2 * h),
                  law.weight(s, 6, variance), 1e-6);
    }
}

}  // namespace
}  // namespace armtrue::fold_test
