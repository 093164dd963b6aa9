#include "armtrue/path/mirror/engagement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace armtrue::engagement_test {
namespace {

constexpr double kPeriod = 0.032;

constexpr double kSudden = 1e-9;  // [s]

struct Cut {
  double entry, exit, level, ramp;  // s, s, N, s from nothing to the level
};

// A force plate with 2 N of noise per axis; each cut along one direction, with a slow ripple.
Eigen::Matrix3Xd force_of(const Eigen::VectorXd& time, const std::vector<Cut>& cuts, unsigned seed,
                          double ripple = 0.2) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, 2);
  const Eigen::Vector3d direction = Eigen::Vector3d(0.15, 0.93, -0.34).normalized();
  Eigen::Matrix3Xd force(3, time.size());
  for (Eigen::Index i = 0; i < time.size(); ++i) {
    double size = 0;
    for (const Cut& cut : cuts) {
      const double in = std::clamp((time[i] - cut.entry) / cut.ramp, 0.0, 1.0);
      const double out = std::clamp((cut.exit - time[i]) / cut.ramp, 0.0, 1.0);
      size += cut.level * std::min(in, out) * (1 + ripple * std::sin(2 * time[i]));
    }
    for (int a = 0; a < 3; ++a) force(a, i) = size * direction[a] + normal(random);
  }
  return force;
}

Eigen::VectorXd clock(double seconds) {
  const auto n = static_cast<Eigen::Index>(seconds / kPeriod);
  return Eigen::VectorXd::LinSpaced(n, 1, 1 + kPeriod * static_cast<double>(n - 1));
}

bool holds(const std::optional<Instant>& instant, double truth) {
  return instant && std::abs(instant->time - truth) <= instant->uncertainty;
}

TEST(Engagement, EntryAndExitLieWithinTheirUncertainty) {
  const Eigen::VectorXd time = clock(14);
  for (unsigned seed = 1; seed <= 200; ++seed) {
    const double shift = 0.01 * seed + 0.003;  // never on a sample
    const Cut cut{2.5 + shift, 10 + shift, 40, kSudden};
    const EngagementRecord found = find_engagement(time, force_of(time, {cut}, seed));
    ASSERT_EQ(found.intervals.size(), 1U) << seed;
    EXPECT_TRUE(holds(found.intervals[0].entry, cut.entry)) << seed;
    EXPECT_TRUE(holds(found.intervals[0].exit, cut.exit)) << seed;
    EXPECT_LE(found.intervals[0].entry->uncertainty, 2 * kPeriod) << seed;
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(found.noise[a], 2, 0.6) << seed;
  }
}

TEST(Engagement, ASlowEntryIsWithinAWiderUncertainty) {
  const Eigen::VectorXd time = clock(14);
  const Cut cut{3, 11, 40, 0.6};
  const EngagementRecord found = find_engagement(time, force_of(time, {cut}, 7));
  ASSERT_EQ(found.intervals.size(), 1U);
  EXPECT_TRUE(holds(found.intervals[0].entry, cut.entry));
  EXPECT_TRUE(holds(found.intervals[0].exit, cut.exit));
  EXPECT_GT(found.intervals[0].entry->uncertainty, 2 * kPeriod);
}

TEST(Engagement, ASuddenEntryBehindALowPassWithoutPhaseIsWithinItsUncertainty) {
  const Eigen::VectorXd time = clock(14);
  const Cut cut{3, 11, 40, kSudden};
  const Eigen::Matrix3Xd raw = force_of(time, {cut}, 8);
  Eigen::Matrix3Xd smooth = raw;
  constexpr Eigen::Index kHalf = 8;  // running mean over half a second
  for (Eigen::Index i = kHalf; i + kHalf < time.size(); ++i)
    smooth.col(i) = raw.middleCols(i - kHalf, 2 * kHalf + 1).rowwise().mean();
  const EngagementRecord found = find_engagement(time, smooth);
  ASSERT_EQ(found.intervals.size(), 1U);
  EXPECT_TRUE(holds(found.intervals[0].entry, cut.entry));
  EXPECT_TRUE(holds(found.intervals[0].exit, cut.exit));
}

TEST(Engagement, SeveralCutsAndARecordThatEndsInTheMaterial) {
  const Eigen::VectorXd time = clock(20);
  const EngagementRecord found = find_engagement(
      time, force_of(time, {{3, 7, 30, kSudden}, {10, 14, 45, kSudden}, {17, 99, 30, kSudden}}, 9));
  ASSERT_EQ(found.intervals.size(), 3U);
  EXPECT_TRUE(holds(found.intervals[1].entry, 10));
  EXPECT_TRUE(holds(found.intervals[1].exit, 14));
  EXPECT_TRUE(holds(found.intervals[2].entry, 17));
  EXPECT_FALSE(found.intervals[2].exit);
}

TEST(Engagement, ARecordThatBeginsInTheMaterial) {
  const Eigen::VectorXd time = clock(14);
  const EngagementRecord found = find_engagement(time, force_of(time, {{-9, 6, 30, kSudden}}, 10));
  ASSERT_EQ(found.intervals.size(), 1U);
  EXPECT_FALSE(found.intervals[0].entry);
  EXPECT_TRUE(holds(found.intervals[0].exit, 6));
}

TEST(Engagement, NothingIsFoundInAirNorAlwaysInTheMaterialNorInASpike) {
  const Eigen::VectorXd time = clock(14);
  int found = 0;
  for (unsigned seed = 1; seed <= 200; ++seed)
    found += !find_engagement(time, force_of(time, {}, seed)).intervals.empty();
  EXPECT_EQ(found, 0);
  EXPECT_TRUE(find_engagement(time, force_of(time, {{-9, 99, 40, kSudden}}, 3)).intervals.empty());
  Eigen::Matrix3Xd spike = force_of(time, {}, 4);
  spike.col(100).setConstant(90);
  EXPECT_TRUE(find_engagement(time, spike).intervals.empty());
  EXPECT_TRUE(find_engagement(clock(0.3), force_of(clock(0.3), {}, 5)).intervals.empty());
}

}  // namespace
}  // namespace armtrue::engagement_test
