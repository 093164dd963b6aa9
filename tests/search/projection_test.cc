// The scan against plain least squares on all columns at once, on linear problems made by hand.

#include "search/projection.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "search/ebic.h"
#include "search/linear_problem.h"

namespace armtrue::projection_test {
namespace {

constexpr double kFloat = 1e-5;  // relative: values of candidates are floats

double squares_left(const Eigen::MatrixXd& columns, const Eigen::VectorXd& readings) {
  return (readings - columns * columns.householderQr().solve(readings)).squaredNorm();
}

Eigen::MatrixXd beside(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

double first_angle(const JointVector& q) { return q[0]; }
double second_angle(const JointVector& q) { return q[1]; }
double fourth_angle(const JointVector& q) { return q[3]; }
double sine_of_fifth(const JointVector& q) { return std::sin(q[4]); }
double cosine_of_fifth(const JointVector& q) { return std::cos(q[4]); }

// 30 poses read twice, a model of five columns and one effect on A2.theta by joint 2, and
// candidates of one, two and six columns.
struct Problem {
  Random random{3};
  Campaign campaign = angles_by_hand(random, 30, 2);
  std::vector<Candidate> candidates{candidate_of("A3.theta", 0),
                                    candidate_of("A3.theta", 4, ShapeKind::harmonic),
                                    candidate_of("A5.alpha", 1), candidate_of("base", 3)};
  LinearProblem linear = problem_by_hand(random, campaign, 5);
  Eigen::MatrixXd effect;  // the column of the model's own effect

  Problem() {
    candidates[0].log_choices = std::log(4.0);
    candidates[1].log_choices = std::log(7.0);
    effect = column("A2.theta", second_angle);
    linear.fitted = beside(linear.fitted, effect);
    linear.coefficients_of_effect = {{0}};  // readings are those of the model with the effect
    linear.readings = normal_matrix(random, effect.rows(), 1) +
                      0.7 * column("A3.theta", first_angle) + 0.9 * effect;
    const Eigen::VectorXd all = linear.fitted.householderQr().solve(linear.readings);
    // As calibration hands them over: the effect's coefficient is in the model already.
    linear.coefficients_of_effect = {{all[5]}};
    linear.readings -= linear.fitted * all;
  }

  Eigen::VectorXd column(const std::string& parameter, double (*value)(const JointVector&)) const {
    Eigen::VectorXd column = linear.jacobian.col(parameter_by_hand(parameter));
    for (int row = 0; row < campaign.rows(); ++row)
      column.segment<3>(3 * row) *= value(campaign.q[row]);
    return column;
  }

  Eigen::MatrixXd columns(int candidate) const {
    if (candidate == 0) return column("A3.theta", first_angle);
    if (candidate == 1)
      return beside(column("A3.theta", sine_of_fifth), column("A3.theta", cosine_of_fifth));
    if (candidate == 2) return column("A5.alpha", second_angle);
    Eigen::MatrixXd six(linear.jacobian.rows(), 0);
    for (const std::string axis : {"x", "y", "z", "rx", "ry", "rz"})
      six = beside(six, column("base." + axis, fourth_angle));
    return six;
  }
};

// The candidates projected off the fit.
struct ProjectedProblem : Problem {
  const Linearization fit{linear};
  const CandidateScan scan{candidates, robot_by_hand(), campaign};
  const ProjectedCandidates projected{scan, fit};
};

TEST(Projection, GainIsTheFallOfTheSumOfSquaresOfAWholeFit) {
  const ProjectedProblem problem;
  const ProjectedCandidates& projected = problem.projected;
  const std::vector<CandidateScore> scores = projected.scores();
  const Eigen::MatrixXd& model = problem.linear.fitted;
  const Eigen::VectorXd& readings = problem.linear.readings;
  const double before = squares_left(model, readings);
  EXPECT_NEAR(problem.fit.residual_norm(), before, 1e-10 * before);
  ASSERT_EQ(scores.size(), 4u);
  for (int k = 0; k < 4; ++k) {
    const Eigen::MatrixXd own = problem.columns(k);
    const Eigen::MatrixXd all = beside(model, own);
    const double gain = before - squares_left(all, readings);
    EXPECT_NEAR(scores[k].gain, gain, kFloat * before) << k;
    EXPECT_EQ(scores[k].degrees_of_freedom, own.cols()) << k;
    const Eigen::VectorXd coefficients = all.householderQr().solve(readings).tail(own.cols());
    EXPECT_LT((scores[k].coefficients - coefficients).norm(), 1e-4 * coefficients.norm()) << k;
    const Candidate& candidate = problem.candidates[k];
    const double freedom = 180 - 6;  // equations less unknowns: all readings independent
    EXPECT_NEAR(scores[k].score,
                ebic_fall(is_shrunken(candidate.effect), candidate.log_choices,
                          static_cast<int>(own.cols()), gain, before, freedom),
                1e-3)
        << k;
    const Eigen::MatrixXd directions = projected.directions(k).at_rows;
    EXPECT_LT((model.transpose() * directions).norm(), 1e-4) << k;
    EXPECT_NEAR((directions.transpose() * readings).squaredNorm(), gain, kFloat * before) << k;
  }
  EXPECT_GT(scores[0].gain, 5 * scores[2].gain);  // the one that is in the readings
}

// 250 poses, and so many frequencies that products with them come from nodes.
TEST(Projection, GainOfCyclesIsTheFallOfTheSumOfSquaresOfAWholeFit) {
  Random random{5};
  const Campaign campaign = angles_by_hand(random, 250);
  LinearProblem linear = problem_by_hand(random, campaign, 5);
  std::vector<Candidate> candidates;
  constexpr double kStep = 0.5, kFirst = 2.25;
  for (double n = kFirst; n < 300; n += kStep) {
    candidates.push_back(candidate_of("A3.theta", 4, ShapeKind::harmonic));
    candidates.back().effect.shape.harmonic = n;
    candidates.back().frequency_resolution = 4 * kStep;
  }
  candidates.push_back(candidate_of("A3.theta", 4));  // a column of its own before the cycles
  const auto columns_at = [&](double n) {
    Eigen::MatrixXd columns = linear.jacobian.col(parameter_by_hand("A3.theta")).replicate(1, 2);
    for (int row = 0; row < campaign.rows(); ++row) {
      columns.col(0).segment<3>(3 * row) *= std::sin(n * campaign.q[row][4]);
      columns.col(1).segment<3>(3 * row) *= std::cos(n * campaign.q[row][4]);
    }
    return columns;
  };
  linear.readings =
      normal_matrix(random, 3 * campaign.rows(), 1) + 0.8 * columns_at(kFirst + 200 * kStep).col(1);
  const double before = squares_left(linear.fitted, linear.readings);
  const Linearization fit{linear};
  const CandidateScan scan{candidates, robot_by_hand(), campaign};
  const std::vector<CandidateScore> scores = ProjectedCandidates{scan, fit}.scores();
  for (int k = 0; k < std::ssize(candidates) - 1; k += 20) {
    const Eigen::MatrixXd all = beside(linear.fitted, columns_at(kFirst + k * kStep));
    const double gain = before - squares_left(all, linear.readings);
    EXPECT_NEAR(scores[k].gain, gain, kFloat * before) << k;
    const Eigen::VectorXd coefficients = all.householderQr().solve(linear.readings).tail(2);
    EXPECT_LT((scores[k].coefficients - coefficients).norm(), 1e-5) << k;
  }
  EXPECT_EQ(best_first(scores).front(), 200);
}

TEST(Projection, InThePlaceOfAnEffectIsAFitWithoutIt) {
  const ProjectedProblem problem;
  const ProjectedCandidates& projected = problem.projected;
  const std::vector<CandidateScore> scores = projected.scores_without({0});
  const Eigen::MatrixXd rest = problem.linear.fitted.leftCols<5>();
  const Eigen::VectorXd readings =
      problem.linear.readings + problem.linear.coefficients_of_effect[0][0] * problem.effect;
  const double before = squares_left(rest, readings);
  for (int k = 0; k < 4; ++k) {
    const double gain = before - squares_left(beside(rest, problem.columns(k)), readings);
    EXPECT_NEAR(scores[k].gain, gain, kFloat * before) << k;
  }
  const CandidateScore own = score_of(problem.fit, problem.fit.without({0}), false, 1.25);
  const double gain = before - squares_left(problem.linear.fitted, readings);
  EXPECT_NEAR(own.gain, gain, 1e-9 * gain);
  EXPECT_EQ(own.degrees_of_freedom, 1);
  EXPECT_NEAR(own.score, ebic_fall(false, 1.25, 1, gain, before, 180 - 6), 1e-9);
}

// The lengths of wires, read without the other effects, grow as all lengths do but for a hundred
// thousandth of these effects.
TEST(Projection, WhatCannotBeSeenTakesNoEffectsPlace) {
  Random random{7};
  const Campaign campaign = angles_by_hand(random, 60);
  LinearProblem linear = problem_by_hand(random, campaign, 5);
  const Eigen::MatrixXd rest = linear.fitted;
  const Eigen::MatrixXd backlash = normal_matrix(random, 180, 2);
  const Eigen::Vector2d coefficients(0.8, -1.5);
  linear.readings = 0.1 * normal_matrix(random, 180, 1);
  linear.coefficients_of_effect = {{coefficients[0], coefficients[1]}, {0.01}};
  linear.most = {10, 10, 0.1};
  const Eigen::VectorXd readings = linear.readings + backlash * coefficients;
  const double gain = squares_left(rest, readings) - squares_left(beside(rest, backlash), readings);
  for (const double besides : {0.0, 1e-7}) {
    const Eigen::MatrixXd wire =
        rest.col(2) + 1e-5 * backlash * coefficients + besides * normal_matrix(random, 180, 1);
    linear.fitted = beside(beside(rest, backlash), wire);
    const Linearization fit{linear};
    const Linearization::Loss loss = fit.without({0});
    EXPECT_EQ(loss.span.cols(), 2);
    EXPECT_NEAR(loss.residual.squaredNorm(), gain, 1e-3 * gain);
    EXPECT_EQ(fit.without({1}).span.cols(), 0);
    EXPECT_EQ(fit.basis().cols(), 7);
  }
  // With coefficients of thousands it could.
  linear.most.back() = 1e6;
  EXPECT_LT(Linearization{linear}.without({0}).residual.squaredNorm(), 0.5 * gain);
}

// A candidate that cannot score more than the least is left out, any other is scored as before.
TEST(Projection, BoundLeavesOutOnlyWhatCannotScoreMore) {
  const ProjectedProblem problem;
  const ProjectedCandidates& projected = problem.projected;
  const std::vector<CandidateScore> all = projected.scores_without({0});
  int left_out = 0;
  for (const double least : {-40.0, 0.0, 5.0, all[0].score - 1, all[0].score + 30}) {
    const std::vector<CandidateScore> above = projected.scores_above(least, {0});
    for (size_t k = 0; k < all.size(); ++k) {
      if (all[k].score > least) EXPECT_EQ(above[k].score, all[k].score) << k;
      left_out += above[k].score == -std::numeric_limits<double>::infinity();
    }
  }
  EXPECT_GE(left_out, 6);  // the bound is worth something
}

TEST(Projection, OnlyCandidatesThatAreAskedForAreScored) {
  const ProjectedProblem problem;
  const ProjectedCandidates& projected = problem.projected;
  const std::vector<CandidateScore> all = projected.scores_without({0});
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  const std::vector<CandidateScore> one =
      projected.scores_above(kNone, {0}, [](int candidate) { return candidate == 1; });
  for (size_t k = 0; k < all.size(); ++k) EXPECT_EQ(one[k].score, k == 1 ? all[k].score : kNone);
}

// In the place of an effect nothing is left out that imitates it or scores more than the least.
TEST(Projection, InPlaceOfAnEffectOnlyWhatIsNeitherRivalNorBetterIsLeftOut) {
  const ProjectedProblem problem;
  const ProjectedCandidates& projected = problem.projected;
  const ProjectedCandidates::InPlace all = projected.in_place_of(0);
  int left_out = 0;
  for (const double least : {0.0, all.scores[0].score + 30})
    for (const double imitation : {1e-3, 0.5}) {
      const ProjectedCandidates::InPlace some = projected.in_place_of(0, least, imitation);
      for (size_t k = 0; k < all.scores.size(); ++k) {
        if (all.scores[k].score > least || all.imitations[k].gain >= imitation) {
          EXPECT_EQ(some.scores[k].score, all.scores[k].score) << k;
          EXPECT_EQ(some.imitations[k].gain, all.imitations[k].gain) << k;
        }
        left_out += some.scores[k].degrees_of_freedom == 0;
      }
    }
  EXPECT_GE(left_out, 3);  // the bounds are worth something
}

// Nearly dependent columns, some of them too near for a Gram matrix: the basis is orthonormal, and
// the residual that of Householder's reflections.
TEST(Projection, BasisIsOrthonormalHoweverNearTheColumnsAre) {
  for (const double apart : {1.0, 1e-3, 1e-4, 1e-6}) {
    Problem problem;
    problem.linear.fitted.col(1) =
        problem.linear.fitted.col(0) + apart * problem.linear.fitted.col(1);
    problem.linear.readings += 0.3 * problem.linear.fitted.col(2);
    const Linearization fit(problem.linear);
    const Eigen::MatrixXd& basis = fit.basis();
    ASSERT_EQ(basis.cols(), 6);
    EXPECT_LT((basis.transpose() * basis - Eigen::MatrixXd::Identity(6, 6)).norm(), 1e-13) << apart;
    const Eigen::VectorXd& readings = problem.linear.readings;
    const Eigen::VectorXd all = problem.linear.fitted.householderQr().solve(readings);
    const Eigen::VectorXd residual = readings - problem.linear.fitted * all;
    EXPECT_LT((fit.residual() - residual).norm(), 1e-8 * residual.norm()) << apart;
  }
}

// Sums of others, and columns that differ from one by less and less, among them.
TEST(Projection, BasisSpansColumnsThatNearlyDependOnEachOther) {
  Problem problem;
  const Eigen::Index rows = problem.linear.fitted.rows();
  constexpr int kOwn = 20, kNear = 5;
  Eigen::MatrixXd own = normal_matrix(problem.random, rows, kOwn), columns(rows, 0);
  for (int k = 0; k < kOwn; ++k) {
    columns = beside(columns, own.leftCols(k + 1).rowwise().sum());
    if (k < kNear)
      columns = beside(columns,
                       own.col(k) + std::pow(10, -4 - k) * normal_matrix(problem.random, rows, 1));
    columns = beside(columns, own.col(k));
  }
  problem.linear.fitted = columns;
  problem.linear.coefficients_of_effect.clear();
  const Eigen::MatrixXd basis = Linearization(problem.linear).basis();
  ASSERT_EQ(basis.cols(), kOwn + kNear);
  EXPECT_LT((basis.transpose() * basis - Eigen::MatrixXd::Identity(25, 25)).norm(), 1e-12);
  EXPECT_LT((columns - basis * (basis.transpose() * columns)).norm(), 1e-12 * columns.norm());
}

// The same where columns of the model depend on each other, and no dual of them exists.
TEST(Projection, DependentColumnsOfTheModelChangeNothing) {
  Problem problem;
  const Linearization fit(problem.linear);
  problem.linear.fitted = beside(problem.linear.fitted.leftCols<5>().eval(),
                                 beside(problem.linear.fitted.col(1), problem.effect));
  problem.linear.geometric = 6;
  const Linearization dependent(problem.linear);
  ASSERT_EQ(dependent.basis().cols(), fit.basis().cols());
  const CandidateScan scan(problem.candidates, robot_by_hand(), problem.campaign);
  const ProjectedCandidates one(scan, fit), other(scan, dependent);
  const double own = score_of(fit, fit.without({0}), false, 1).gain;
  EXPECT_NEAR(score_of(dependent, dependent.without({0}), false, 1).gain, own, 1e-9 * own);
  for (int k = 0; k < 4; ++k)
    EXPECT_NEAR(other.scores_without({0})[k].gain, one.scores_without({0})[k].gain, 1e-6 * own);
}

// A curve whose columns add up to a constant that the geometry has: only the rest of it is its own.
TEST(Projection, WhatAnEffectSharesWithTheModelIsNotItsOwn) {
  Problem problem;
  const Linearization fit(problem.linear);
  problem.linear.fitted =
      beside(problem.linear.fitted, problem.linear.fitted.col(2) - problem.effect);
  problem.linear.coefficients_of_effect[0].push_back(0);
  const Linearization curve(problem.linear);
  ASSERT_EQ(curve.basis().cols(), 6);
  const Linearization::Loss loss = curve.without({0}), alone = fit.without({0});
  ASSERT_EQ(loss.span.cols(), 1);
  const Eigen::VectorXd direction = curve.basis() * loss.span;
  EXPECT_NEAR(std::abs(direction.dot((fit.basis() * alone.span).col(0))), 1, 1e-9);
  EXPECT_NEAR(std::abs(loss.residual[0]), std::abs(alone.residual[0]),
              1e-9 * std::abs(alone.residual[0]));
  EXPECT_EQ(curve.without({}).span.cols(), 0);
}

// cos^2 of the angle between the column of the effect and those of the candidate, both projected
// off the other columns of the model.
TEST(Projection, CorrelationOfAnImitationIsTheCosineOfThePrincipalAngle) {
  const Problem problem;
  const Linearization fit(problem.linear);
  const CandidateScan scan(problem.candidates, robot_by_hand(), problem.campaign);
  const std::vector<CandidateScore> imitations =
      ProjectedCandidates(scan, fit).in_place_of(0).imitations;
  const Eigen::MatrixXd rest = problem.linear.fitted.leftCols<5>();
  const auto off_the_rest = [&](const Eigen::MatrixXd& columns) -> Eigen::MatrixXd {
    return columns - rest * rest.householderQr().solve(columns);
  };
  const Eigen::VectorXd effect = off_the_rest(problem.effect).col(0);
  const double size = problem.linear.coefficients_of_effect[0][0];
  for (int k = 0; k < 4; ++k) {
    const Eigen::MatrixXd own = off_the_rest(problem.columns(k));
    const Eigen::VectorXd closest = own.householderQr().solve(effect);
    const double cosine = (own * closest).norm() / effect.norm();
    EXPECT_NEAR(std::sqrt(imitations[k].gain), cosine, 1e-4) << k;
    EXPECT_LT((imitations[k].coefficients - size * closest).norm(), 1e-3 * (size * closest).norm())
        << k;
  }
}

TEST(Projection, ATwinImitatesAnEffectWholly) {
  const Problem problem;
  const Linearization fit(problem.linear);
  const CandidateScan scan({candidate_of("A2.theta", 1)}, robot_by_hand(), problem.campaign);
  const CandidateScore twin = ProjectedCandidates(scan, fit).in_place_of(0).imitations.front();
  EXPECT_NEAR(twin.gain, 1, 1e-6);
  EXPECT_NEAR(twin.coefficients[0], problem.linear.coefficients_of_effect[0][0],
              kFloat * std::abs(twin.coefficients[0]));
}

TEST(Projection, ACollinearCandidateHasNoDegreeOfFreedom) {
  Problem problem;
  // A parameter whose derivatives the model spans, whatever the joint does, and one by half.
  const int spanned = parameter_by_hand("A5.alpha");
  problem.linear.jacobian.col(spanned) = problem.linear.fitted.col(2);
  for (auto q : problem.campaign.q) q[1] = 0.75;  // a driver that did not move
  const Linearization fit(problem.linear);
  const CandidateScan scan(problem.candidates, robot_by_hand(), problem.campaign);
  const std::vector<CandidateScore> scores = ProjectedCandidates(scan, fit).scores();
  EXPECT_EQ(scores[2].degrees_of_freedom, 0);
  EXPECT_EQ(scores[2].score, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(scores[2].gain, 0);
  EXPECT_LT(scores[2].unexplained_share, kFloat);
  // The share of the column's norm that is left, by an explicit projection.
  const Eigen::VectorXd column = problem.columns(0);
  const double share = std::sqrt(squares_left(problem.linear.fitted, column)) / column.norm();
  EXPECT_NEAR(scores[0].unexplained_share, share, kFloat);
}

// Of 21 equations the model leaves 6: five cosines explain of noise what they like. One column is
// judged.
TEST(Projection, ACurveThatTakesNearlyAllFreedomIsNoEvidence) {
  Random random(4);
  const Campaign campaign = angles_by_hand(random, 7);
  LinearProblem linear = problem_by_hand(random, campaign, 15);
  linear.readings = normal_matrix(random, 21, 1);
  std::vector<Candidate> candidates(2, candidate_of("A3.theta", 4));
  candidates[0].effect.shape = series_shape(SeriesBasis::cosine, 5, -1.5, 1.5);
  const Linearization fit(linear);
  const CandidateScan scan(candidates, robot_by_hand(), campaign);
  const ProjectedCandidates projected(scan, fit);
  const std::vector<CandidateScore> scores = projected.scores();
  EXPECT_EQ(fit.residual_freedom(), 6);
  EXPECT_EQ(scores[0].degrees_of_freedom, 5);
  EXPECT_EQ(scores[0].score, -std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isfinite(scores[1].score));
}

// Steps on both sides of a reading, 0.3 urad apart: one of the four readings is on the other side.
TEST(CandidateScan, TellsPlacesApartThatDifferByLessThanSixDecimals) {
  Campaign campaign;
  for (const double angle : {0.0, 0.1000002, 0.2, 0.3}) {
    campaign.pose.push_back(static_cast<int>(campaign.pose.size()));
    campaign.pose_ids.push_back(std::to_string(campaign.pose.back()));
    campaign.q.push_back(JointVector::Constant(6, angle));
    campaign.position.emplace_back(0, 0, 0);
  }
  std::vector<Candidate> steps(2, candidate_of("A1.theta", 0, ShapeKind::step));
  steps[0].effect.shape.at = 0.1000001;
  steps[1].effect.shape.at = 0.1000004;
  const CandidateScan scan(steps, robot_by_hand(), campaign);
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(1);
  const double possible = 0.02;  // deviation of what an effect may add [rad]
  EXPECT_NEAR(scan.share_of_possible(0, one), std::sqrt(3.0) / 4 / possible, 1e-6);
  EXPECT_NEAR(scan.share_of_possible(1, one), 0.5 / possible, 1e-6);
}

TEST(BestFirst, KeepsTheOrderOfScoresThatDifferByRounding) {
  std::vector<CandidateScore> scores(4);
  scores[0].score = 1.0;
  scores[1].score = 5.001;
  scores[2].score = 5.003;
  scores[3].score = 7.0;
  EXPECT_EQ(best_first(scores), (std::vector<int>{3, 1, 2, 0}));
}

}  // namespace
}  // namespace armtrue::projection_test
