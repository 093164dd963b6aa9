#include "armtrue/diagnosis/run_comparison.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/prediction.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "support/thinned.h"

namespace armtrue::run_comparison_test {
namespace {

Robot shipped(const std::string& name) {
  return read_robot(ARMTRUE_CONFIG "/robots/" + name + ".yaml").robot;
}

Robot moved(Robot truth, const std::map<std::string, double>& changes) {
  for (const auto& [name, change] : changes)
    move_parameter(truth.chain, *find_parameter(truth.chain, name), change);
  return truth;
}

struct Calibrated {
  Robot robot;
  TrainingRows training;
  Campaign campaign;
  ReadingSigma spread;
};

// What is measured in each run.
struct Plan {
  int poses = 60, repeats = 1;
  double blunders = 0;
  bool orientation = true;
  bool fits_sag = false;  // the effect of kr360-undeclared is an unknown of both models
  double scale = 0;       // of the instrument
  double noise = 0.095e-3;
};

Calibrated calibrated(const Robot& truth, unsigned seed, const Plan& plan = {}) {
  SimulationOptions options;
  options.poses = plan.poses;
  options.repeats = plan.repeats;
  options.blunders = plan.blunders;
  options.orientation = plan.orientation;
  options.seed = seed;
  options.noise_position = plan.noise;
  options.noise_orientation = 0.15e-3;
  Robot nominal = shipped("kr360-spindle");
  Campaign campaign = simulate(nominal, truth, options);
  for (Eigen::Vector3d& point : campaign.position) point *= 1 + plan.scale;
  if (plan.fits_sag) nominal.effects = shipped("kr360-undeclared").effects;
  CalibrationResult result = calibrate(nominal, campaign);
  result.robot.uncertainty = uncertainty_of(result, campaign);
  result.robot.uncertainty->rest = assess(result, campaign).rest;
  return {result.robot, training_rows(campaign), campaign, result.spread};
}

ComparedRun run_of(const std::string& name, const Calibrated& of) {
  ComparedRun run{name, &of.robot, &of.training};
  for (const Effect& effect : of.robot.effects) {
    NamedEffect& named = run.effects.emplace_back(NamedEffect{effect.name,
                                                              to_string(effect.parameter),
                                                              to_string(effect.driver),
                                                              to_string(effect.shape),
                                                              "",
                                                              {}});
    for (const Coefficient& c : effect.coefficients)
      named.coefficients.push_back({c.name, "rad/(N m)", c.value, c.std});
  }
  return run;
}

RunComparison compared(const Calibrated& before, const Calibrated& after) {
  return compare_runs(run_of("before.yaml", before), run_of("after.yaml", after));
}

RunComparison compared_by_readings(const Calibrated& before, const Calibrated& after) {
  ComparedRun one = run_of("before.yaml", before), other = run_of("after.yaml", after);
  one.campaign = &before.campaign;
  other.campaign = &after.campaign;
  one.spread = before.spread;
  other.spread = after.spread;
  return compare_runs(one, other);
}

RunComparison pair_of(unsigned seed, const std::map<std::string, double>& changes,
                      const std::string& truth = "kr360-table4", const Plan& plan = {}) {
  const Robot arm = shipped(truth);
  return compared(calibrated(arm, 2 * seed, plan),
                  calibrated(moved(arm, changes), 2 * seed + 1, plan));
}

bool anything_moved(const RunComparison& found) {
  const auto moved = [](const ComparedParameter& parameter) { return parameter.number.moved(); };
  const auto changed = [](const ComparedEffect& effect) {
    return std::ranges::any_of(effect.numbers, &NumberChange::moved);
  };
  return found.arm->moved() || std::ranges::any_of(found.parameters, moved) ||
         std::ranges::any_of(found.effects, changed);
}

int pairs(int usual) {
  const char* const asked = std::getenv("ARMTRUE_PAIRS");
  return asked ? std::atoi(asked) : usual;
}

struct Alarms {
  int pairs = 0, any = 0, of_arm = 0, undecided = 0;
  double times_chance = 0;  // distance of the arms, mean over the pairs
  double hold_zero = 0;     // share of the intervals
};

// Pairs of runs between which nothing has changed.
Alarms alarms(const std::string& truth, const Plan& plan, int count) {
  Alarms found;
  double inside = 0, intervals = 0;
  for (int seed = 1; seed <= count; ++seed) {
    const RunComparison one = pair_of(seed, {}, truth, plan);
    if (!one.arm->by_chance) continue;
    ++found.pairs;
    found.any += anything_moved(one);
    found.undecided += !one.undecided().empty();
    found.of_arm += one.arm->moved();
    found.times_chance += one.arm->rms / *one.arm->by_chance;
    for (const ComparedParameter& parameter : one.parameters) {
      if (!parameter.number.ci95) continue;
      ++intervals;
      inside += (*parameter.number.ci95)[0] <= 0 && 0 <= (*parameter.number.ci95)[1];
    }
  }
  found.times_chance /= found.pairs;
  found.hold_zero = inside / intervals;
  std::printf(
      "%s, %d poses x %d%s, %.2f blunders: %d pairs, %d alarms, %d of the arm as a whole, %d "
      "undecided; "
      "distance %.2f of chance; %.3f of the intervals hold 0\n",
      truth.c_str(), plan.poses, plan.repeats, plan.orientation ? "" : ", points", plan.blunders,
      found.pairs, found.any, found.of_arm, found.undecided, found.times_chance, found.hold_zero);
  return found;
}

// ARMTRUE_PAIRS=200 is the study whose figures stand in compare-runs(1). Numbers and arm are each
// tested at 1 %: of 20 pairs three alarms come once in 100 times, of 10 two in 60.
TEST(RunComparison, FindsNothingWhereNothingHasChanged) {
  const int count = pairs(20 / thinned(2));
  const int most = count > 100 ? count / 20 : count / 10;
  for (const auto& [truth, plan] :
       {std::pair("kr360-table4", Plan{}), std::pair("kr360-table4", Plan{40, 3, 0.05, true}),
        std::pair("kr360-table4", Plan{60, 1, 0, false}),
        std::pair("kr360-undeclared", Plan{60, 2, 0, true}),  // both models lack the sag of joint 3
        std::pair("kr360-undeclared", Plan{60, 2, 0, true, true}),
        std::pair("kr360-table4", Plan{30, 1, 0, true})}) {
    const Alarms found = alarms(truth, plan, count);
    EXPECT_LE(found.any, most);
    if (std::string(truth) == "kr360-table4" || plan.fits_sag) {
      EXPECT_LE(found.undecided, most);
    }
    EXPECT_EQ(found.pairs, count);
    EXPECT_THAT(found.times_chance, testing::AllOf(testing::Gt(0.6), testing::Lt(1.25)));
  }
}

// Two models lack a sag that makes several times the noise. A length that changed by less than they
// lack is not called unchanged, and the smallest change that would be seen is told.
TEST(RunComparison, IsUndecidedWhereWhatTheModelsLackMayHideAChange) {
  int undecided = 0, moved = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const RunComparison one = pair_of(seed, {{"A3.d", 0.25e-3}, {"A4.alpha", 1e-4}},
                                      "kr360-undeclared", {40, 2, 0, false});
    ASSERT_TRUE(one.arm && one.arm->smallest_seen);
    moved += one.arm_moved().value_or(false);
    if (one.undecided().empty()) continue;
    ++undecided;
    EXPECT_EQ(one.arm_moved(), std::nullopt);
    EXPECT_GT(*one.arm->smallest_seen, one.arm->rms);
    EXPECT_THAT(one.sentence, testing::HasSubstr("only a change above"));
  }
  std::printf("of 10 hidden changes %d moved, %d undecided\n", moved, undecided);
  EXPECT_GE(undecided, 3);
  EXPECT_GE(undecided + moved, 9);
}

// The same two models with their readings, which show the sag alike before and after.
TEST(RunComparison, ReadingsTellAChangeFromWhatTheModelsLack) {
  const Robot arm = shipped("kr360-undeclared");
  const Plan plan{40, 2, 0, false};
  const int count = pairs(20);
  int alarms = 0, seen = 0, seen_by_models = 0;
  for (int seed = 1; seed <= count; ++seed) {
    const Calibrated before = calibrated(arm, 2 * seed, plan);
    const RunComparison same = compared_by_readings(before, calibrated(arm, 2 * seed + 1, plan));
    alarms += same.arm_moved() != std::optional(false);
    const Robot changed = moved(arm, {{"A3.d", 0.4e-3}, {"A4.alpha", 3e-4}, {"A3.theta", 1.5e-4}});
    const RunComparison other =
        compared_by_readings(before, calibrated(changed, 2 * seed + 1, plan));
    ASSERT_TRUE(other.by_readings);
    seen_by_models +=
        compared(before, calibrated(changed, 2 * seed + 1, plan)).arm_moved().has_value();
    EXPECT_GT(*other.smallest_seen(), 0);
    seen += other.arm_moved() != std::optional(false);
  }
  std::printf("by readings, of %d pairs: %d alarms, %d changes seen, %d by models alone\n", count,
              alarms, seen, seen_by_models);
  EXPECT_LE(alarms, std::max(1, count / 20));
  EXPECT_GE(seen, count / 2);
  EXPECT_LT(seen_by_models, seen / 2);
}

// The means of four visits by a tracker beside single ones by a camera.
TEST(RunComparison, RunsThatScatterDifferentlyAreNotToldApart) {
  const Robot arm = shipped("kr360-table4");
  const Plan fine{.poses = 40, .repeats = 4, .orientation = false, .noise = 0.05e-3},
      coarse{.poses = 40, .orientation = false, .noise = 0.2e-3};
  const int count = pairs(25);
  int alarms = 0;
  for (int seed = 1; seed <= count; ++seed) {
    const Calibrated of_tracker = calibrated(arm, 2 * seed, fine),
                     of_camera = calibrated(arm, 2 * seed + 1, coarse);
    const RunComparison one = seed % 2 == 0 ? compared_by_readings(of_tracker, of_camera)
                                            : compared_by_readings(of_camera, of_tracker);
    ASSERT_TRUE(one.by_readings);
    alarms += one.by_readings->moved();
  }
  std::printf("of %d pairs %d alarms\n", count, alarms);
  EXPECT_LE(alarms, std::max(2, count / 20));
}

// An instrument of another scale, or a warmer arm: which, no model tells.
TEST(RunComparison, OneScaleOfAllLengthsIsToldAsStationOrArm) {
  const Robot arm = shipped("kr360-table4");
  const Plan plain, scaled{.scale = 2e-4};
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const RunComparison one =
        compared(calibrated(arm, 2 * seed, plain), calibrated(arm, 2 * seed + 1, scaled));
    EXPECT_EQ(one.arm_moved(), std::nullopt);
    EXPECT_THAT(one.sentence, testing::HasSubstr("the instrument has another scale, or the arm"));
    ASSERT_TRUE(one.arm->scale);
    EXPECT_NEAR(one.arm->scale->ratio, 2e-4, 3e-5);
    // A length that changed beside it is none of the scale.
    const RunComparison both =
        compared(calibrated(arm, 2 * seed, plain),
                 calibrated(moved(arm, {{"A3.theta", 0.5e-3}}), 2 * seed + 1, scaled));
    EXPECT_EQ(both.arm_moved(), true);
  }
}

TEST(RunComparison, NamesAZeroOffsetOfHalfAMilliradian) {
  const int count = pairs(20);
  int named = 0, alone = 0, covered = 0;
  for (int seed = 1; seed <= count; ++seed) {
    const std::string name = seed % 2 ? "A2.theta" : "A4.theta";
    const RunComparison found = pair_of(1000 + seed, {{name, 0.5e-3}});
    int others = 0;
    for (const ComparedParameter& parameter : found.parameters) {
      if (parameter.name != name) {
        others += parameter.number.moved();
        continue;
      }
      named += parameter.number.moved();
      const auto& interval = *parameter.number.ci95;
      covered += interval[0] <= 0.5e-3 && 0.5e-3 <= interval[1];
    }
    alone += others == 0;
    EXPECT_THAT(found.arm_moved(), testing::Optional(true));
  }
  std::printf("%d pairs: named %d, alone %d, interval holds the truth %.3f\n", count, named, alone,
              static_cast<double>(covered) / count);
  EXPECT_EQ(named, count);
  EXPECT_GE(alone, count * 95 / 100);
  EXPECT_GE(covered, count * 9 / 10);
}

// The sag of joint 3 is in both models, and 20 % larger after.
TEST(RunComparison, NamesAnEffectThatHasChanged) {
  const Plan plan{60, 2, 0, true, true};
  Robot truth = shipped("kr360-undeclared");
  const Calibrated before = calibrated(truth, 1, plan);
  const double change = 0.2 * truth.effects.front().coefficients.front().value;
  truth.effects.front().coefficients.front().value += change;
  const RunComparison found = compared(before, calibrated(truth, 2, plan));
  ASSERT_THAT(found.untested, testing::IsEmpty());
  ASSERT_THAT(found.effects, testing::SizeIs(1));
  const NumberChange& number = found.effects.front().numbers.front();
  EXPECT_TRUE(number.moved());
  EXPECT_LE((*number.ci95)[0], change);
  EXPECT_GE((*number.ci95)[1], change);
  EXPECT_THAT(found.arm_moved(), testing::Optional(true));
  EXPECT_THAT(found.sentence, testing::HasSubstr("follows gravity-torque 3), c from 2."));
}

// Only one model has the sag, which the parameters of the other take up: nothing has moved.
TEST(RunComparison, AnEffectOfOneModelIsNoMove) {
  const Robot truth = shipped("kr360-undeclared");
  const Calibrated before = calibrated(truth, 1, {60, 2, 0, true, false}),
                   after = calibrated(truth, 2, {60, 2, 0, true, true});
  const RunComparison found = compared(before, after);
  EXPECT_THAT(found.arm_moved(), testing::Eq(std::nullopt));
  EXPECT_THAT(found.untested.at(0), testing::HasSubstr("gravity-torque 3) (after)"));
}

// Others are held in a model by a prior, and a model without them says the same.
TEST(RunComparison, AnEffectThatMayBeNoneHindersNoTest) {
  const Robot truth = shipped("kr360-table4");
  const Calibrated before = calibrated(truth, 1), after = calibrated(truth, 2);
  ComparedRun with = run_of("after.yaml", after);
  with.effects = {{"joint compliance",
                   "A5.theta",
                   "gravity-torque 5",
                   "linear",
                   "",
                   {{"c", "rad/(N m)", 1e-8, 2e-8}}}};
  EXPECT_THAT(compare_runs(run_of("before.yaml", before), with).untested, testing::IsEmpty());
  with.effects.front().coefficients.front().value = 1e-7;
  EXPECT_THAT(compare_runs(run_of("before.yaml", before), with).untested, testing::SizeIs(1));
}

TEST(RunComparison, AStationSetUpAnewIsNoChangeOfTheArm) {
  const Calibrated before = calibrated(shipped("kr360-table4"), 1);
  const Calibrated after = calibrated(
      moved(shipped("kr360-table4"), {{"base.x", 0.5}, {"base.rz", 0.3}, {"tool.z", 0.02}}), 2);
  const RunComparison found = compared(before, after);
  EXPECT_THAT(found.arm_moved(), testing::Optional(false));
  EXPECT_LT(found.arm->rms, 2 * *found.arm->by_chance);
  const auto base = std::ranges::find(found.parameters, "base.x", &ComparedParameter::name);
  EXPECT_TRUE(base->number.moved());
  EXPECT_FALSE(base->of_arm);
  EXPECT_THAT(found.sentence, testing::HasSubstr("set up anew, which is no change of the arm"));
}

TEST(RunComparison, TheDistanceOfTheArmsIsThatOfTheChange) {
  // q4 turns a wrist; with base and tool placed, a change of A2.theta by d moves the points of
  // random poses by about d times their distance from axis 2.
  const Robot nominal = shipped("kr360-spindle");
  const ArmDifference found = arm_difference(nominal, moved(nominal, {{"A2.theta", 0.5e-3}}),
                                             poses_of_both(nominal, nominal));
  EXPECT_GT(found.mean, 0.2e-3);
  EXPECT_LT(found.mean, 1.5e-3);
  EXPECT_GE(found.max, found.distance[0]);
  EXPECT_EQ(found.distance[found.largest], found.max);
  EXPECT_FALSE(found.p_value);  // a nominal robot states no uncertainty
}

TEST(RunComparison, BaseAndToolAreNoDifference) {
  const Robot nominal = shipped("kr360-spindle");
  const Robot other = moved(
      nominal,
      {{"base.x", 1.0}, {"base.rz", 2.0}, {"A1.theta", 1e-3}, {"A6.theta", 2e-3}, {"tool.y", 0.1}});
  EXPECT_LT(arm_difference(nominal, other, poses_of_both(nominal, nominal)).max, 1e-7);
  EXPECT_LT(arm_difference(nominal, nominal, poses_of_both(nominal, nominal)).max, 1e-9);
}

TEST(RunComparison, ModelsOfTheSameReadingsAreNotTested) {
  const Calibrated run = calibrated(shipped("kr360-table4"), 1);
  const RunComparison found = compared(run, run);
  EXPECT_EQ(found.readings, Shared::all);
  EXPECT_EQ(found.tested, 0);
  EXPECT_THAT(found.arm_moved(), testing::Eq(std::nullopt));
  EXPECT_FALSE(found.parameters.front().number.std);
  EXPECT_THAT(found.sentence, testing::HasSubstr("Two models of the same readings"));
}

// A parameter that one model holds is taken up by others, which have not moved.
TEST(RunComparison, OtherUnknownsAreNotTested) {
  const Calibrated before = calibrated(shipped("kr360-table4"), 1);
  Calibrated after = calibrated(shipped("kr360-table4"), 2);
  after.robot.std.erase("A3.d");
  const RunComparison found = compared(before, after);
  EXPECT_THAT(found.arm_moved(), testing::Eq(std::nullopt));
  ASSERT_THAT(found.untested, testing::SizeIs(1));
  EXPECT_THAT(found.untested[0], testing::HasSubstr("A3.d (before)"));
}

NamedEffect sag(double value) {
  return {"joint compliance", "A3.theta", "gravity-torque 3",
          "linear",           "",         {{"c", "rad/(N m)", value, 1e-9}}};
}

TEST(RunComparison, EffectsAreMatchedByWhatTheyAre) {
  ComparedRun before{"before.yaml"}, after{"after.yaml"};
  before.effects = {sag(2e-7)};
  after.effects = {sag(3e-7),
                   {"eccentricity",
                    "A4.theta",
                    "joint-angle 4",
                    "harmonic 1",
                    "",
                    {{"sin", "rad", 1e-4, 1e-6}, {"cos", "rad", 0, 1e-6}}}};
  before.readings = {"a"};
  after.readings = {"b"};
  const RunComparison found = compare_runs(before, after);
  ASSERT_THAT(found.effects, testing::SizeIs(2));
  EXPECT_EQ(found.effects[0].in, InRuns::both);
  EXPECT_NEAR(*found.effects[0].numbers[0].change, 1e-7, 1e-15);
  EXPECT_NEAR(*found.effects[0].numbers[0].std, std::sqrt(2) * 1e-9, 1e-15);
  EXPECT_TRUE(found.effects[0].numbers[0].moved());
  EXPECT_EQ(found.effects[1].in, InRuns::after);
  EXPECT_THAT(found.sentence, testing::HasSubstr("Only after: eccentricity"));
}

// Steps of one zero at several times: in another order, and each with a standard deviation of its
// own.
TEST(RunComparison, EffectsOfOneFormAreMatchedByTheirInnerValues) {
  const auto step = [](const std::string& at_s, double value, double std) {
    return NamedEffect{
        "jump", "A2.theta", "time", "step", "at_s " + at_s + ", ", {{"step", "rad", value, std}}};
  };
  ComparedRun before{"before.yaml"}, after{"after.yaml"};
  before.effects = {step("100", 1e-4, 1e-6), step("200", 2e-4, 1e-4), step("300", 1, 1e-6)};
  after.effects = {step("400", 2, 1e-6), step("200", 2.5e-4, 1e-4), step("100", 1e-4, 1e-6)};
  before.readings = {"a"};
  after.readings = {"b"};
  const RunComparison found = compare_runs(before, after);
  ASSERT_THAT(found.effects, testing::SizeIs(3));
  EXPECT_FALSE(found.effects[0].same_inner);
  EXPECT_THAT(found.effects[0].numbers[0].before, testing::Optional(1.0));
  EXPECT_TRUE(found.effects[1].same_inner);
  EXPECT_NEAR(found.effects[1].numbers[0].change.value(), 0.5e-4, 1e-15);
  EXPECT_NEAR(found.effects[1].numbers[0].std.value(), std::sqrt(2) * 1e-4, 1e-12);
  EXPECT_FALSE(found.effects[1].numbers[0].moved());
  EXPECT_TRUE(found.effects[2].same_inner);
  EXPECT_NEAR(found.effects[2].numbers[0].std.value(), std::sqrt(2) * 1e-6, 1e-12);
}

TEST(RunComparison, OneRowInBothMakesThemDependent) {
  TrainingRows a{3, {1, 5, 9}}, b{3, {2, 5, 11}}, c{3, {2, 6, 11}};
  const auto shared = [](const TrainingRows& one, const TrainingRows& other) {
    return shared_readings({"a", nullptr, &one}, {"b", nullptr, &other});
  };
  EXPECT_EQ(shared(a, a), Shared::all);
  EXPECT_EQ(shared(a, b), Shared::some);
  EXPECT_EQ(shared(a, c), Shared::none);
  EXPECT_EQ(shared(a, {}), Shared::unknown);
  Robot with_wires;  // some distances of two campaigns at the same poses are alike by chance
  with_wires.chain.anchors.emplace_back();
  const auto of_numbers = [&](const TrainingRows& one, const TrainingRows& other) {
    return shared_readings({"a", &with_wires, &one}, {"b", nullptr, &other});
  };
  EXPECT_EQ(of_numbers(a, a), Shared::all);
  EXPECT_EQ(of_numbers(a, b), Shared::none);
}

TEST(RunComparison, OtherStructuresAreRefused) {
  const Robot robot = shipped("kr360-spindle");
  EXPECT_EQ(why_not_comparable(robot, "a", robot, "b"), "");
  Robot other = robot;
  other.chain.links.pop_back();
  EXPECT_THAT(why_not_comparable(robot, "a", other, "b"), testing::HasSubstr("links"));
  other = robot;
  other.chain.links[2].alpha += 1.6;
  EXPECT_THAT(why_not_comparable(robot, "a", other, "b"), testing::HasSubstr("two conventions"));
  other = robot;
  other.chain.links[1].sign = -other.chain.links[1].sign;
  EXPECT_THAT(why_not_comparable(robot, "a", other, "b"), testing::HasSubstr("sign"));
}

}  // namespace
}  // namespace armtrue::run_comparison_test
