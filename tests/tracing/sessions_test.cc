// The loop on campaigns of the oracle that several stations of the instrument have seen.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/tracing/description.h"
#include "armtrue/tracing/loop.h"
#include "kinematics/six_axes.h"
#include "tracing/hidden_campaign.h"

namespace armtrue::sessions_test {
namespace {

const std::string kNominal = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";

Robot nominal() { return read_robot(kNominal).robot; }

HiddenCampaign oracle(const std::string& family, unsigned seed) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = seed;
  return {kNominal, family, family == "null" ? 0 : 0.12, plan};
}

// The instrument is carried to another station at these shares of the time.
void carry_instrument(Campaign& campaign, const std::vector<double>& at_shares) {
  const double duration = *std::max_element(campaign.time_s.begin(), campaign.time_s.end()) + 1;
  for (size_t s = 0; s <= at_shares.size(); ++s)
    campaign.session_names.push_back("station " + std::to_string(s));
  for (int row = 0; row < campaign.rows(); ++row) {
    const auto s =
        static_cast<int>(std::count_if(at_shares.begin(), at_shares.end(), [&](double share) {
          return campaign.time_s[row] >= share * duration;
        }));
    campaign.session.push_back(s);
    const Pose station{rotation_exp(s * Eigen::Vector3d(0.4, -0.3, 1.3)), {4.0 * s, -2.5 * s, 0.3}};
    campaign.position[row] = station * campaign.position[row];
    if (campaign.orientation.empty()) continue;
    campaign.orientation[row] = Eigen::Quaterniond(station.rotation) * campaign.orientation[row];
  }
}

// So many stations, equally long.
void carry_instrument(Campaign& campaign, int stations) {
  std::vector<double> at_shares;
  for (int s = 1; s < stations; ++s) at_shares.push_back(static_cast<double>(s) / stations);
  carry_instrument(campaign, at_shares);
}

LoopResult closed(const HiddenCampaign& campaign, const Robot& robot = nominal()) {
  return close_loop(robot, campaign.training, campaign.held_out,
                    read_catalogue(ARMTRUE_CONFIG "/effects/catalogue.yaml"));
}

std::string listed(const LoopResult& result) {
  std::string text;
  for (const TracedEffect& traced : result.trace.effects) text += describe(traced.effect) + "\n";
  return text;
}

class AcrossSessions : public testing::TestWithParam<std::string> {};

TEST_P(AcrossSessions, AnEffectIsNamedAddedAndGone) {
  HiddenCampaign campaign = oracle(GetParam(), 41);
  carry_instrument(campaign.training, 2);
  carry_instrument(campaign.held_out, 2);
  const LoopResult result = closed(campaign);
  ASSERT_FALSE(result.trace.effects.empty());
  EXPECT_TRUE(names(campaign.written.truth, result.trace.effects.front())) << listed(result);
  EXPECT_LT(result.after, 1.06 * campaign.written.floor_mean_mm * kMillimetre);
  EXPECT_EQ(result.trace.fit.robot.sessions.size(), 2u);
}

INSTANTIATE_TEST_SUITE_P(Hidden, AcrossSessions,
                         testing::Values("compliance", "harmonic", "backlash", "tilt"),
                         [](const auto& instance) { return instance.param; });

// Of many poses a part is searched, but of a station that has seen few of them all.
TEST(Sessions, OfManyPosesAreSearchedInPart) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 5;
  plan.poses = 3000;
  plan.repeats = 1;
  plan.orientation = false;
  HiddenCampaign campaign(kNominal, "x-cycles", 0.05, plan);
  carry_instrument(campaign.training, std::vector{0.998});
  carry_instrument(campaign.held_out, std::vector{0.998});
  ASSERT_GT(campaign.training.rows(), 2000);
  const std::vector<int>& session = campaign.training.session;
  ASSERT_LT(std::count(session.begin(), session.end(), 1), 10);
  const LoopResult result = closed(campaign);
  ASSERT_EQ(result.trace.effects.size(), 1u) << listed(result);
  EXPECT_TRUE(names(campaign.written.truth, result.trace.effects.front())) << listed(result);
  EXPECT_EQ(result.trace.fit.weights.size(), static_cast<size_t>(campaign.training.rows()));
  EXPECT_EQ(result.trace.fit.robot.sessions.size(), 2u);
  EXPECT_LT(result.after, 1.02 * campaign.written.floor_mean_mm * kMillimetre);
}

TEST(Sessions, NothingIsSaidWhenNothingIsHidden) {
  for (int stations : {2, 3}) {
    HiddenCampaign campaign = oracle("null", 49 + stations);
    carry_instrument(campaign.training, stations);
    carry_instrument(campaign.held_out, stations);
    const LoopResult result = closed(campaign);
    EXPECT_TRUE(result.trace.effects.empty()) << listed(result);
    EXPECT_EQ(result.verdict, Verdict::nothing_to_explain);
    EXPECT_LT(result.after, 1.1 * campaign.written.floor_mean_mm * kMillimetre);
  }
}

TEST(Sessions, OneWithoutTrainingPosesIsAnError) {
  HiddenCampaign campaign = oracle("null", 51);
  carry_instrument(campaign.held_out, 2);
  EXPECT_THROW(closed(campaign), std::invalid_argument);
  carry_instrument(campaign.training, 2);
  campaign.held_out.session.clear();
  EXPECT_THROW(closed(campaign), std::invalid_argument);
}

// A knock that the loop has found makes two sessions: the same robot, and nothing left to explain.
TEST(Sessions, AKnockMakesTwo) {
  HiddenCampaign campaign = oracle("knock", 41);
  const LoopResult with_step = closed(campaign);
  ASSERT_EQ(with_step.trace.effects.size(), 1u) << listed(with_step);
  const Effect& step = with_step.trace.effects.front().effect;
  ASSERT_EQ(step.parameter, "base");
  ASSERT_EQ(step.shape.kind, ShapeKind::step);

  begin_sessions(campaign.training, {step.shape.at});
  begin_sessions(campaign.held_out, {step.shape.at});
  const LoopResult in_sessions = closed(campaign);
  EXPECT_TRUE(in_sessions.trace.effects.empty()) << listed(in_sessions);
  EXPECT_EQ(in_sessions.verdict, Verdict::nothing_to_explain);
  EXPECT_LT(in_sessions.after, 1.06 * campaign.written.floor_mean_mm * kMillimetre);

  const Robot& a = with_step.trace.fit.robot;
  const Robot& b = in_sessions.trace.fit.robot;
  ASSERT_EQ(with_step.trace.fit.set.kept, in_sessions.trace.fit.set.kept);
  for (int j = 0; j < kLinks; ++j) {
    const Link &u = a.chain.links[j], &v = b.chain.links[j];
    const double differences[] = {u.alpha - v.alpha, u.d - v.d, u.theta - v.theta, u.r - v.r,
                                  u.beta - v.beta};
    for (int k = 0; k < 5; ++k) {
      const std::string name = parameter_name(a.chain, kFirstLinkParameter + 5 * j + k);
      if (b.std.contains(name)) EXPECT_LT(std::abs(differences[k]), 0.5 * b.std.at(name)) << name;
    }
  }
}

// A joint mastered anew is an own zero offset of what follows.
TEST(Sessions, ARemasteredJointHasItsOwnZeroOffset) {
  HiddenCampaign campaign = oracle("remaster", 41);
  const std::string parameter = campaign.written.truth.parameter;
  const LoopResult with_step = closed(campaign);
  ASSERT_FALSE(with_step.trace.effects.empty());
  const Effect& step = with_step.trace.effects.front().effect;
  ASSERT_EQ(step.parameter, parameter);
  ASSERT_EQ(step.shape.kind, ShapeKind::step);

  begin_sessions(campaign.training, {step.shape.at});
  begin_sessions(campaign.held_out, {step.shape.at});
  Robot robot = nominal();
  robot.identify_per_session = {parameter};
  const LoopResult result = closed(campaign, robot);
  EXPECT_TRUE(result.trace.effects.empty()) << listed(result);
  EXPECT_LT(result.after, 1.06 * campaign.written.floor_mean_mm * kMillimetre);
  const auto& sessions = result.trace.fit.robot.sessions;
  const int link = (*find_parameter(robot.chain, parameter) - kFirstLinkParameter) / 5;
  const double change = sessions.at("2").zero.at(link) - sessions.at("1").zero.at(link);
  EXPECT_NEAR(
      change, campaign.written.amplitude,
      3 * std::hypot(sessions.at("2").std.at(parameter), result.trace.fit.robot.std.at(parameter)));
}

// A campaign without times, that the instrument saw from two stations: what the oracle hides happened
// between them.
void end_session_at(double at_s, Campaign& campaign) {
  const double duration = *std::max_element(campaign.time_s.begin(), campaign.time_s.end()) + 1;
  carry_instrument(campaign, std::vector{at_s / duration});
  campaign.time_s.clear();
}

HiddenCampaign between_sessions(const std::string& family, unsigned seed) {
  HiddenCampaign campaign = oracle(family, seed);
  for (Campaign* part : {&campaign.training, &campaign.held_out})
    end_session_at(campaign.written.truth.step_at_s, *part);
  return campaign;
}

class BetweenSessions : public testing::TestWithParam<std::string> {};

TEST_P(BetweenSessions, AnEventIsNamedWithoutTimes) {
  const HiddenCampaign campaign = between_sessions(GetParam(), 41);
  const auto& truth = campaign.written.truth;
  const LoopResult result = closed(campaign);
  ASSERT_FALSE(result.trace.effects.empty());
  for (const TracedEffect& traced : result.trace.effects) {
    EXPECT_EQ(to_string(traced.effect.driver), "session") << listed(result);
    EXPECT_EQ(first_session_after(traced.effect), "station 1");
    EXPECT_NE(for_the_cell(traced, nullptr, nominal())
                  .find("it stands otherwise since session 'station 1'"),
              std::string::npos);
  }
  if (GetParam() == "remaster") {
    const Effect& step = result.trace.effects.front().effect;
    EXPECT_EQ(step.parameter, truth.parameter) << listed(result);
    EXPECT_NEAR(step.coefficients.front().value, campaign.written.amplitude,
                4 * step.coefficients.front().std);
  }
  EXPECT_LT(result.after, 1.08 * campaign.written.floor_mean_mm * kMillimetre);
}

INSTANTIATE_TEST_SUITE_P(Hidden, BetweenSessions, testing::Values("remaster", "crash"),
                         [](const auto& instance) { return instance.param; });

// With few poses none of the parameters of a bent link shows alone.
TEST(Sessions, ACrashBetweenThemShowsInFewPoses) {
  int named = 0;
  for (unsigned seed : {41u, 42u, 43u, 44u, 45u, 46u}) {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = seed;
    plan.poses = 30;
    plan.repeats = 1;
    HiddenCampaign campaign{kNominal, "crash", 0.18, plan};
    for (Campaign* part : {&campaign.training, &campaign.held_out})
      end_session_at(campaign.written.truth.step_at_s, *part);
    const LoopResult result = closed(campaign);
    named += !result.trace.effects.empty();
    for (const TracedEffect& traced : result.trace.effects)
      EXPECT_EQ(traced.effect.name, "bent link") << listed(result);
  }
  EXPECT_GE(named, 4);
}

TEST(Sessions, NothingHappenedBetweenThoseWithoutTimes) {
  for (unsigned seed : {51u, 52u, 53u, 54u}) {
    HiddenCampaign campaign = oracle("null", seed);
    const auto [first, last] = std::ranges::minmax(campaign.training.time_s);
    for (Campaign* part : {&campaign.training, &campaign.held_out})
      end_session_at(0.5 * (first + last), *part);
    const LoopResult result = closed(campaign);
    EXPECT_TRUE(result.trace.effects.empty()) << listed(result);
  }
}

}  // namespace
}  // namespace armtrue::sessions_test
