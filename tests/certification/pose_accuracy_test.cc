#include "armtrue/certification/pose_accuracy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "armtrue/kinematics/pose.h"

namespace armtrue::pose_accuracy_test {
namespace {

using Eigen::Vector3d;
using testing::ElementsAre;

constexpr double kTolerance = 1e-12;

Visit visit_at(const Vector3d& error) {
  Visit visit;
  visit.attained = Vector3d(1.5, -0.2, 0.9) + error;
  visit.error = error;
  return visit;
}

// Four visits about the barycentre (3, 4, 0) mm from the command.
std::vector<Visit> four_visits() {
  const Vector3d mean(3e-3, 4e-3, 0);
  return {visit_at(mean + Vector3d(1e-3, 0, 0)), visit_at(mean - Vector3d(1e-3, 0, 0)),
          visit_at(mean + Vector3d(0, 0, 2e-3)), visit_at(mean - Vector3d(0, 0, 2e-3))};
}

// By hand, mm: AP = sqrt(3^2 + 4^2) = 5. l = 1, 1, 2, 2: mean 1.5, S^2 = 4 x 0.5^2 / 3 = 1/3,
// RP = 1.5 + 3 / sqrt(3) = 3.232051.
TEST(PoseAccuracy, OfFourVisitsIsThatOfTheStandardsFormulas) {
  const PoseFigures figures = pose_figures("P1", four_visits());
  EXPECT_EQ(figures.visits, 4);
  EXPECT_NEAR(figures.ap, 5e-3, kTolerance);
  EXPECT_NEAR(figures.ap_axes.x(), 3e-3, kTolerance);
  EXPECT_NEAR(figures.ap_axes.y(), 4e-3, kTolerance);
  EXPECT_NEAR(figures.ap_axes.z(), 0, kTolerance);
  EXPECT_NEAR(figures.rp, 3.232050807568877e-3, kTolerance);
  EXPECT_FALSE(figures.vap || figures.drift_ap || figures.ap_turn);
}

// l = 1, 1 however the visits scatter: S is 0, and shows nothing.
TEST(PoseAccuracy, TwoVisitsDoNotShowHowUncertainTheirRepeatabilityIs) {
  std::vector<Visit> visits = four_visits();
  visits.resize(2);
  const PoseFigures figures = pose_figures("P1", visits);
  EXPECT_NEAR(figures.rp, 1e-3, kTolerance);
  EXPECT_FALSE(largest_of({figures}).rp_expanded());
}

// The error of the prediction may differ between visits; the attained poses repeat exactly.
TEST(PoseAccuracy, RepeatabilityIsOfAttainedPosesNotOfErrors) {
  std::vector<Visit> visits{visit_at(Vector3d::Zero()), visit_at(Vector3d::Zero())};
  visits[0].error.x() = 2e-3;
  const PoseFigures figures = pose_figures("P1", visits);
  EXPECT_NEAR(figures.ap, 1e-3, kTolerance);
  EXPECT_NEAR(figures.rp, 0, kTolerance);
}

// Turns about z of 1, 2 and 3 mrad: AP_c = 2, S = 1, RP_c = 3 mrad; about x all are -4 mrad off.
TEST(PoseAccuracy, OfAnglesIsTheirMeanAndThreeDeviations) {
  std::vector<Visit> visits;
  const Eigen::Matrix3d command = rotation_from_abc(0.3, -1.1, 2.0);
  for (double turn : {1e-3, 2e-3, 3e-3}) {
    Visit visit = visit_at(Vector3d::Zero());
    visit.turn_error = Vector3d(-4e-3, 0, turn);
    visit.orientation = rotation_exp({0, 0, turn}) * command;
    visits.push_back(visit);
  }
  const PoseFigures figures = pose_figures("P1", visits);
  EXPECT_NEAR(figures.ap_turn->x(), -4e-3, kTolerance);
  EXPECT_NEAR(figures.ap_turn->z(), 2e-3, kTolerance);
  EXPECT_NEAR(figures.rp_turn->x(), 0, 1e-9);
  EXPECT_NEAR(figures.rp_turn->z(), 3e-3, 1e-9);
}

// Means of two directions at (0, 0, 0) and (0.3, 0.4, 0) mm; a third direction has one visit only.
// Turns of one orientation that differ by rounding alone, from two directions, early and late.
TEST(PoseAccuracy, ASpreadThatRoundingMakesIsNone) {
  std::vector<Visit> visits;
  for (int k = 0; k < 8; ++k) {
    Visit visit = visit_at(Vector3d(1e-3, 0, 0));
    visit.attained *= 1 + 2e-16 * (k % 2);
    visit.turn_error = Vector3d(1e-17 * k, 0, 1e-3);
    visit.orientation = rotation_from_abc(0.3 + 1e-16 * k, -1.1, 2.0);
    visit.arrival[0] = k % 2 == 0 ? 1 : -1;
    visit.time_s = k;
    visits.push_back(visit);
  }
  const PoseFigures figures = pose_figures("P1", visits);
  EXPECT_EQ(figures.rp, 0);
  EXPECT_EQ(figures.squared_scatter, 0);
  EXPECT_EQ(*figures.rp_turn, Vector3d::Zero());
  EXPECT_EQ(*figures.vap, 0);
  EXPECT_EQ(*figures.vap_turn, Vector3d::Zero());
  EXPECT_EQ(*figures.drift_ap, 0);
  EXPECT_EQ(*figures.drift_rp, 0);
  EXPECT_EQ(*figures.drift_ap_turn, Vector3d::Zero());
  EXPECT_EQ(*figures.drift_rp_turn, Vector3d::Zero());
}

TEST(PoseAccuracy, VariationBetweenDirectionsIsTheDistanceOfTheirMeans) {
  std::vector<Visit> visits;
  const auto add = [&](const Vector3d& error, std::int8_t sign) {
    visits.push_back(visit_at(error));
    visits.back().arrival[2] = sign;
  };
  add({0.1e-3, 0, 0}, 1);
  add({-0.1e-3, 0, 0}, 1);
  add({0.3e-3, 0.5e-3, 0}, -1);
  add({0.3e-3, 0.3e-3, 0}, -1);
  add({9e-3, 0, 0}, 0);  // not known
  EXPECT_NEAR(*pose_figures("P1", visits).vap, 0.5e-3, kTolerance);
  visits.push_back(visit_at({7e-3, 0, 0}));
  visits.back().arrival[0] = 1;
  const PoseFigures figures = pose_figures("P1", visits);
  EXPECT_NEAR(*figures.vap, 0.5e-3, kTolerance);
  EXPECT_EQ(figures.directions, 3);
}

// First two visits: AP 1, RP 0.1 mm (l = 0.1, 0.1). Last two: AP 3, RP 0.4 mm. Not in order.
TEST(PoseAccuracy, DriftIsThatOfTheLastHalfAgainstTheFirst) {
  std::vector<Visit> visits{visit_at({3.4e-3, 0, 0}), visit_at({1.1e-3, 0, 0}),
                            visit_at({2.6e-3, 0, 0}), visit_at({0.9e-3, 0, 0})};
  const double times[] = {300, 0, 400, 100};
  for (size_t j = 0; j < 4; ++j) visits[j].time_s = times[j];
  const PoseFigures figures = pose_figures("P1", visits);
  EXPECT_NEAR(*figures.drift_ap, 2e-3, kTolerance);
  EXPECT_NEAR(*figures.drift_rp, 0.3e-3, kTolerance);
  visits.pop_back();
  EXPECT_FALSE(pose_figures("P1", visits).drift_ap);
}

// Turns [mrad] from the direction + of (1, 0, 0) and (3, 0, 2), mean (2, 0, 1); from - of (0, 1, 1)
// and (0, 1, 1): vAP = (2, 1, 0). First two visits in time: mean (2, 0, 1), 3 S = 3 sqrt(2) (1, 0,
// 1) mrad about x and z, as S^2 = (1 + 1) / 1; last two: mean (0, 1, 1), 3 S = 0.
TEST(PoseAccuracy, VariationAndDriftOfAnglesAreByAxis) {
  std::vector<Visit> visits;
  const Eigen::Matrix3d command = rotation_from_abc(0.3, -1.1, 2.0);
  const Vector3d turns[] = {{1, 0, 0}, {3, 0, 2}, {0, 1, 1}, {0, 1, 1}};
  for (size_t j = 0; j < 4; ++j) {
    Visit visit = visit_at(Vector3d::Zero());
    visit.turn_error = 1e-3 * turns[j];
    visit.orientation = rotation_exp(visit.turn_error) * command;
    visit.arrival[0] = j < 2 ? 1 : -1;
    visit.time_s = 10.0 * static_cast<double>(j);
    visits.push_back(visit);
  }
  const PoseFigures figures = pose_figures("P1", visits);
  EXPECT_NEAR((*figures.vap_turn - Vector3d(2e-3, 1e-3, 0)).norm(), 0, kTolerance);
  EXPECT_NEAR((*figures.drift_ap_turn - Vector3d(2e-3, 1e-3, 0)).norm(), 0, kTolerance);
  constexpr double kSecondOrder = 1e-5;  // turns of some mrad do not quite add up
  EXPECT_NEAR((*figures.drift_rp_turn - 3e-3 * std::sqrt(2.0) * Vector3d(1, 0, 1)).norm(), 0,
              kSecondOrder);
  const SetFigures set = largest_of({figures});
  EXPECT_NEAR(set.vap_turn->value, 2e-3, kTolerance);
  EXPECT_NEAR(set.drift_ap_turn->value, 2e-3, kTolerance);
  EXPECT_NEAR(set.drift_rp_turn->value, 3e-3 * std::sqrt(2.0), kSecondOrder);
  visits[0].orientation.reset();
  EXPECT_FALSE(pose_figures("P1", visits).vap_turn);
}

TEST(PoseAccuracy, OfOneVisitIsRefused) {
  EXPECT_THROW(pose_figures("P1", {visit_at(Vector3d::Zero())}), std::invalid_argument);
}

// Poses A, B, C; C has one visit, the visits of B follow each other.
struct ThreePoses {
  Campaign campaign;
  Evaluation evaluation;

  ThreePoses() {
    campaign.pose_ids = {"A", "B", "C"};
    for (const auto& [pose, error] : std::vector<std::pair<int, double>>{
             {0, 1e-3}, {1, 5e-3}, {1, 7e-3}, {0, 3e-3}, {2, 9e-3}}) {
      campaign.pose.push_back(pose);
      campaign.q.emplace_back(JointVector::Zero(6));
      campaign.position.emplace_back(0.5 * pose, error, 0);
      evaluation.residuals.emplace_back(Eigen::Matrix<double, 6, 1>::Zero());
      evaluation.residuals.back()[1] = error;
    }
  }
};

TEST(PoseAccuracy, OfACampaignIsByPose) {
  const ThreePoses readings;
  const CampaignFigures figures = figures_of(readings.campaign, readings.evaluation);
  ASSERT_EQ(figures.poses.size(), 2u);
  EXPECT_NEAR(figures.poses[0].ap, 2e-3, kTolerance);
  EXPECT_NEAR(figures.poses[1].ap, 6e-3, kTolerance);
  EXPECT_THAT(figures.single, ElementsAre("C"));
  EXPECT_THAT(figures.not_left, ElementsAre("B"));
  const SetFigures all = largest_of(figures.poses);
  EXPECT_EQ(all.ap.pose, "B");
  EXPECT_NEAR(all.ap.value, 6e-3, kTolerance);
  EXPECT_NEAR(all.rp.value, 1e-3, kTolerance);
  // Each pose: l = 1, 1 mm. s^2 = (2 + 2) / (3 + 3) mm^2.
  const Scatter scatter = scatter_of(figures.poses);
  EXPECT_NEAR(scatter.deviation, std::sqrt(4.0 / 6) * 1e-3, kTolerance);
  EXPECT_EQ(scatter.freedom, 6);
}

// The robot stands in a pose while two reflectors are measured in turn, twice; then it comes back.
TEST(PoseAccuracy, ReflectorsAreMeasuredInTurnWithoutLeavingThePose) {
  ThreePoses readings;
  Campaign& campaign = readings.campaign;
  campaign.target_names = {"T1", "T2"};
  campaign.target = {0, 1, 0, 1, 0};
  campaign.pose = {0, 0, 0, 0, 1};
  EXPECT_THAT(figures_of(campaign, readings.evaluation).not_left, ElementsAre("A, T1", "A, T2"));
  campaign.pose = {0, 0, 1, 0, 0};
  campaign.target = {0, 1, 0, 0, 1};
  EXPECT_THAT(figures_of(campaign, readings.evaluation).not_left, ElementsAre());
}

// Two stations see a pose in frames of their own: two entries.
TEST(PoseAccuracy, SessionsAndReflectorsAreKeptApart) {
  ThreePoses readings;
  readings.campaign.session_names = {"day 1", "day 2"};
  readings.campaign.session = {0, 0, 0, 1, 1};
  const CampaignFigures figures = figures_of(readings.campaign, readings.evaluation);
  ASSERT_EQ(figures.poses.size(), 1u);
  EXPECT_EQ(figures.poses[0].pose, "B, session day 1");
  EXPECT_THAT(figures.single,
              ElementsAre("A, session day 1", "A, session day 2", "C, session day 2"));
}

// Normal visits with 0.01, 0.02 and 0.03 mm along three axes. The RP of many visits is that of two
// hundred thousand; the interval of few holds it in 95 % of the certificates, or more if it is the
// largest of several poses.
TEST(PoseAccuracy, TheIntervalOfRepeatabilityHoldsThatOfManyVisits) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const auto visit = [&] {
    const double x = normal(random), y = normal(random), z = normal(random);
    return visit_at(1e-5 * Vector3d(x, 2 * y, 3 * z));
  };
  std::vector<Visit> many;
  for (int k = 0; k < 200000; ++k) many.push_back(visit());
  const double truth = pose_figures("P", many).rp;
  constexpr int kCertificates = 40;
  for (const int visits : {3, 6, 30}) {
    int held = 0;
    for (int k = 0; k < kCertificates; ++k) {
      std::vector<PoseFigures> poses;
      for (int pose = 0; pose < 5; ++pose) {
        std::vector<Visit> few;
        for (int j = 0; j < visits; ++j) few.push_back(visit());
        poses.push_back(pose_figures("P", few));
      }
      const SetFigures set = largest_of(poses);
      held += (*set.rp_ci95)[0] <= truth && truth <= (*set.rp_ci95)[1];
      EXPECT_NEAR(*set.rp_expanded(),
                  std::max(set.rp.value - (*set.rp_ci95)[0], (*set.rp_ci95)[1] - set.rp.value),
                  kTolerance);
    }
    EXPECT_GE(held, 0.92 * kCertificates) << visits;
  }
}

// Visits that scatter along x at one pose and along y at the other: all of them tell the law. The
// largest of many poses is larger by chance, so the truth may lie lower.
TEST(Repeatability, OfSeveralPosesHasTheScatterOfAll) {
  std::vector<PoseFigures> poses;
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0)}) {
    std::vector<Visit> visits(5);
    for (int k = 0; k < 5; ++k)
      visits[static_cast<size_t>(k)].attained = Eigen::Vector3d(1, 2, 3) + (k - 2) * 1e-4 * axis;
    poses.push_back(pose_figures("P", visits));
  }
  const SetFigures set = largest_of(poses);
  const Eigen::Matrix3d squares = Eigen::Vector3d(10e-8, 10e-8, 0).asDiagonal();
  const auto expected = repeatability_ci95(set.rp.value, 5, 2, squares);
  EXPECT_NEAR(set.rp_ci95->at(0), expected[0], 1e-9);
  EXPECT_NEAR(set.rp_ci95->at(1), expected[1], 1e-9);
  EXPECT_LT(repeatability_ci95(1e-4, 5, 50, squares)[0],
            0.8 * repeatability_ci95(1e-4, 5, 1, squares)[0]);
}

}  // namespace
}  // namespace armtrue::pose_accuracy_test
