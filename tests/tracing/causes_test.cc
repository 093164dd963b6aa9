// A name is earned: physics, time and company that a cause must have, on campaigns of the oracle,
// which shares no code with armtrue.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "armtrue/campaign/simulation.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/tracing/description.h"
#include "armtrue/tracing/loop.h"
#include "tracing/hidden_campaign.h"

namespace armtrue::causes_test {
namespace {

const std::string kNominal = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";
const std::string kCatalogue = ARMTRUE_CONFIG "/effects/catalogue.yaml";

struct Found {
  armtrue_oracle::Hidden truth;
  LoopResult result;
};

Found found(const std::string& family, unsigned seed, double size_mm = 0.12,
            const std::string& nominal = kNominal) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = seed;
  const HiddenCampaign campaign(nominal, family, size_mm, plan);
  return {campaign.written.truth, close_loop(read_robot(nominal).robot, campaign.training,
                                             campaign.held_out, read_catalogue(kCatalogue), {})};
}

std::string listed(const LoopResult& result) {
  std::string text;
  for (const TracedEffect& traced : result.trace.effects)
    text += traced.effect.name + ": " + describe(traced.effect) + "\n";
  return text;
}

bool has(const LoopResult& result, const std::string& name) {
  return std::ranges::any_of(result.trace.effects, [&](const TracedEffect& traced) {
    return traced.effect.name == name;
  });
}

// Two or more of its parameters at one time; none of it is told as heat or as a zero that jumped.
TEST(Crash, BendsOneLinkInItsParametersAtOneTime) {
  for (unsigned seed : {41u, 42u, 43u}) {
    const auto [truth, result] = found("crash", seed);
    int bent = 0;
    for (const TracedEffect& traced : result.trace.effects) {
      if (traced.effect.name != "bent link") continue;
      ++bent;
      const std::string moved = to_string(traced.effect.parameter);
      EXPECT_TRUE(moved.starts_with("A4.") || moved == "A3.theta" || moved == "A3.r") << moved;
      EXPECT_NEAR(traced.effect.shape.at, truth.step_at_s, 60);
      EXPECT_TRUE(traced.indistinguishable.empty());
    }
    EXPECT_GE(bent, 2) << listed(result);
    EXPECT_FALSE(has(result, "thermal growth")) << listed(result);
    EXPECT_EQ(result.verdict, Verdict::closed) << seed;
  }
}

// It lies between two readings, and twelve hours between these make it no less one event.
TEST(Crash, IsOneEventInABreakOfTheReadings) {
  constexpr double kBreak = 12 * 3600;  // s
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 41;
  HiddenCampaign campaign(kNominal, "crash", 0.12, plan);
  for (Campaign* part : {&campaign.training, &campaign.held_out})
    for (double& t : part->time_s)
      if (t > campaign.written.truth.step_at_s) t += kBreak;
  const LoopResult result = close_loop(read_robot(kNominal).robot, campaign.training,
                                       campaign.held_out, read_catalogue(kCatalogue), {});
  EXPECT_TRUE(has(result, "bent link")) << listed(result);
  EXPECT_EQ(result.verdict, Verdict::closed);
}

// Behind parallel axes a turn about the next one, against that about the one before, is the shift
// across the link.
TEST(Crash, BendsALinkBetweenParallelAxes) {
  const LoopResult result = found("bent-upper-arm", 48, 0.3).result;
  std::set<std::string> moved;
  for (const TracedEffect& traced : result.trace.effects) {
    EXPECT_EQ(traced.effect.name, "bent link") << listed(result);
    moved.insert(to_string(traced.effect.parameter));
  }
  EXPECT_TRUE(moved.contains("A3.theta")) << listed(result);
  for (const std::string& parameter : moved)
    EXPECT_TRUE(parameter.starts_with("A3.") || parameter == "A2.theta" || parameter == "A2.r")
        << parameter;
  EXPECT_EQ(result.verdict, Verdict::closed);
}

// One zero that jumped is no crash, and no load.
TEST(Crash, IsNotNamedWhereOneZeroJumped) {
  for (unsigned seed : {44u, 45u}) {
    const LoopResult result = found("remaster", seed).result;
    EXPECT_FALSE(has(result, "bent link")) << listed(result);
    EXPECT_FALSE(has(result, "another load")) << listed(result);
  }
}

TEST(Load, MovesSeveralAxesAlikeAtOneTime) {
  const auto [truth, result] = found("other-load", 46, 0.2);
  std::set<std::string> axes;
  std::set<double> times;
  std::set<bool> signs;
  for (const TracedEffect& traced : result.trace.effects) {
    EXPECT_EQ(traced.effect.name, "another load") << listed(result);
    axes.insert(to_string(traced.effect.parameter));
    times.insert(traced.effect.shape.at);
    signs.insert(traced.effect.coefficients.front().value > 0);
  }
  for (const Effect& held : result.held)
    if (held.name == "another load") axes.insert(to_string(held.parameter));
  EXPECT_GE(axes.size(), 2u);
  EXPECT_EQ(signs.size(), 1u);
  ASSERT_FALSE(times.empty());
  EXPECT_NEAR(*times.begin(), truth.step_at_s, 60);
}

// What warms up or sinks with the instrument is no load and no growth of a link. Its scale may be
// the growth of all links, see below.
TEST(Load, IsNotNamedWhereTheInstrumentDrifts) {
  for (const char* family : {"settling", "drift", "scale-drift"}) {
    const LoopResult result = found(family, 47).result;
    EXPECT_FALSE(has(result, "another load")) << family << "\n" << listed(result);
    for (const TracedEffect& traced : result.trace.effects)
      EXPECT_TRUE(traced.effect.name != "thermal growth" ||
                  (family == std::string("scale-drift") && is_arm_scale(traced.effect.parameter)))
          << family << "\n"
          << listed(result);
  }
}

// A joint whose stiffness has two slopes gives way under all torques and more under small ones: its
// name says so, and one slope alone is told apart.
TEST(Stiffness, HardensWithLoad) {
  int named = 0;
  for (unsigned seed : {48u, 49u, 50u, 51u}) {
    const auto [truth, result] = found("two-slopes", seed, 0.3);
    for (const TracedEffect& traced : result.trace.effects)
      if (traced.effect.name == "stiffness that hardens with load") {
        ++named;
        EXPECT_EQ(to_string(traced.effect.parameter), truth.parameter);
        EXPECT_GT(traced.effect.coefficients.front().value, 0);
      }
    EXPECT_GT(result.reducible_removed, 0.9) << listed(result);
    EXPECT_FALSE(has(found("compliance", seed, 0.3).result, "stiffness that hardens with load"));
  }
  EXPECT_GE(named, 3);
}

// Growth is of the size and, where the name says so, of the sign of the length.
TEST(Growth, HasTheSizeAndSignOfItsLength) {
  constexpr double kMost = 23e-6 * 60 * 1.02;
  for (const char* family : {"thermal", "cooling", "warm-up"}) {
    const auto [truth, result] = found(family, 48);
    ASSERT_FALSE(result.trace.effects.empty());
    const TracedEffect& traced = result.trace.effects.front();
    EXPECT_TRUE(names(truth, traced)) << listed(result);
    ASSERT_EQ(traced.effect.name, "thermal growth") << family;
    const KinematicChain& chain = result.trace.fit.robot.chain;
    const Link& link = chain.links[static_cast<size_t>(
        link_of_parameter(*find_parameter(chain, traced.effect.parameter)))];
    const bool is_r = is_link_parameter(traced.effect.parameter, LinkParameter::r);
    const double share = traced.effect.coefficients.front().value / (is_r ? link.r : link.d);
    EXPECT_LT(std::abs(share), kMost) << family;
    EXPECT_EQ(share < 0, family == std::string("cooling")) << share;
    EXPECT_EQ(traced.in_words.find("grows") == std::string::npos, share < 0) << traced.in_words;
  }
}

// The nominal robot 3 m from the origin of R_A.
std::string far_robot() {
  std::ifstream file(kNominal);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::string near = "base: {x_mm: 0,";
  text.replace(text.find(near), near.size(), "base: {x_mm: 3000,");
  const std::string path = std::filesystem::temp_directory_path() / "armtrue-far-robot.yaml";
  std::ofstream(path) << text;
  return path;
}

// A scale of the instrument moves the base too, as far as it stands from the origin of R_A.
TEST(Growth, OfAllLinksIsToldFromAScaleWhereTheBaseStandsFar) {
  for (const char* family : {"warm-links", "scale-drift"}) {
    const auto [truth, result] = found(family, 47, 0.12, far_robot());
    ASSERT_FALSE(result.trace.effects.empty()) << family;
    const TracedEffect& traced = result.trace.effects.front();
    EXPECT_TRUE(names(truth, traced.effect)) << listed(result);
    for (const Rival& rival : traced.indistinguishable)
      EXPECT_EQ(moved_by(rival.effect), moved_by(traced.effect)) << describe(rival.effect);
  }
}

TEST(Growth, OfAllLinksIsNotToldFromAScaleWhereTheBaseStandsAtTheOrigin) {
  for (const char* family : {"warm-links", "scale-drift"}) {
    const auto [truth, result] = found(family, 47);
    ASSERT_FALSE(result.trace.effects.empty()) << family;
    const TracedEffect& traced = result.trace.effects.front();
    EXPECT_TRUE(names(truth, traced)) << listed(result);
    const bool is_growth = traced.effect.parameter == "arm.scale";
    EXPECT_TRUE(std::ranges::any_of(traced.indistinguishable,
                                    [&](const Rival& rival) {
                                      return rival.effect.parameter ==
                                             (is_growth ? "instrument.scale" : "arm.scale");
                                    }))
        << family << "\n"
        << listed(result);
    EXPECT_EQ(result.verdict, Verdict::not_separable) << family;
    EXPECT_LT(*result.after_arm, 1.1 * result.before) << family;  // nobody's growth is no error
  }
}

// Lengths are off, and the file lets a fit change zero offsets alone.
TEST(Identify, WhatItLeavesOutIsSaidAndNoEffectStandsInItsPlace) {
  const Robot truth = read_robot(ARMTRUE_CONFIG "/robots/kr360-table4.yaml").robot;
  Robot robot = read_robot(kNominal).robot;
  SimulationOptions options{
      .poses = 60, .repeats = 2, .noise_position = 95e-6, .noise_orientation = 1.5e-4, .seed = 5};
  const Campaign training = simulate(robot, truth, options);
  options.seed = 6;
  const Campaign held_out = simulate(robot, truth, options);
  const auto closed = [&] {
    return close_loop(robot, training, held_out, read_catalogue(kCatalogue), {});
  };
  EXPECT_FALSE(closed().trace.left_out);
  robot.identify = {"A1.theta", "A2.theta", "A3.theta", "A4.theta", "A5.theta", "base", "tool"};
  const LoopResult result = closed();
  ASSERT_TRUE(result.trace.left_out);
  EXPECT_TRUE(result.trace.effects.empty()) << listed(result);
  EXPECT_TRUE(result.trace.fit.robot.effects.empty());
  const int length = *find_parameter(robot.chain, "A3.d");
  EXPECT_EQ(std::ranges::count(result.trace.left_out->parameters, length), 1);
  EXPECT_LT(result.trace.left_out->with, 0.5 * result.trace.left_out->without);
  EXPECT_EQ(result.verdict, Verdict::unexplained);
  EXPECT_NE(verdict_in_words(result).find("'identify' leaves out"), std::string::npos);
}

// Where only zero offsets are off, nothing is missed.
TEST(Identify, MayLeaveOutWhatIsRight) {
  Robot robot = read_robot(kNominal).robot;
  Robot truth = robot;
  for (int j : {1, 2, 4}) truth.chain.links[static_cast<size_t>(j)].theta += 5e-4 * (j - 2.5);
  robot.identify = {"A2.theta", "A3.theta", "A4.theta", "A5.theta", "base", "tool"};
  SimulationOptions options{
      .poses = 60, .repeats = 2, .noise_position = 95e-6, .noise_orientation = 1.5e-4, .seed = 7};
  const Campaign campaign = simulate(robot, truth, options);
  EXPECT_FALSE(left_out_but_shown(robot, campaign));
  // Nor where an effect alone is missed.
  truth.effects = {{"joint compliance",
                    "A3.theta",
                    {DriverKind::gravity_torque, 2, -1, ""},
                    {},
                    {{"c", 3e-7}}}};
  const TraceResult found =
      trace(robot, simulate(robot, truth, options), read_catalogue(kCatalogue), {});
  EXPECT_FALSE(found.left_out);
  ASSERT_FALSE(found.effects.empty());
  EXPECT_EQ(found.effects.front().effect.name, "joint compliance");
}

}  // namespace
}  // namespace armtrue::causes_test
