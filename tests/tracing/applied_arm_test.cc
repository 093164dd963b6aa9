// What an arm does without a name: random effects beside the names, applied together.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/split.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/statistics/summary.h"
#include "armtrue/tracing/loop.h"
#include "support/thinned.h"
#include "tracing/hidden_campaign.h"
#include "tracing/joint_curves.h"
#include "tracing/judged_names.h"
#include "tracing/random_effects.h"

namespace armtrue::applied_arm_test {
namespace {

const std::string kNominal = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";
const std::string kCatalogue = ARMTRUE_CONFIG "/effects/catalogue.yaml";

// So many sines: of any joint's angle in theta of any link, or of the joint before in its alpha.
armtrue_oracle::HiddenEffect many_sines(int count, double amplitude, unsigned seed) {
  struct Sine {
    int link, joint, cycles;
    bool is_twist;
    double phase;
  };
  armtrue_oracle::Dice dice(seed);
  std::vector<Sine> sines;
  for (int k = 0; k < count; ++k) {
    const int link = dice.below(6), joint = dice.below(6);
    const bool is_twist = dice.below(2) == 1;
    // A bearing tilts its link with its own angle; a zero offset may follow any joint.
    sines.push_back({link, is_twist ? std::max(0, link - 1) : joint, 1 + dice.below(3), is_twist,
                     dice.uniform(0, 6.28)});
  }
  return [=](const armtrue_oracle::Moment& moment, armtrue_oracle::OracleArm& arm) {
    for (const Sine& sine : sines) {
      armtrue_oracle::OracleLink& link = arm.links[sine.link];
      (sine.is_twist ? link.alpha : link.theta) +=
          amplitude * std::sin(sine.cycles * moment.q[sine.joint] + sine.phase);
    }
  };
}

struct Judged {
  double named, applied;  // mean held-out error [m]
  size_t added;
};

Judged judge(const Campaign& all, std::uint64_t seed) {
  const Split split = split_by_pose(all, 0.4, seed);
  const Campaign training = all.select(split.training), held_out = all.select(split.held_out);
  const LoopResult loop = close_loop(read_robot(kNominal).robot, training, held_out,
                                     read_catalogue(kCatalogue));
  return {loop.after_named, loop.after,
          result_of(loop).robot.effects.size() - loop.trace.fit.robot.effects.size()};
}

// Names take what stands out, so some arms leave little; what is applied besides never costs.
TEST(AppliedArm, ManySmallEffectsPredictTogether) {
  double gain = 0;
  int applied = 0;
  const int campaigns = 4 / thinned(2);
  for (int seed = 1; seed <= campaigns; ++seed) {
    const Judged judged = judge(visits(kNominal, many_sines(60, 5e-5, seed), 200, seed), seed);
    EXPECT_LE(judged.applied, judged.named);
    if (judged.added == 0) continue;
    EXPECT_GE(judged.added, 20u);
    gain += std::log(judged.named / judged.applied);
    ++applied;
  }
  ASSERT_GE(applied, campaigns / 2);
  EXPECT_GT(gain / applied, 0.05);
}

TEST(AppliedArm, HarmsNothingWhereNothingIsHidden) {
  int with_some = 0;
  for (int seed = 1; seed <= 10 / thinned(2); ++seed) {
    const Judged judged = judge(visits(kNominal, many_sines(0, 0, seed), 100, seed), seed);
    with_some += judged.added > 0;
  }
  EXPECT_EQ(with_some, 0);
}

// The axis of a joint shifts twice per turn: no rigid arm and no listed cause does that, but a ring that
// is out of round does, and no smooth field of space explains it. So it is the arm's.
TEST(AppliedArm, WhatNoFieldOfSpaceExplainsIsTheArms) {
  const armtrue_oracle::HiddenEffect out_of_round = [](const armtrue_oracle::Moment& moment,
                                                  armtrue_oracle::OracleArm& arm) {
    arm.links[3].d += 6e-4 * std::cos(2 * moment.q[2]);
  };
  const Campaign all = visits(kNominal, out_of_round, 120, 5);
  const Split split = split_by_pose(all, 0.3, 1);
  const LoopResult loop =
      close_loop(read_robot(kNominal).robot, all.select(split.training),
                 all.select(split.held_out), read_catalogue(kCatalogue));
  const std::vector<Effect>& effects = result_of(loop).robot.effects;
  ASSERT_FALSE(loop.trace.effects.empty());
  EXPECT_FALSE(loop.trace.effects.front().from_catalogue);
  EXPECT_LT(loop.after, 1.1 * loop.floor);
  EXPECT_TRUE(std::ranges::none_of(
      effects, [](const Effect& effect) { return effect.may_be_instrument; }));
}

// The zero of a joint that changes by so much at each of some times [s; rad].
armtrue_oracle::HiddenEffect jumps_of_zero(int link, std::vector<std::array<double, 2>> jumps) {
  return [=](const armtrue_oracle::Moment& moment, armtrue_oracle::OracleArm& arm) {
    for (const auto& [time_s, size] : jumps)
      if (moment.time_s >= time_s) arm.links[link].theta += size;
  };
}

LoopResult loop_of(const armtrue_oracle::HiddenEffect& effect, unsigned seed) {
  const Campaign all = visits(kNominal, effect, 120, seed);
  const Split split = split_by_pose(all, 0.25, 1);
  return close_loop(read_robot(kNominal).robot, all.select(split.training),
                    all.select(split.held_out), read_catalogue(kCatalogue));
}

bool follows_time(const Effect& effect) { return effect.driver.involves(DriverKind::time); }

// Friction that remembers, or something that slips: the zero changes again and again, and each
// change is a clear step.
TEST(AppliedArm, AZeroThatWandersHasNoEventsAndMovesNoProgram) {
  const LoopResult loop = loop_of(
      jumps_of_zero(1, {{300, 4e-4}, {750, -5e-4}, {1100, 4.5e-4}, {1500, -4e-4}, {1950, 5e-4}}),
      4);
  EXPECT_EQ(loop.wandering, std::vector<Parameter>{"A2.theta"});
  EXPECT_EQ(loop.verdict, Verdict::unexplained);
  EXPECT_TRUE(std::ranges::none_of(result_of(loop).robot.effects, follows_time));
}

// A joint that was mastered anew twice has two events.
TEST(AppliedArm, TwoEventsOfOneZeroAreNoWalk) {
  const LoopResult loop = loop_of(jumps_of_zero(2, {{900, 4e-4}, {2100, -3e-4}}), 4);
  EXPECT_TRUE(loop.wandering.empty());
  EXPECT_EQ(loop.verdict, Verdict::closed);
  EXPECT_EQ(std::ranges::count_if(loop.trace.fit.robot.effects, follows_time), 2);
}

// Readings of the arm that `seed` makes, at poses of their own.
Campaign other_visits(const armtrue_oracle::HiddenEffect& effect, unsigned seed) {
  std::vector<std::array<double, 6>> commanded;
  for (const JointVector& q : random_configurations(read_robot(kNominal).robot, 300, {}, 1000))
    commanded.push_back({q[0], q[1], q[2], q[3], q[4], q[5]});
  return visits(kNominal, effect, commanded, seed);
}

// Mean error of the arm of a robot on readings of the arm alone [m]: without what the instrument
// did, base and tool placed.
double arm_error(Robot robot, const Campaign& of_arm) {
  std::erase_if(robot.effects,
                [](const Effect& effect) { return owner_of(effect) == Owner::instrument; });
  robot.identify = {"base", "tool"};
  CalibrationOptions options;
  options.fitted_effects = 0;
  return summarize(evaluate(calibrate(robot, of_arm, options).robot, of_arm).reading_errors()).mean;
}

// More poses make the same model more exact: those that judged it count too, in the end.
TEST(AppliedArm, IsFittedToAllPosesInTheEnd) {
  const armtrue_oracle::HiddenEffect sag = [](const armtrue_oracle::Moment& moment,
                                              armtrue_oracle::OracleArm& arm) {
    arm.links[2].theta += 2e-7 * moment.torque[2];
  };
  const Robot robot = read_robot(kNominal).robot;
  double judged = 0, in_the_end = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const Campaign all = visits(kNominal, sag, 40, seed), others = other_visits(sag, seed);
    const Split split = split_by_pose(all, 0.4, seed);
    const LoopResult loop = close_loop(robot, all.select(split.training),
                                       all.select(split.held_out), read_catalogue(kCatalogue));
    const FitToAll to_all = fit_to_all(robot, loop, all, read_catalogue(kCatalogue));
    EXPECT_EQ(to_all.sound.rows(), all.rows());
    EXPECT_EQ(to_all.fit.robot.effects.size(), result_of(loop).robot.effects.size());
    judged += arm_error(result_of(loop).robot, others);
    in_the_end += arm_error(to_all.fit.robot, others);
  }
  EXPECT_LT(in_the_end, 0.98 * judged);
}

// What follows the course of a campaign is not applied. The arm that is stands where it stood in
// the mean, not where it was at the time 0.
TEST(AppliedArm, StandsAtTheMeanOfWhatItDoesNotFollow) {
  constexpr double kRate = 1e-6;  // rad/s
  const armtrue_oracle::HiddenEffect creep = [](const armtrue_oracle::Moment& moment,
                                                armtrue_oracle::OracleArm& arm) {
    arm.links[2].theta += kRate * moment.time_s;
  };
  const Campaign campaign = visits(kNominal, creep, 60, 3);
  ASSERT_FALSE(campaign.time_s.empty());
  const CalibrationResult fit = calibrate(read_robot(kNominal).robot, campaign);
  Effect by_time;
  by_time.parameter = fit.robot.chain.links[2].name + ".theta";
  by_time.driver.kind = DriverKind::time;
  by_time.coefficients = {{"c", kRate}};
  RandomEffects random;
  random.of_campaign = {by_time};
  const Robot applied = applied_arm(fit, campaign, random).robot;
  EXPECT_TRUE(applied.effects.empty());
  const double last = *std::ranges::max_element(campaign.time_s);
  EXPECT_NEAR(applied.chain.links[2].theta, fit.robot.chain.links[2].theta, 0.1 * kRate * last);
}

// Each joint wanders over its own angle: truth, minus its mean over the poses, lies in the band of
// its curve where that is said, and the band is no wider than it must be.
TEST(JointCurves, HoldTheTruthInTheirBand) {
  constexpr double kSize = 2e-4;
  double inside = 0, points = 0, standardized = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    armtrue_oracle::Dice dice(seed);
    std::array<std::array<double, 3>, 6> phases{};
    for (auto& of_joint : phases)
      for (double& phase : of_joint) phase = dice.uniform(0, 6.28);
    const auto wander = [phases](int joint, double q) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += kSize / (k + 2) * std::sin((k + 2) * q + phases[joint][k]);
      return sum;
    };
    const armtrue_oracle::HiddenEffect effect = [&](const armtrue_oracle::Moment& moment,
                                                    armtrue_oracle::OracleArm& arm) {
      for (int joint = 0; joint < 6; ++joint)
        arm.links[joint].theta += wander(joint, moment.q[joint]);
    };
    const Campaign campaign = visits(kNominal, effect, 150, seed);
    const CalibrationResult fit = calibrate(read_robot(kNominal).robot, campaign);
    const RandomEffects random = random_effects_beside(fit, campaign);
    const std::vector<JointCurve> curves =
        joint_curves(applied_arm(fit, campaign, random), random, campaign);
    ASSERT_EQ(curves.size(), 6u);
    for (const JointCurve& curve : curves) {
      double mean = 0;
      for (const JointVector& q : campaign.q)
        mean += wander(curve.joint, q[curve.joint]) / campaign.rows();
      for (const CurvePoint& point : curve.points) {
        const double error = point.value - (wander(curve.joint, point.driver) - mean);
        inside += std::abs(error) <= point.half_width;
        standardized += std::pow(1.96 * error / point.half_width, 2);
        ++points;
      }
      for (double named : curve.named) EXPECT_EQ(named, 0);
    }
  }
  EXPECT_GT(inside / points, 0.9);
  EXPECT_GT(standardized / points, 0.4);
}

}  // namespace
}  // namespace armtrue::applied_arm_test
