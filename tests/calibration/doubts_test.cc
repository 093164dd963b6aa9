#include "armtrue/calibration/doubts.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

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
              HasSubstr("12 of the 60 readings of target 'right'"));
}

TEST(ContradictionOfNoise, NamesReadingsThatScatterMoreOrMuchLess) {
  Robot robot;
  const Campaign campaign = sixty_poses();
  const auto said = [&](NoiseFloor::Source source, double floor, double sigma, double determined) {
    CalibrationResult fit;
    fit.sigma.position = sigma;
    fit.determined[0] = determined;
    return contradiction_of_noise(robot, campaign, fit, {source, 3, 1, floor, 0, 180});
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
  robot.noise.position = 0;
  EXPECT_THAT(said(kReplicates, 3e-4, 3e-4, 30), IsEmpty());
}

// 60 poses whose residuals have these deviations per axis; the fit has 36 unknowns of position.
struct Residuals {
  Campaign campaign;
  Evaluation evaluation;
  CalibrationResult fit;

  Residuals(double position, double orientation) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    fit.determined = {36, 0};
    const double of_unknowns = std::sqrt(1 - 36.0 / 1800);
    for (int row = 0; row < 600; ++row) {
      campaign.q.emplace_back();
      if (orientation > 0) campaign.orientation.emplace_back(Eigen::Quaterniond::Identity());
      Eigen::Matrix<double, 6, 1>& residual = evaluation.residuals.emplace_back();
      for (int i = 0; i < 3; ++i) residual[i] = position * of_unknowns * normal(random);
      for (int i = 3; i < 6; ++i) residual[i] = orientation * normal(random);
    }
  }
  double times(const NoiseFloor& noise) const {
    return times_of_noise(fit, campaign, evaluation, noise);
  }
  std::string said(const NoiseFloor& noise) const {
    return far_above_noise(fit, campaign, evaluation, noise);
  }
};

NoiseFloor stated(double position, double orientation) {
  NoiseFloor noise;
  noise.source = NoiseFloor::Source::instrument;
  noise.position = position;
  noise.orientation = orientation;
  return noise;
}

TEST(FarAboveNoise, NamesWhatIsMoreThanFiveTimesTheNoise) {
  const Residuals near(0.9e-3, 0), far(1.9e-3, 0), turned(0.2e-3, 3e-3);
  EXPECT_EQ(near.times(stated(0.2e-3, 0)), 1);
  EXPECT_THAT(near.said(stated(0.2e-3, 0)), IsEmpty());
  EXPECT_NEAR(far.times(stated(0.2e-3, 0)), 9.5, 0.4);
  EXPECT_THAT(far.said(stated(0.2e-3, 0)), HasSubstr(" mm per axis, 9."));
  EXPECT_THAT(far.said(stated(0.2e-3, 0)), HasSubstr("times the stated noise"));
  EXPECT_NEAR(turned.times(stated(0.2e-3, 0.5e-3)), 6, 0.3);
  EXPECT_THAT(turned.said(stated(0.2e-3, 0.5e-3)), HasSubstr(" mrad per axis, "));
  EXPECT_EQ(far.times(NoiseFloor{}), 1);  // nothing is known
}

TEST(FarAboveNoise, PosesThatAreReadWorseAreNoModelThatIs) {
  Residuals readings(0.1e-3, 0);
  for (size_t row = 0; row < 120; ++row) readings.evaluation.residuals[row] *= 20;
  EXPECT_EQ(readings.times(stated(0.1e-3, 0)), 1);
  // Where the rows say so it matters less still: each counts by its own deviation.
  for (size_t row = 0; row < 600; ++row)
    readings.campaign.sigma_position.push_back(row < 120 ? 2e-3 : 0.1e-3);
  EXPECT_EQ(readings.times(stated(0.1e-3, 0)), 1);
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

}  // namespace
}  // namespace armtrue::doubts_test
