#include "armtrue/tracing/description.h"

#include <gmock/gmock.h>

#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/tracing/verdict.h"

namespace armtrue::description_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// A loop that found one effect, with its gain on the held-out poses.
LoopResult found(bool from_catalogue, const std::vector<HeldOutGain>& gains) {
  LoopResult loop;
  loop.trace.fit.robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  TracedEffect& traced = loop.trace.effects.emplace_back();
  traced.effect = {"found", "A2.theta", {DriverKind::time, -1, -1, ""}, Shape{}, {{"c", 1e-6}}};
  traced.from_catalogue = from_catalogue;
  if (from_catalogue)
    traced.indistinguishable.push_back({.effect = traced.effect, .from_catalogue = true});
  loop.gains = gains;
  loop.curves.emplace_back();
  return loop;
}

// Without held-out poses the sentence says nothing of them.
TEST(Description, PredictionImprovesIsSaidOfTheHeldOutPosesOnlyWhereTheyShowIt) {
  const HeldOutGain shown{.position = 1e-4, .ci95 = {2e-5, 2e-4}};
  const HeldOutGain not_shown{.position = 1e-4, .ci95 = {-2e-5, 2e-4}};
  const auto words = [](bool from_catalogue, const std::vector<HeldOutGain>& gains) {
    const LoopResult loop = found(from_catalogue, gains);
    return in_words(loop.trace.effects.front(), gains.empty() ? nullptr : &gains.front(), {},
                    loop.trace.fit.robot);
  };
  const std::string unclear =
      "prediction improves for training poses left out, not clearly for the held-out ones";
  EXPECT_THAT(words(false, {shown}), HasSubstr("; prediction improves; no known"));
  EXPECT_THAT(words(false, {}), HasSubstr("; prediction improves; no known"));
  EXPECT_THAT(words(false, {not_shown}), HasSubstr("; " + unclear + "; no known"));
  EXPECT_THAT(words(true, {shown}), HasSubstr("; prediction improves; cause is one"));
  EXPECT_THAT(words(true, {not_shown}), HasSubstr("; " + unclear + "; cause is one"));
}

TEST(Description, AFamilyOfWhichNoMemberIsShownHasItsName) {
  LoopResult loop = found(true, {});
  loop.verdict = Verdict::not_separable;
  EXPECT_THAT(verdict_in_words(loop), HasSubstr("the cause is one of several"));
  TracedEffect& traced = loop.trace.effects.front();
  traced.effect.family = {"thermal growth of the arm", 1};
  traced.shared_with.resize(2, traced.effect);
  traced.shared_with.front().parameter = "A3.d";
  EXPECT_THAT(for_the_cell(traced, nullptr, loop.trace.fit.robot),
              HasSubstr("; or A2.theta and A3.d, or all of these"));
  EXPECT_THAT(verdict_in_words(loop), HasSubstr("'thermal growth of the arm' is there"));
}

// The verdict is `unexplained` though the other readings fit.
TEST(Description, ReadingsThatAreLeftOutTogetherAreWhatSpeaksAgainstTheModel) {
  LoopResult loop = found(false, {});
  loop.left_out_together = "readings are left out in 5 of 5 visits";
  loop.lack_of_fit = 0.4;
  EXPECT_THAT(verdict_in_words(loop), HasSubstr("; readings are left out in 5 of 5 visits"));
  loop.lack_of_fit = 1e-4;
  EXPECT_THAT(verdict_in_words(loop), HasSubstr("; unexplained, or the instrument is noisier"));
}

TEST(Description, TheNoiseToStateIsThatOfTheReadings) {
  LoopResult loop = found(true, {});
  loop.after = 1e-4;
  EXPECT_THAT(unknown_noise_in_words(loop), HasSubstr("state noise: position_mm"));
  loop.of_images = true;
  EXPECT_THAT(unknown_noise_in_words(loop), HasSubstr("state noise: pixel_px"));
}

// What a knock leaves follows time too: beside it only clear evidence makes a drift the arm's.
TEST(Description, BesideAKnockOfTheInstrumentADriftMayBeItsRest) {
  const Driver time{DriverKind::time, -1, -1, ""}, warm{DriverKind::temperature, -1, -1, "arm"};
  LoopResult loop = found(true, {});
  Robot& robot = loop.trace.fit.robot;
  TracedEffect& traced = loop.trace.effects.front();
  traced.indistinguishable.clear();
  traced.in_words = "a known cause";
  const auto beside = [&](const char* other, const Driver& driver) {
    robot.effects = {Effect{"other", other, driver, Shape{}, {}}, traced.effect};
    return may_be_instrument(traced, robot);
  };
  for (const double evidence : {5.0, 13.0}) {
    traced.evidence.delta_ebic = evidence;
    for (const char* station : {"base", "base.y", "instrument.range"}) {
      EXPECT_TRUE(beside(station, time)) << station;
      EXPECT_FALSE(beside(station, warm)) << station;
    }
    EXPECT_FALSE(beside("A3.theta", time));
  }
  traced.evidence.delta_ebic = 14.0;
  EXPECT_FALSE(beside("base", time));
  traced.evidence.delta_ebic = 5.0;
  traced.effect.driver = warm;
  EXPECT_FALSE(beside("base", time));
  traced.effect.driver = time;
  traced.effect.parameter = "base.z";
  EXPECT_FALSE(beside("base", time));  // it moves no program in any case
}

// A rail that is not straight shifts the arm by its travel; no joint angle does.
TEST(Description, ARailMayBend) {
  LoopResult loop = found(false, {});
  loop.trace.fit.robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-rail.yaml").robot;
  TracedEffect& traced = loop.trace.effects.front();
  traced.effect.parameter = "A1.d";
  traced.effect.driver = {DriverKind::joint_angle, 0, -1, ""};
  EXPECT_FALSE(may_be_instrument(traced, loop.trace.fit.robot));
  traced.effect.driver.joint = 2;
  EXPECT_TRUE(may_be_instrument(traced, loop.trace.fit.robot));
}

// Lengths and bases do not follow joint angles; angles of joints do.
TEST(Description, SaysWhereTheInstrumentMayErr) {
  const Driver angle{DriverKind::joint_angle, 1, -1, ""}, time{DriverKind::time, -1, -1, ""};
  LoopResult loop = found(false, {});
  TracedEffect& traced = loop.trace.effects.front();
  const auto said = [&](const std::string& parameter, const Driver& driver) {
    traced.effect.parameter = parameter;
    traced.effect.driver = driver;
    return may_be_instrument(traced, loop.trace.fit.robot);
  };
  for (const char* parameter : {"base", "base.rx", "A2.d", "A4.r"}) {
    EXPECT_TRUE(said(parameter, angle)) << parameter;
    EXPECT_FALSE(said(parameter, time)) << parameter;
  }
  for (const char* parameter : {"A2.theta", "A3.alpha", "tool.x"})
    EXPECT_FALSE(said(parameter, angle)) << parameter;
  traced.effect.may_be_instrument = said("A2.d", angle);
  EXPECT_THAT(for_the_cell(traced, nullptr, loop.trace.fit.robot),
              HasSubstr("; may be the instrument"));
  Effect offset{"radial offset", "instrument.range", {DriverKind::constant, -1, -1, ""}, {}, {}};
  traced.indistinguishable.push_back({.effect = offset, .from_catalogue = true});
  EXPECT_TRUE(said("A2.theta", angle));
}

// What turns joint 5 once per turn of axis 4 moves the tool as a wobble of axis 4 does.
TEST(Description, AJointThatFollowsForNoListedCauseIsToldBesideAName) {
  LoopResult loop = found(true, {});
  const Driver angle{DriverKind::joint_angle, 3, -1, ""};
  TracedEffect traced;
  traced.in_words = "axis {k} wobbles";
  traced.effect.name = "axis wobble";
  traced.effect.parameter = "A5.alpha";
  traced.effect.driver = angle;
  Rival rival{.effect = traced.effect, .correlation = 1, .delta_ebic = 2.8};
  rival.effect.name = "unexplained";
  const auto said = [&](const std::string& parameter, double behind) {
    rival.effect.parameter = parameter;
    rival.delta_ebic = behind;
    traced.indistinguishable = {rival};
    return for_the_cell(traced, nullptr, loop.trace.fit.robot);
  };
  EXPECT_THAT(said("A5.theta", 2.8),
              HasSubstr("axis 4 wobbles; or A5.theta follows joint-angle 4 for a "
                        "cause that is not listed"));
  for (const std::string& plain :
       {said("A5.theta", 7), said("A5.beta", 2.8), said("A5.alpha", 2.8)})
    EXPECT_EQ(plain, "axis 4 wobbles");
  rival.from_catalogue = true;  // one of the list is told by its name
  EXPECT_THAT(said("A5.theta", 2.8), Not(HasSubstr("not listed")));
}

// Errors in floors: a perfect model has 1.
Verdict concluded(const std::vector<TracedEffect>& effects, double after, bool together = false) {
  return conclude({effects, 0.5, true, after, 1, 1.3, 1.5, 1, together});
}

TEST(Verdict, OfARivalDependsOnWhetherItIsAnotherCause) {
  std::vector<TracedEffect> effects = found(true, {}).trace.effects;
  Effect& rival = effects[0].indistinguishable[0].effect;
  rival.driver = *parse_driver("tool-weight 2");
  EXPECT_EQ(concluded(effects, 1), Verdict::closed);  // the same name and parameter
  rival.parameter = "A3.theta";
  EXPECT_EQ(concluded(effects, 1), Verdict::not_separable);
  EXPECT_EQ(concluded(effects, 2.1), Verdict::unexplained);
}

// A stand that sinks moves readings as a column does that grows, whether or not that has a name.
TEST(Verdict, OfWhatMovesSomethingElseInTimeNeedsNoName) {
  const Driver time{DriverKind::time, -1, -1, ""}, angle{DriverKind::joint_angle, 3, -1, ""};
  const auto is_other = [](const char* found, const char* rival, const Driver& driver) {
    const Effect effect{"thermal growth", found, driver, {}, {}};
    return is_other_cause(effect, {.effect = {"unexplained", rival, driver, {}, {}}});
  };
  EXPECT_TRUE(is_other("A1.r", "base.z", time));
  EXPECT_TRUE(is_other("base.rz", "A1.theta", time));
  EXPECT_TRUE(is_other("A6.theta", "tool.rz", time));
  EXPECT_FALSE(is_other("A1.r", "A2.r", time));
  EXPECT_TRUE(is_other("arm.scale", "instrument.scale", time));
  EXPECT_FALSE(is_other("base.z", "instrument.scale", time));
  EXPECT_FALSE(is_other("A6.theta", "tool.rz", angle));  // no tool follows an axis of the arm
}

// A cell that only gets warmer does not tell its temperature from time.
TEST(Verdict, OfATemperatureThatGrowsWithTimeNeitherIsTheCause) {
  const Effect drift{"zero drift", "A2.theta", {DriverKind::time, -1, -1, ""}, {}, {}};
  Rival warmth{
      .effect = {"unexplained", "A2.theta", {DriverKind::temperature, -1, -1, "arm"}, {}, {}}};
  warmth.delta_ebic = 2;
  EXPECT_TRUE(is_other_cause(drift, warmth));
  warmth.delta_ebic = 20;
  EXPECT_FALSE(is_other_cause(drift, warmth));
}

// Of two parameters that show one cause neither is a rival: the axis that shifts is the same.
TEST(Verdict, OfOneCauseThatTwoParametersShowIsClosed) {
  const Driver driver{DriverKind::joint_angle, 2, -1, ""};
  const Effect effect{"bearing run-out", "A3.d", driver, harmonic_shape(1), {}};
  Rival rival{.effect = effect, .from_catalogue = true};
  rival.effect.parameter = "A2.r";
  EXPECT_FALSE(is_other_cause(effect, rival));
  rival.effect.driver.joint = 3;
  EXPECT_TRUE(is_other_cause(effect, rival));
}

TEST(Words, APolynomialIsNoCauseThatIsShown) {
  LoopResult loop = found(true, {});
  TracedEffect traced = loop.trace.effects.front();
  traced.indistinguishable.clear();
  traced.effect.parameter = "instrument.point";
  traced.effect.driver = {DriverKind::place, -1, -1, ""};
  traced.effect.shape = series_shape(SeriesBasis::polynomial, 2);
  EXPECT_THAT(in_words(traced, nullptr, {}, loop.trace.fit.robot),
              AllOf(HasSubstr("shows no cause"), Not(HasSubstr("cause shown"))));
}

// Each gear has its own play.
TEST(CommonBacklash, IsThatOfMostJointsWhichGoOnOrStayBehindAlike) {
  const KinematicChain chain = found(false, {}).trace.fit.robot.chain;
  const auto backlash = [&](const std::vector<double>& values, double std = 1e-5) {
    std::vector<TracedEffect> effects;
    for (size_t j = 0; j < values.size(); ++j) {
      const int joint = static_cast<int>(j);
      TracedEffect& traced = effects.emplace_back();
      traced.effect.parameter = parameter_name(chain, zero_offset(chain, joint));
      traced.effect.driver = {DriverKind::arrival, joint, -1, ""};
      traced.effect.shape.kind = ShapeKind::sign;
      traced.effect.coefficients = {{"c", joint_link(chain, joint).sign * values[j], std}};
    }
    return common_backlash(chain, effects);
  };
  const auto common = backlash({3.5e-4, 3.4e-4, 3.6e-4, 3.5e-4, 3.5e-4});
  ASSERT_TRUE(common);
  EXPECT_NEAR(*common, 3.5e-4, 1e-6);
  EXPECT_LT(backlash({-3.5e-4, -3.4e-4, -3.6e-4, -3.5e-4, -3.5e-4}).value_or(0), 0);
  EXPECT_EQ(backlash({-3.5e-4, 3.4e-4, -3.6e-4, 3.5e-4, -3.5e-4}), std::nullopt);
  EXPECT_EQ(backlash({3.5e-4, 2.4e-4, 4.6e-4, 1.5e-4, 3.5e-4}), std::nullopt);
  EXPECT_EQ(backlash({3.5e-4, 3.5e-4}), std::nullopt);
  // Of six joints. Three that stay behind alike may be gears; gears do not go on.
  EXPECT_TRUE(backlash({3.5e-4, 3.5e-4, 3.5e-4}));
  EXPECT_EQ(backlash({-3.5e-4, -3.5e-4, -3.5e-4}), std::nullopt);
  // Known to a third: gears may be that different.
  EXPECT_TRUE(backlash({3.5e-4, 2.4e-4, 4.4e-4, 3.5e-4}, 4e-5));
  EXPECT_EQ(backlash({-3.5e-4, -3.4e-4, -3.6e-4, -3.5e-4}, 4e-5), std::nullopt);
}

TEST(Verdict, ReadingsLeftOutTogetherAreUnexplained) {
  EXPECT_EQ(concluded({}, 1), Verdict::nothing_to_explain);
  EXPECT_EQ(concluded({}, 1, true), Verdict::unexplained);
  EXPECT_EQ(concluded({}, 1.4), Verdict::too_few_poses);
}

TEST(Verdict, WithoutOthersAndFreedomIsThatOfTooFewPoses) {
  const std::vector<TracedEffect> effects = found(false, {}).trace.effects;
  for (const auto& some : {effects, std::vector<TracedEffect>{}})
    EXPECT_EQ(conclude({.effects = some, .lack_of_fit = 0.5, .all_from_few = true}),
              Verdict::too_few_poses);
}

}  // namespace
}  // namespace armtrue::description_test
