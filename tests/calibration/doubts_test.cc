#include "armtrue/calibration/doubts.h"

#include <gmock/gmock.h>

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "armtrue/campaign/simulation.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/io/robot_io.h"
#include "linear_algebra/decompositions.h"

namespace armtrue::doubts_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

// 60 poses read one after the other, on two targets each.
Campaign sixty_poses() {
  Campaign campaign;
  campaign.target_names = {"left", "right"};
  for (int row = 0; row < 120; ++row) {
    campaign.q.emplace_back();
    campaign.pose.push_back(row / 2);
    campaign.line.push_back(row + 2);
    campaign.time_s.push_back(10.0 * row);
    campaign.target.push_back(row % 2);
  }
  return campaign;
}

TEST(LeftOutTogether, BlundersAtRandomAreNoFault) {
  const Campaign campaign = sixty_poses();
  std::mt19937 random(1);
  int named = 0;
  for (int draw = 0; draw < 200; ++draw) {
    std::vector<int> lines = campaign.line;
    std::ranges::shuffle(lines, random);
    lines.resize(12);
    std::ranges::sort(lines);
    named += !left_out_together(campaign, lines).empty();
  }
  EXPECT_LE(named, 2);  // at 1 in 1000
  EXPECT_THAT(left_out_together(campaign, {}), IsEmpty());
}

TEST(LeftOutTogether, AStretchOfVisitsIsNamed) {
  const Campaign campaign = sixty_poses();
  // Poses 20 to 25, one target or both, and a blunder elsewhere.
  EXPECT_THAT(left_out_together(campaign, {6, 42, 43, 44, 47, 48, 51, 52}),
              HasSubstr("left out in 6 of 6 visits from t_s = 400 to t_s = 510"));
  // Also with some between them that are good enough to stay.
  EXPECT_THAT(left_out_together(campaign, {42, 44, 48, 50, 52, 54, 58, 60, 62, 64}),
              HasSubstr("left out in 10 of 12 visits from t_s = 400"));
  // Two neighbours may be chance.
  EXPECT_THAT(left_out_together(campaign, {6, 42, 44}), IsEmpty());
}

TEST(LeftOutTogether, ABadReflectorIsNamed) {
  const Campaign campaign = sixty_poses();
  EXPECT_THAT(left_out_together(campaign, {3, 11, 19, 31, 45, 51, 67, 75, 83, 91, 99, 111}),
              HasSubstr("in 12 of 60 poses readings of the target 'right' are left out"));
}

// A socket that was moved, and a wire that hung.
TEST(LeftOutTogether, AContactOrAnAnchorIsNamed) {
  const std::vector<int> lines{3, 11, 19, 31, 45, 51, 67, 75, 83, 91, 99, 111};
  Campaign touches = sixty_poses();
  touches.target.clear();
  touches.target_names.clear();
  touches.distance.assign(120, 0.0);
  touches.contact_names = {"socket", "cube/left", "cube/right"};
  for (int row = 0; row < 120; ++row) {
    Touch& touch = touches.touch.emplace_back();
    touch.contact = row % 2 == 0 ? 0 : 1 + row / 2 % 2;
    touch.axis = 0;
  }
  EXPECT_THAT(left_out_together(touches, lines),
              HasSubstr("in 12 of 60 poses readings of the contact 'cube'"));
  touches.contact_names = {"laser:socket", "laser:cube/left", "probe:cube/right"};
  EXPECT_THAT(left_out_together(touches, lines),
              HasSubstr("in 12 of 60 poses readings of the contact 'cube'"))
      << "by whichever beam";
  Campaign wires = sixty_poses();
  wires.target.clear();
  wires.target_names.clear();
  wires.distance.assign(120, 0.0);
  wires.anchor_names = {"1", "2"};
  for (int row = 0; row < 120; ++row) wires.anchor.push_back(row % 2);
  EXPECT_THAT(left_out_together(wires, lines),
              HasSubstr("in 12 of 60 poses readings of the anchor '2'"));
}

// Six of 120 points on one of two targets may be chance; eighteen of 360 numbers would be none.
TEST(LeftOutTogether, APointInThreeRowsIsOneReading) {
  Campaign campaign = sixty_poses();
  for (int pose = 0; pose < 60; ++pose) campaign.pose_ids.push_back(std::to_string(pose));
  campaign.position.assign(120, Eigen::Vector3d::Zero());
  campaign.distance.assign(120, 0.0);
  points_to_coordinates(campaign);
  EXPECT_THAT(left_out_together(campaign, {3, 23, 43, 63, 83, 103}), IsEmpty());
}

TEST(ContradictionOfNoise, NamesReadingsThatScatterMoreOrMuchLess) {
  Robot robot;
  const Campaign campaign = sixty_poses();
  const auto said = [&](NoiseFloor::Source source, double floor, double sigma, double determined) {
    CalibrationResult fit;
    fit.sigma.position = fit.spread.position = sigma;
    fit.determined[0] = determined;
    const NoiseFloor noise{.source = source, .position = floor, .degrees_of_freedom = 180};
    return contradiction_of_noise(robot, campaign, fit, noise);
  };
  constexpr auto kReplicates = NoiseFloor::Source::replicates;
  constexpr auto kInstrument = NoiseFloor::Source::instrument;
  robot.noise.position = 1e-4;
  EXPECT_THAT(said(kReplicates, 1e-4, 1e-4, 30), IsEmpty());
  EXPECT_THAT(said(kReplicates, 1.2e-4, 2e-4, 30), IsEmpty());
  EXPECT_THAT(said(kReplicates, 3e-4, 3e-4, 30), HasSubstr("3 times as much"));
  EXPECT_THAT(said(kReplicates, 1e-5, 1e-5, 30), IsEmpty());  // the figure is not used
  EXPECT_THAT(said(kInstrument, 1e-4, 1e-5, 30), HasSubstr("scatter by 0.01 mm"));
  EXPECT_THAT(said(kInstrument, 1e-4, 1e-5, 358), IsEmpty());  // nearly all is fitted
  EXPECT_THAT(said(kInstrument, 1e-4, 1e-9, 30), IsEmpty());   // a simulation without noise
  CalibrationResult narrow;  // a law beside a few readings that are off by far
  narrow.sigma.position = 1e-5;
  narrow.spread.position = 9e-5;
  EXPECT_THAT(
      contradiction_of_noise(robot, campaign, narrow, {.source = kInstrument, .position = 1e-4}),
      IsEmpty());
  robot.noise.position = 0;
  EXPECT_THAT(said(kReplicates, 3e-4, 3e-4, 30), IsEmpty());
}

FitQuality of(const InstrumentNoise& left, const InstrumentNoise& pure) {
  FitQuality quality;
  quality.noise.source = NoiseFloor::Source::instrument;
  quality.left = left;
  quality.pure = pure;
  return quality;
}

TEST(FarAboveNoise, NamesWhatIsMoreThanFiveTimesTheNoise) {
  EXPECT_EQ(times_of_noise(of({0.9e-3, 0}, {0.2e-3, 0})), 1);
  EXPECT_THAT(far_above_noise(of({0.9e-3, 0}, {0.2e-3, 0})), IsEmpty());
  const FitQuality far = of({1.9e-3, 1e-3}, {0.2e-3, 0.5e-3});
  EXPECT_NEAR(times_of_noise(far), 9.5, 1e-9);
  EXPECT_THAT(far_above_noise(far), HasSubstr("by 1.9 mm per axis, 9.5 times the stated noise"));
  EXPECT_THAT(far_above_noise(of({0.2e-3, 3e-3}, {0.2e-3, 0.5e-3})),
              HasSubstr("by 3 mrad per axis, 6 times the stated noise"));
  EXPECT_EQ(times_of_noise(of({1.9e-3, 1e-3}, {0, 0})), 1);  // nothing is known
  // Rounding is no noise.
  EXPECT_EQ(times_of_noise(of({1e-9, 5e-16}, {1e-15, 2e-32})), 1);
}

// Readings of 25 poses, four of each, about what the fit says: an offset that the four share and
// noise. What `taken` directions of the poses hold of the means is gone, as after a fit of so many
// unknowns.
double mean_square_of_rest(double lack, double noise, int taken, bool states_noise) {
  constexpr int kPoses = 25, kVisits = 4, kDraws = 40;
  CalibrationResult fit;
  fit.robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  fit.robot.effects.clear();
  fit.robot.noise.position = states_noise ? noise : 0;
  fit.determined = {static_cast<double>(taken), 0};
  const RobotModel model(fit.robot);
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto draw = [&](Eigen::Index size) {
    return Eigen::VectorXd(Eigen::VectorXd::NullaryExpr(size, [&] { return normal(random); }));
  };
  double squares = 0;
  for (int k = 0; k < kDraws; ++k) {
    Campaign campaign;
    const Eigen::MatrixXd directions =
        Eigen::MatrixXd::NullaryExpr(3 * kPoses, taken, [&] { return normal(random); });
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(directions);
    const Eigen::MatrixXd basis = first_columns(qr.householderQ(), taken);
    std::vector<Eigen::VectorXd> errors;
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(3 * kPoses);
    const Eigen::VectorXd offset = lack * draw(3 * kPoses);
    for (int visit = 0; visit < kVisits; ++visit) {
      errors.emplace_back(offset + noise * draw(3 * kPoses));
      mean += errors.back() / kVisits;
    }
    for (int pose = 0; pose < kPoses; ++pose) {
      campaign.pose_ids.push_back(std::to_string(pose));
      const JointVector q = 0.5 * draw(6);
      for (const Eigen::VectorXd& error : errors) {
        campaign.q.push_back(q);
        campaign.pose.push_back(pose);
        campaign.line.push_back(campaign.rows() + 1);
        const Eigen::VectorXd left = error - basis * (basis.transpose() * mean);
        campaign.position.emplace_back(Eigen::Vector3d::Zero());
        campaign.position.back() = model.pose(campaign.context(campaign.rows() - 1)).translation +
                                   left.segment<3>(3 * pose);
      }
    }
    squares += std::pow(assess(fit, campaign).rest, 2) / kDraws;
  }
  return squares;
}

TEST(RestOfModel, IsWhatReadingsOfAPoseHaveInCommon) {
  // As in 100 readings 45 numbers of poses are left of 75: the mean of 40 draws errs by some 4 %.
  EXPECT_NEAR(mean_square_of_rest(2e-4, 1e-4, 30, false), 4e-8, 4e-9);
  EXPECT_NEAR(mean_square_of_rest(2e-4, 1e-4, 30, true), 4e-8, 4e-9);
  // Also where no test would find it: a half of the noise of a mean.
  const double small = mean_square_of_rest(0.5e-4, 1e-4, 30, false);
  EXPECT_NEAR(small, 0.25e-8, 0.08e-8);
  // Of nothing chance leaves little: the deviation of a mean square of 45 numbers is a fifth of it.
  EXPECT_LT(mean_square_of_rest(0, 1e-4, 30, false), 0.15 * 1e-8 / 4);
}

TEST(FarAboveNoise, WidensWhatIsSaidOfParametersAndCoefficients) {
  CalibrationResult fit;
  fit.robot.std["A2.d"] = 2e-3;
  fit.robot.sessions["monday"].std["base.x"] = 1e-3;
  Effect& effect = fit.robot.effects.emplace_back();
  effect.coefficients.push_back({.name = "c", .value = 5, .std = 1, .ci95 = {3, 8}});
  fit.covariance = Eigen::MatrixXd::Identity(2, 2);
  widen_deviations(10, fit);
  EXPECT_DOUBLE_EQ(fit.robot.std.at("A2.d"), 2e-2);
  EXPECT_DOUBLE_EQ(fit.robot.sessions.at("monday").std.at("base.x"), 1e-2);
  const Coefficient& c = fit.robot.effects[0].coefficients[0];
  EXPECT_DOUBLE_EQ(c.std, 10);
  EXPECT_DOUBLE_EQ(c.ci95[0], -15);
  EXPECT_DOUBLE_EQ(c.ci95[1], 35);
  EXPECT_EQ(fit.covariance, Eigen::MatrixXd::Identity(2, 2));
}

TEST(OffAsWholes, EachGetsItsSentence) {
  EXPECT_THAT(off_as_wholes({}), IsEmpty());
  EXPECT_THAT(off_as_wholes({{"P7", {3, 4}, 1.5e-3, "a target was bumped"}}),
              testing::ElementsAre(
                  "all readings of pose P7 share an error of 1.5 mm; it is left out: a target "
                  "was bumped"));
}

TEST(NotConverged, IsSaidOfAFitThatDidNot) {
  CalibrationResult fit;
  fit.converged = true;
  EXPECT_EQ(not_converged(fit), "");
  fit.converged = false;
  fit.iterations = 50;
  EXPECT_THAT(not_converged(fit), HasSubstr("not converged after 50 iterations"));
}

// Least squares of nine unknowns through the coordinates of random errors, of few poses and of
// many: the bound holds in 97.7 %.
TEST(MostWithHidden, HoldsAsOftenAsItSays) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto drawn = [&](auto&& matrix) {
    return matrix.unaryExpr([&](double) { return normal(random); });
  };
  for (const int numbers : {12, 15, 24, 120}) {
    constexpr int kUnknowns = 9, kDraws = 4000;
    const Eigen::MatrixXd columns = drawn(Eigen::MatrixXd::Zero(numbers, kUnknowns)).eval();
    const Eigen::HouseholderQR<Eigen::MatrixXd> fit(columns);
    const double most =
        most_with_hidden({kUnknowns, static_cast<double>(numbers - kUnknowns), ""}, 0.977);
    int held = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      const Eigen::VectorXd errors = drawn(Eigen::VectorXd::Zero(numbers)).eval();
      const Eigen::VectorXd left = errors - columns * fit.solve(errors);
      held += errors.norm() <= most * left.norm();
    }
    EXPECT_NEAR(held, 0.977 * kDraws, 4 * std::sqrt(0.977 * 0.023 * kDraws)) << numbers;
  }
  EXPECT_EQ(most_with_hidden({}, 0.977), 1);
  EXPECT_TRUE(std::isinf(most_with_hidden({9, 0, ""}, 0.977)));
}

// Base and tool are 12 numbers; 60 points are 180, of which they hide 3 %, and 5 points 15.
TEST(HiddenByRefit, IsSaidOfFewReadingsAlone) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  const auto of = [&](int poses) { return simulate(robot, robot, {.poses = poses, .seed = 3}); };
  EXPECT_EQ(hidden_by_refit({}, robot, of(5)).words, "");
  EXPECT_EQ(hidden_by_refit({"base", "tool"}, robot, of(120)).words, "");
  EXPECT_THAT(hidden_by_refit({"base", "tool"}, robot, of(5)).words,
              HasSubstr("--refit base,tool fits 12 unknowns to the 30 numbers"));
}

// A further session has six unknowns more: where its instrument stood.
TEST(HiddenByRefit, CountsTheBaseOfEachSession) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  Campaign campaign = simulate(robot, robot, {.poses = 20, .seed = 3});
  EXPECT_EQ(hidden_by_refit({"base", "tool"}, robot, campaign).unknowns, 12);
  begin_sessions(campaign, {campaign.time_s[10]});
  const HiddenError hidden = hidden_by_refit({"base", "tool"}, robot, campaign);
  EXPECT_EQ(hidden.unknowns, 18);
  EXPECT_EQ(hidden.freedom, 6 * 20 - 18);
}

}  // namespace
}  // namespace armtrue::doubts_test
