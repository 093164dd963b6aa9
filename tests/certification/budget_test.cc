#include "armtrue/certification/budget.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "armtrue/certification/certificate.h"
#include "armtrue/statistics/random.h"

namespace armtrue::budget_test {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kMicro = 1e-6;

StatedUncertainty tracker() {
  StatedUncertainty stated;
  stated.mpe_constant = 15 * kMicro;
  stated.mpe_per_metre = 6 * kMicro;
  stated.mounting = 10 * kMicro;
  stated.temperature_half_width = 2;
  stated.expansion = 11.7 * kMicro;
  stated.length = 2.5;
  return stated;
}

// By hand, um: MPE at 2.5 m 15 + 6 x 2.5 = 30, u = 30 / sqrt 3; temperature 2 x 11.7 x 2.5 = 58.5,
// u = 58.5 / sqrt 3; mounting 10; model 20; repeatability 40 / sqrt 4 = 20.
// Squares: 300 + 1140.75 + 100 + 400 + 400 = 2340.75, u_c = 48.3813.
// f = 12 x 2340.75^2 / 20^4 = 410.933; k = 2.0061 (t of so many degrees of freedom).
TEST(Budget, IsThatOfAHandCalculation) {
  const Budget budget = budget_of(tracker(), {40 * kMicro, 12}, 4, 2.5, 20 * kMicro);
  ASSERT_EQ(budget.rows.size(), 5u);
  EXPECT_NEAR(budget.rows[0].standard, 17.3205081 * kMicro, 1e-12);
  EXPECT_NEAR(budget.rows[1].standard, 10 * kMicro, 1e-12);
  EXPECT_NEAR(budget.rows[2].standard, 33.7749907 * kMicro, 1e-12);
  EXPECT_NEAR(budget.rows[3].standard, 20 * kMicro, 1e-12);
  EXPECT_NEAR(budget.rows[4].standard, 20 * kMicro, 1e-12);
  EXPECT_NEAR(budget.combined, 48.3813 * kMicro, 1e-10);
  EXPECT_NEAR(budget.freedom, 410.933, 1e-3);
  EXPECT_NEAR(budget.k, 2.0061, 2e-4);
  EXPECT_NEAR(budget.expanded, budget.k * budget.combined, 1e-15);
}

// JCGM 100:2008, table G.2, column 95.45 %.
TEST(Budget, CoverageFactorIsThatOfTheTableOfTheGum) {
  for (const auto& [freedom, k] : {std::pair{3.0, 3.31}, {10.0, 2.28}, {20.0, 2.13}, {50.0, 2.05}})
    EXPECT_NEAR(budget_of({}, {1e-4, freedom}, 2, 0, {}).k, k, 0.005) << freedom;
}

TEST(Budget, WithoutScatterHasTheFactorTwo) {
  EXPECT_EQ(budget_of(tracker(), {0, 12}, 4, 2.5, {}).k, 2);
}

// s = 50 um of 25 visits: 10 um in all, of which noise of 30 um has 6 um and the robot 8 um.
TEST(Budget, NoiseOfTheInstrumentCountsOnce) {
  StatedUncertainty stated;
  stated.noise = 30 * kMicro;
  const Budget budget = budget_of(stated, {50 * kMicro, 72}, 25, 3, {});
  EXPECT_NEAR(budget.rows.front().standard, 6 * kMicro, 1e-12);
  EXPECT_NEAR(budget.rows.back().standard, 8 * kMicro, 1e-12);
  EXPECT_NEAR(budget.combined, 10 * kMicro, 1e-12);
  // The scatter alone makes the uncertainty, so it has the degrees of freedom of the scatter.
  EXPECT_NEAR(budget.freedom, 72, 1e-9);
  EXPECT_NEAR(budget_of(stated, {20 * kMicro, 72}, 25, 3, {}).combined, 6 * kMicro, 1e-12);
}

// Half widths of rectangular laws; a fitted frame has a normal one.
TEST(Budget, OfAPathHasItsOwnRows) {
  const Budget budget = budget_of({}, {0, 12}, 4, 0, {}, 60 * kMicro, 7 * kMicro);
  EXPECT_NEAR(budget.combined, std::hypot(60 / std::sqrt(3), 7) * kMicro, 1e-12);
}

// ISO 14253-1: conforming up to the tolerance itself, on either side of the band.
TEST(Decision, AtTheEndsOfTheBandIsPassAndUndecided) {
  EXPECT_EQ(decide(0.25, 0.25, 0.5), Decision::pass);
  EXPECT_EQ(decide(0.5, 0.25, 0.25), Decision::undecided);
}

TEST(Decision, HasAGuardBandOfTheUncertaintyOnBothSides) {
  EXPECT_EQ(decide(0.4, 0.1, 0.51), Decision::pass);
  EXPECT_EQ(decide(0.4, 0.1, 0.49), Decision::undecided);
  EXPECT_EQ(decide(0.4, 0.1, 0.31), Decision::undecided);
  EXPECT_EQ(decide(0.4, 0.1, 0.29), Decision::fail);
}

// A measurement of one pose whose true error is `truth`, with all that tracker() states.
struct Measured {
  double ap = 0, expanded = 0;
};
Measured measure(Random& random, const Vector3d& truth, const StatedUncertainty& stated, int poses,
                 int visits, double deviation) {
  const auto rectangular = [&](double half) {
    const double x = random.uniform(-half, half), y = random.uniform(-half, half),
                 z = random.uniform(-half, half);
    return Vector3d(x, y, z);
  };
  constexpr double kRange = 3;
  const Vector3d bias =
      rectangular(stated.mpe_constant + stated.mpe_per_metre * kRange) +
      rectangular(stated.temperature_half_width * stated.expansion * stated.length) +
      stated.mounting * random.normal3();
  std::vector<PoseFigures> figures;
  for (int pose = 0; pose < poses; ++pose) {
    std::vector<Visit> list(static_cast<size_t>(visits));
    for (Visit& visit : list)
      visit.attained = visit.error = truth + bias + deviation * random.normal3();
    figures.push_back(pose_figures("P", list));
  }
  const Budget budget = budget_of(stated, scatter_of(figures), visits, kRange, {});
  return {figures.front().ap, budget.expanded};
}

double coverage(const StatedUncertainty& stated, int poses, int visits, double deviation) {
  Random random(1);
  const Vector3d truth(0.6e-3, -0.8e-3, 0.3e-3);
  constexpr int kDraws = 10000;
  int inside = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Measured measured = measure(random, truth, stated, poses, visits, deviation);
    inside += std::abs(measured.ap - truth.norm()) <= measured.expanded;
  }
  return static_cast<double>(inside) / kDraws;
}

// 95.45 %; rectangular parts have shorter tails than the normal law.
TEST(Budget, CoversTheTrueErrorAsOftenAsItSays) {
  const double covered = coverage(tracker(), 5, 4, 30 * kMicro);
  EXPECT_GT(covered, 0.945);
  EXPECT_LT(covered, 0.985);
}

// One pose with two visits, 3 degrees of freedom: k = 2 would cover 86 %.
TEST(Budget, CoversTheTrueErrorWithTwoVisits) {
  const double covered = coverage({}, 1, 2, 30 * kMicro);
  EXPECT_GT(covered, 0.945);
  EXPECT_LT(covered, 0.965);
}

// A robot just beyond the tolerance passes in 2.3 % of the measurements at most, whatever its error
// is in units of the uncertainty.
TEST(Decision, SeldomPassesARobotBeyondTheTolerance) {
  for (double error : {20e-6, 80e-6, 200e-6, 1e-3}) {
    Random random(7);
    constexpr int kDraws = 5000;
    int passed = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      const Measured measured = measure(random, {error, 0, 0}, tracker(), 5, 4, 30 * kMicro);
      passed += decide(measured.ap, measured.expanded, error) == Decision::pass;
    }
    EXPECT_LT(static_cast<double>(passed) / kDraws, 0.028) << error;
  }
}

CertifiedValues values(double ap, double pose_ap) {
  return {"123",
          "KR 360",
          "2026-01-05",
          {{"ap", ap, 0.03e-3}, {"rp", 0.1e-3, 0.02e-3}},
          {{"P1", pose_ap, 0.03e-3}}};
}

// By hand: U = sqrt(0.03^2 + 0.04^2) = 0.05 mm; one pose: not widened.
TEST(Comparison, IsSignificantBeyondBothUncertainties) {
  CertifiedValues now = values(0.56e-3, 0.44e-3);
  for (auto* list : {&now.figures, &now.poses})
    for (CertifiedValue& value : *list) value.expanded = 0.04e-3;
  now.poses.push_back({"P2", 1e-3, 0.04e-3});  // not in the older one
  const Comparison comparison = compare(values(0.5e-3, 0.4e-3), now);
  ASSERT_EQ(comparison.figures.size(), 2u);
  EXPECT_NEAR(*comparison.figures[0].expanded, 0.05e-3, 1e-12);
  EXPECT_NEAR(comparison.figures[0].difference, 0.06e-3, 1e-12);
  EXPECT_TRUE(comparison.figures[0].significant);
  EXPECT_FALSE(comparison.figures[1].significant);
  ASSERT_EQ(comparison.poses.size(), 1u);
  EXPECT_NEAR(*comparison.poses[0].expanded, 0.05e-3, 1e-9);
  EXPECT_FALSE(comparison.poses[0].significant);
}

// A repeatability of two visits has no uncertainty; a difference of it is not judged.
TEST(Comparison, OfAValueWithoutUncertaintyIsNotSignificant) {
  CertifiedValues before = values(0.5e-3, 0.4e-3), now = before;
  before.figures[1].expanded.reset();
  now.figures[1].value = 5e-3;
  const Comparison comparison = compare(before, now);
  EXPECT_NEAR(comparison.figures[1].difference, 4.9e-3, 1e-12);
  EXPECT_FALSE(comparison.figures[1].expanded);
  EXPECT_FALSE(comparison.figures[1].significant);
}

// "P1" of both is visited with other joint angles; a correction of 0.3 deg is the same pose.
TEST(Comparison, OfOtherPosesOfOneNameIsLeftOut) {
  CertifiedValues before = values(0.5e-3, 0.4e-3);
  before.poses[0].joints = {{"q1_deg", 10}, {"q2_deg", -90}};
  before.poses.push_back({"P2", 0.4e-3, 0.03e-3, {{"q1_deg", 20}, {"q2_deg", -90}}});
  before.poses.push_back({"P3", 0.4e-3, 0.03e-3});  // of an earlier version
  CertifiedValues now = before;
  now.poses[0].joints = {{"q1_deg", 12}, {"q2_deg", -60}};
  now.poses[1].joints["q1_deg"] += 0.3;
  now.poses[2].joints = {{"q1_deg", 50}};
  const Comparison comparison = compare(before, now);
  ASSERT_EQ(comparison.poses.size(), 2u);
  EXPECT_EQ(comparison.poses[0].name, "P2");
  EXPECT_EQ(comparison.poses[1].name, "P3");
  // By hand: two poses share 4.55 %, 2.275 % each: 2.2776 standard uncertainties instead of 2.
  EXPECT_NEAR(*comparison.poses[0].expanded, std::sqrt(2) * 0.03e-3 * 2.2776 / 2, 1e-9);
  ASSERT_EQ(comparison.others.size(), 1u);
  EXPECT_EQ(comparison.others[0].name, "P1");
  EXPECT_EQ(comparison.others[0].joint, "q2_deg");
  EXPECT_NEAR(comparison.others[0].apart, 30, 1e-12);
  EXPECT_THAT(doubt_of_poses(comparison),
              HasSubstr("poses of 1 of 3 names have other joint values (P1; q2_deg of P1 differs "
                        "by 30)"));
  EXPECT_EQ(doubt_of_poses(compare(before, before)), "");
}

// Of 40 poses that share 4.55 %: 0.1138 % each, 3.25 standard uncertainties instead of 2.
TEST(Comparison, OfManyPosesIsWidened) {
  CertifiedValues before = values(0.5e-3, 0.4e-3);
  for (int pose = 2; pose <= 40; ++pose)
    before.poses.push_back({std::to_string(pose), 0.4e-3, 0.03e-3});
  const Comparison comparison = compare(before, before);
  EXPECT_NEAR(*comparison.poses[0].expanded, std::sqrt(2) * 0.03e-3 * 3.254 / 2, 1e-8);
}

TEST(Comparison, OfAnotherRobotIsRefused) {
  CertifiedValues other = values(0.5e-3, 0.4e-3);
  other.serial = "124";
  EXPECT_THROW(compare(other, values(0.5e-3, 0.4e-3)), std::invalid_argument);
}

}  // namespace
}  // namespace armtrue::budget_test
