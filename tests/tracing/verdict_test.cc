// What the figures of a loop conclude.

#include "armtrue/tracing/verdict.h"

#include <gtest/gtest.h>

#include "armtrue/search/trace.h"

namespace armtrue::verdict_test {
namespace {

const std::vector<TracedEffect> kNone;
const std::vector<TracedEffect> kOne(1);

TracedEffect with_a_rival() {
  TracedEffect traced;
  traced.effect.name = "joint compliance";
  Rival& rival = traced.indistinguishable.emplace_back();
  rival.effect.name = "link bending";
  rival.effect.parameter = "A2.alpha";
  rival.from_catalogue = true;
  return traced;
}

// Of a result at the floor.
Grounds at_the_floor(const std::vector<TracedEffect>& effects) {
  return {.effects = effects,
          .lack_of_fit = 0.4,
          .after = 0.9e-3,
          .floor = 1e-3,
          .floor_high = 1.1e-3,
          .complete_high = 1.2e-3};
}

TEST(Verdict, AtTheFloorNothingIsLeft) {
  EXPECT_EQ(conclude(at_the_floor(kNone)), Verdict::nothing_to_explain);
  EXPECT_EQ(conclude(at_the_floor(kOne)), Verdict::closed);
}

// The arm moves, and nothing shows which of its parts.
TEST(Verdict, AFamilyOfWhichNoMemberIsShownIsNotSeparable) {
  std::vector<TracedEffect> effects{kOne};
  effects.front().shared_with.emplace_back();
  EXPECT_EQ(conclude(at_the_floor(effects)), Verdict::not_separable);
}

// The arm, or what reads it: programs are not corrected by such an effect.
TEST(Verdict, AnEffectThatMayBeTheInstrumentClosesNothing) {
  std::vector<TracedEffect> effects{kOne};
  effects.front().effect.may_be_instrument = true;
  EXPECT_EQ(conclude(at_the_floor(effects)), Verdict::not_separable);
}

// Programs run on another day than the campaign.
TEST(Verdict, ACurveOfTimeWithoutACauseIsNoExplanation) {
  std::vector<TracedEffect> effects{kOne};
  Effect& curve = effects.front().effect;
  curve.parameter = "A2.theta";
  curve.driver.kind = DriverKind::time;
  curve.shape = series_shape(SeriesBasis::cosine, 4, 0, 3600);
  EXPECT_EQ(conclude(at_the_floor(effects)), Verdict::unexplained);
  effects.front().in_words = "a joint's zero drifts";
  EXPECT_EQ(conclude(at_the_floor(effects)), Verdict::closed);
}

// Below the floor, too: poses left out gain nothing by the pattern, and it is no chance.
TEST(Verdict, APatternThatRemainsIsNoNoise) {
  for (const auto& effects : {kNone, kOne}) {
    Grounds grounds = at_the_floor(effects);
    grounds.pattern_remains = true;
    EXPECT_EQ(conclude(grounds), Verdict::unexplained);
  }
}

TEST(Verdict, ACurveThatHeldOutPosesDoNotConfirmClosesNothing) {
  Grounds grounds = at_the_floor(kOne);
  grounds.unconfirmed_curve = true;
  EXPECT_EQ(conclude(grounds), Verdict::unexplained);
}

TEST(Verdict, AnExplanationOfTheRestOverrulesAFloorHoweverLarge) {
  const std::vector<TracedEffect> rivals{with_a_rival()};
  for (const auto& effects : {kNone, kOne, rivals}) {
    Grounds grounds = at_the_floor(effects);
    grounds.is_explained = true;
    EXPECT_EQ(conclude(grounds), Verdict::unexplained);
  }
}

TEST(Verdict, WithoutAKnownNoiseNothingIsSaidOfTheRest) {
  for (const auto& effects : {kNone, kOne}) {
    Grounds grounds{.effects = effects, .knows_noise = false, .after = 0.9e-3};
    EXPECT_EQ(conclude(grounds), Verdict::unknown_noise);
    grounds.left_out_together = true;
    EXPECT_EQ(conclude(grounds), Verdict::unexplained);
  }
  EXPECT_EQ(to_string(Verdict::unknown_noise), "unknown-noise");
}

}  // namespace
}  // namespace armtrue::verdict_test
