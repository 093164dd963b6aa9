// The loop on campaigns of the oracle, which shares no code with armtrue: what was hidden must be
// named, added, and the error on poses that took no part must fall to the floor. The estimating
// side reads the CSV and the nominal robot, nothing else.

#include "armtrue/tracing/loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <tuple>

#include "armtrue/campaign/simulation.h"
#include "armtrue/campaign/split.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/search/training.h"
#include "armtrue/tracing/effect_curve.h"
#include "support/thinned.h"
#include "tracing/hidden_campaign.h"

namespace armtrue::loop_test {
namespace {

const std::string kNominal = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";
const std::string kCatalogue = ARMTRUE_CONFIG "/effects/catalogue.yaml";

std::string listed(const LoopResult& result) {
  std::string text;
  for (const TracedEffect& traced : result.trace.effects) {
    text += describe(traced.effect) + " [";
    for (const Rival& rival : traced.indistinguishable) text += describe(rival.effect) + "; ";
    text += "]\n";
  }
  return text;
}

LoopResult closed(const HiddenCampaign& campaign, const Robot& robot = read_robot(kNominal).robot,
                  const TraceOptions& options = {}) {
  const Catalogue catalogue = read_catalogue(kCatalogue);
  return close_loop(robot, campaign.training, campaign.held_out, catalogue, options);
}

// Which family of the oracle hides what an entry of the catalogue, or a driver that it names, is
// about.
const std::map<std::string, std::vector<std::string>> kFamiliesOfEntry{
    {"joint compliance", {"compliance", "two-payloads"}},
    {"eccentricity", {"harmonic"}},
    {"eccentricity, twice per turn", {"harmonic-2"}},
    {"gear or encoder scale", {"ratio"}},
    {"wrist coupling", {"coupling"}},
    {"axis wobble", {"wobble"}},
    {"link bending", {"bending"}},
    {"backlash", {"backlash"}},
    {"thermal growth", {"thermal", "cooling", "warm-links", "warm-up"}},
    {"zero drift", {"zero-drift"}},
    {"re-mastered joint", {"remaster"}},
    {"bent link", {"crash"}},
    {"bearing run-out", {"run-out"}},
    {"play of the foot", {"foot-play"}},
    {"droop of the tool", {"droop"}},
    {"play of the tool", {"tool-play"}},
    {"counterbalance follows temperature", {"warm-spring"}},
    {"tracker drift", {"drift", "settling"}},
    {"tracker knocked", {"knock"}},
    {"floor compliance", {"tilt"}},
    {"cutting force", {"cutting"}},
    {"re-seated target", {"reseated"}},
    {"instrument scale", {"scale"}},
    {"instrument scale drifts", {"scale-drift", "warm-scale"}},
    {"friction hysteresis", {"friction"}},
    {"play under gravity", {"play"}},
    {"stiffness that hardens with load", {"two-slopes"}},
    {"another load", {"other-load"}},
    {"radial offset", {"instrument-offset"}},
    {"instrument re-zeroed", {"instrument-rezeroed"}},
    {"refraction", {"instrument-refraction"}},
    {"index error", {"instrument-index"}},
    {"eccentric circle", {"instrument-circle"}},
    {"station turns", {"instrument-turns"}},
    {"incidence on the reflector", {"instrument-incidence"}},
    {"distorted space", {"instrument-distortion"}},
    {"wire re-zeroed", {"wire-rezeroed"}},
    {"wire drifts", {"wire-drift"}},
    {"wire scale", {"wire-scale"}},
    {"eccentric drum", {"wire-drum"}},
};

// Needs targets, of which the oracle has none; it has a test of its own below.
const std::string kEntryOfTargets = "target moved";

TEST(Catalogue, IsHiddenEntryByEntry) {
  std::set<std::string> entries,
      families{"null",      "null-conditions", "x-product",     "x-bump",
               "x-payload", "x-cycles",        "x-warm-course", "x-loaded-course"};
  for (const CatalogueEntry& entry : read_catalogue(kCatalogue)) entries.insert(entry.name);
  for (const auto& [entry, hidden_by] : kFamiliesOfEntry) {
    EXPECT_EQ(entries.erase(entry), 1u) << entry;
    families.insert(hidden_by.begin(), hidden_by.end());
  }
  EXPECT_EQ(entries.erase(kEntryOfTargets), 1u);
  EXPECT_TRUE(entries.empty()) << "no family hides " << *entries.begin();
  const std::vector<std::string> known = armtrue_oracle::families();
  EXPECT_EQ(families, std::set<std::string>(known.begin(), known.end()));
}

// All but those that no campaign of poses shows.
std::vector<std::string> families_to_find() {
  std::vector<std::string> families = armtrue_oracle::families();
  std::erase(families, "null");
  std::erase(families, "null-conditions");
  std::erase(families, "scale");
  std::erase_if(families, [](const std::string& family) { return family.starts_with("wire-"); });
  return families;
}

class Family : public testing::TestWithParam<std::string> {};

TEST_P(Family, IsNamedAddedAndGone) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 41;
  // Its coefficients are so many that 60 poses leave 8 % over the floor. What an index error leaves
  // is held by as many, though small ones.
  if (GetParam() == "instrument-distortion") plan.poses = 200;
  if (GetParam() == "instrument-index") plan.poses = 100;
  // Masses that are off say at other poses that the foot tips.
  plan.known_masses = GetParam() == "foot-play";
  const HiddenCampaign campaign(kNominal, GetParam(), 0.12, plan);
  Robot robot = read_robot(kNominal).robot;
  if (GetParam().starts_with("instrument-")) {
    const KDL::Vector& place = armtrue_oracle::kStation;
    robot.instrument = Eigen::Vector3d(place.x(), place.y(), place.z());
  }
  const LoopResult result = closed(campaign, robot);
  const auto& truth = campaign.written.truth;
  ASSERT_FALSE(result.trace.effects.empty());
  EXPECT_TRUE(names(truth, result.trace.effects.front()))
      << "hidden: " << truth.parameter << " by " << truth.driver << "\nfound: " << listed(result);
  const double floor = campaign.written.floor_mean_mm * kMillimetre;
  EXPECT_LT(result.after, 1.06 * floor);
  EXPECT_NE(result.verdict, Verdict::nothing_to_explain);
  // Beside a lasting error of the instrument its rest stays in the model, beside no other effect.
  const auto errs = [](const TracedEffect& traced) {
    return traced.effect.parameter.owner == Owner::instrument &&
           !traced.effect.driver.involves(DriverKind::time) &&
           !traced.effect.driver.involves(DriverKind::temperature);
  };
  EXPECT_EQ(std::ranges::any_of(result.trace.effects, errs),
            std::ranges::any_of(result.trace.fit.robot.effects,
                                [](const Effect& effect) { return is_polynomial(effect.shape); }));
  for (const TracedEffect& traced : result.trace.effects) {
    EXPECT_GT(traced.evidence.delta_ebic, 0);
    EXPECT_LT(traced.evidence.p_value, 0.02);
    for (const Rival& rival : traced.indistinguishable)  // it would have to double every length
      EXPECT_FALSE(rival.effect.parameter == "instrument.scale" &&
                   rival.effect.driver.kind == DriverKind::constant);
  }
}

INSTANTIATE_TEST_SUITE_P(Hidden, Family, testing::ValuesIn(families_to_find()),
                         [](const auto& instance) {
                           std::string name = instance.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

// The shipped files of most arms state no masses.
Robot without_masses() {
  Robot robot = read_robot(kNominal).robot;
  robot.bodies.clear();
  return robot;
}

// The weight of the tool changes its side where that of the arm does, or nearly there.
TEST(WithoutMasses, PlayThatGravityTakesUpIsNamed) {
  int named = 0;
  const int campaigns = 6 / thinned(2);
  for (int seed = 41; seed < 41 + campaigns; ++seed) {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = seed;
    const HiddenCampaign campaign(kNominal, "play", 0.12, plan);
    const LoopResult result = closed(campaign, without_masses());
    ASSERT_FALSE(result.trace.effects.empty());
    const Effect& found = result.trace.effects.front().effect;
    EXPECT_EQ(to_string(found.parameter), campaign.written.truth.parameter);
    named += found.name == "play under gravity";
  }
  EXPECT_GE(named, campaigns / 2);
}

TEST(WithoutMasses, AnAxisThatGivesWayUnderAWrittenPayloadIsNamed) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 41;
  const HiddenCampaign campaign(kNominal, "two-payloads", 0.12, plan);
  const LoopResult result = closed(campaign, without_masses());
  const bool by_payload =
      std::ranges::any_of(result.trace.effects, [&](const TracedEffect& traced) {
        return traced.effect.name == "joint compliance" &&
               traced.effect.driver.factor == DriverKind::payload &&
               to_string(traced.effect.parameter) == campaign.written.truth.parameter;
      });
  EXPECT_TRUE(by_payload) << listed(result);
  EXPECT_LT(result.after, 1.06 * campaign.written.floor_mean_mm * kMillimetre);
}

// One visit of 30 poses. Of the six components of the base a knock moves some much and others
// little; were each charged as one of its own, they would cost more than they explain.
TEST(Groups, AKnockShowsInFewPoses) {
  for (unsigned seed = 60; seed < 65; ++seed) {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = seed;
    plan.poses = 30;
    plan.repeats = 1;
    const HiddenCampaign campaign(kNominal, "knock", 0.12, plan);
    const LoopResult result = closed(campaign);
    ASSERT_EQ(result.trace.effects.size(), 1u) << "seed " << seed << "\n" << listed(result);
    EXPECT_TRUE(names(campaign.written.truth, result.trace.effects.front())) << listed(result);
  }
}

HiddenCampaign sum_of_sines(const std::string& family, unsigned seed) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = seed;
  plan.poses = 400;
  plan.repeats = 1;
  return HiddenCampaign(kNominal, family, 0.5, plan);
}

// A gear train's own number of cycles per turn is seldom whole.
TEST(Cycles, FrequencyAndAmplitudeLieInTheirIntervals) {
  for (unsigned seed : {42u, 43u}) {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = seed;
    const HiddenCampaign campaign(kNominal, "x-cycles", 0.12, plan);
    const LoopResult result = closed(campaign);
    ASSERT_EQ(result.trace.effects.size(), 1u) << listed(result);
    const TracedEffect& found = result.trace.effects.front();
    EXPECT_TRUE(names(campaign.written.truth, found.effect)) << listed(result);
    ASSERT_TRUE(found.cycle);
    const Cycle& cycle = *found.cycle;
    EXPECT_NEAR(found.effect.shape.harmonic, campaign.written.truth.cycles_per_turn,
                3 * cycle.frequency_std);
    EXPECT_LT(cycle.frequency_std, 0.1);  // a tenth of what one turn resolves
    EXPECT_NEAR(cycle.amplitude, campaign.written.amplitude, 3 * cycle.amplitude_std);
    EXPECT_LT(cycle.amplitude_std, 0.1 * cycle.amplitude);
  }
}

// A log of the shift tells what happened then, if the time is known well enough.
TEST(Steps, LieBetweenTheReadingsThatAreSaid) {
  const int part = thinned(2);
  int found = 0, covered = 0;
  double width = 0;
  for (const std::string family : {"remaster", "knock"})
    for (int seed = 1; seed <= 20 / part; ++seed) {
      armtrue_oracle::CampaignPlan plan;
      plan.seed = seed;
      plan.poses = 30;
      plan.repeats = 1;
      const HiddenCampaign campaign(kNominal, family, 0.12, plan);
      const TraceResult result =
          trace(read_robot(kNominal).robot, campaign.training, read_catalogue(kCatalogue));
      for (const TracedEffect& traced : result.effects) {
        if (!traced.step_ci95 || !names(campaign.written.truth, traced.effect)) continue;
        const auto [low, high] = *traced.step_ci95;
        const double at = campaign.written.truth.step_at_s;
        ++found;
        covered += low < at && at <= high;
        const auto& times = campaign.training.time_s;
        width += (high - low) / (times.back() - times.front());
      }
    }
  std::cout << covered << " of " << found << ", mean width " << width / found << "\n";
  ASSERT_GE(found, part == 1 ? 30 : 13);
  EXPECT_GE(covered, found - (part == 1 ? 4 : 3));  // of 40 more are missed in 5 %, of 20 in 2 %
  EXPECT_LT(width / found, 0.2);
}

// Two sines are named one by one, where they are what there is. Where their joint travels little, a
// curve that entered first may hold parts of both.
TEST(Curves, AreNoPlaceForTwoCycles) {
  int two_cycles = 0;
  const int campaigns = 6 / thinned(2);  // of six, curves in half of all campaigns fail in 89 %
  for (int seed = 1; seed <= campaigns; ++seed) {
    const HiddenCampaign campaign = sum_of_sines("x-sum-of-2", seed);
    const LoopResult result = closed(campaign);
    bool all_cycles = result.trace.effects.size() == 2;
    for (const TracedEffect& traced : result.trace.effects) {
      EXPECT_TRUE(names(campaign.written.truth, traced.effect)) << listed(result);
      all_cycles &= traced.effect.shape.kind == ShapeKind::harmonic;
    }
    two_cycles += all_cycles;
    EXPECT_LT(result.after, 1.06 * campaign.written.floor_mean_mm * kMillimetre);
  }
  EXPECT_GE(two_cycles, campaigns - 1);
}

// Found as a dozen single cycles some would be missed. Where their joint travels little, a few
// pieces may do as well as one fine curve.
TEST(Curves, StandForWhatIsNoSumOfFewCycles) {
  int fine_curves = 0;
  const int campaigns = thinned(2) == 1 ? 3 : 2;
  for (int seed = 1; seed <= campaigns; ++seed) {
    const HiddenCampaign campaign = sum_of_sines("x-sum-of-12", seed);
    const LoopResult result = closed(campaign);
    EXPECT_LE(result.trace.effects.size(), 6u) << listed(result);  // half as many
    for (const TracedEffect& traced : result.trace.effects)
      EXPECT_TRUE(names(campaign.written.truth, traced.effect)) << listed(result);
    fine_curves += std::any_of(
        result.trace.effects.begin(), result.trace.effects.end(),
        [](const TracedEffect& traced) { return traced.effect.coefficients.size() > 12; });
    EXPECT_LT(result.after, 1.15 * campaign.written.floor_mean_mm * kMillimetre);
  }
  EXPECT_GE(fine_curves, campaigns - 1);
}

// Two thousand poses are searched, all are fitted.
TEST(ManyPoses, AreSearchedInPartAndFittedWhole) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 5;
  plan.poses = 2300;
  plan.repeats = 1;
  const HiddenCampaign campaign(kNominal, "x-cycles", 0.05, plan);
  ASSERT_GT(campaign.training.rows(), 2000);
  const LoopResult result = closed(campaign);
  ASSERT_EQ(result.trace.effects.size(), 1u) << listed(result);
  const TracedEffect& found = result.trace.effects.front();
  EXPECT_TRUE(names(campaign.written.truth, found.effect)) << listed(result);
  EXPECT_EQ(result.trace.fit.weights.size(), static_cast<size_t>(campaign.training.rows()));
  EXPECT_EQ(result.trace.stages.front().weights.size(), result.trace.fit.weights.size());
  ASSERT_TRUE(found.cycle);
  EXPECT_NEAR(found.cycle->amplitude, campaign.written.amplitude, 3 * found.cycle->amplitude_std);
  EXPECT_LT(result.after, 1.01 * campaign.written.floor_mean_mm * kMillimetre);

  std::vector<int> backwards(campaign.training.rows());
  std::iota(backwards.rbegin(), backwards.rend(), 0);
  const TraceResult other = trace(read_robot(kNominal).robot, campaign.training.select(backwards),
                                  read_catalogue(kCatalogue));
  ASSERT_EQ(other.effects.size(), 1u);
  EXPECT_EQ(other.effects.front().effect.shape, found.effect.shape);
  EXPECT_NEAR(other.effects.front().evidence.delta_ebic, found.evidence.delta_ebic, 0.01);
}

TEST(StrongestCycle, IsFoundBesideALineAndWeakerOnes) {
  std::vector<CurvePoint> curve;
  for (int i = 0; i <= 300; ++i) {
    const double q = -1.5 + 0.01 * i;
    curve.push_back({q, 2e-4 * q + 3e-4 * std::sin(17.3 * q + 0.4) + 1e-4 * std::sin(31 * q), 0});
  }
  const auto cycle = strongest_cycle(curve);
  ASSERT_TRUE(cycle);
  EXPECT_NEAR(cycle->per_turn, 17.3, 0.15);
  EXPECT_NEAR(cycle->amplitude, 3e-4, 1e-5);
  const double line = 4 * 3.0 * 3.0 / 12;  // variances, in units of 1e-8
  EXPECT_NEAR(cycle->share, 4.5 / (line + 4.5 + 0.5), 0.03);
  EXPECT_FALSE(strongest_cycle({}));
  for (CurvePoint& point : curve) point.value = 2e-4 * point.driver;
  EXPECT_FALSE(strongest_cycle(curve));
}

// Thirty angles leave other frequencies in reach, and that is said.
TEST(Cycles, FrequenciesThatFewPosesCannotTellAreOneClass) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 7;
  plan.poses = 30;
  plan.repeats = 1;
  const HiddenCampaign campaign(kNominal, "x-cycles", 0.12, plan);
  TraceOptions options;  // what is surely there seldom has such a rival
  options.significance = options.significance_without_lack_of_fit = 0.5;
  const LoopResult result = closed(campaign, read_robot(kNominal).robot, options);
  ASSERT_EQ(result.trace.effects.size(), 1u) << listed(result);
  const TracedEffect& found = result.trace.effects.front();
  EXPECT_TRUE(names(campaign.written.truth, found)) << listed(result);
  const bool other_frequency = std::any_of(
      found.indistinguishable.begin(), found.indistinguishable.end(), [&](const Rival& rival) {
        return names(campaign.written.truth, rival.effect) &&
               std::abs(rival.effect.shape.harmonic - found.effect.shape.harmonic) > 1;
      });
  EXPECT_TRUE(other_frequency) << listed(result);
}

// The axes of A5's and A6's beta are those of the joints themselves: no pose tells the two apart.
TEST(Classes, OneAxisUnderTwoNamesIsOneClass) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 41;
  const HiddenCampaign campaign(kNominal, "coupling", 0.12, plan);
  const LoopResult result = closed(campaign);
  const armtrue_oracle::Hidden& truth = campaign.written.truth;
  ASSERT_EQ(result.trace.effects.size(), 1u);
  const TracedEffect& found = result.trace.effects.front();
  EXPECT_TRUE(names(truth, found.effect)) << listed(result);
  const std::string same_axis = truth.parameter.substr(0, 2) + ".beta";
  const auto twin = std::find_if(found.indistinguishable.begin(), found.indistinguishable.end(),
                                 [&](const Rival& rival) {
                                   return rival.effect.parameter == same_axis &&
                                          to_string(rival.effect.driver) == truth.driver;
                                 });
  ASSERT_NE(twin, found.indistinguishable.end()) << listed(result);
  EXPECT_GT(twin->correlation, 0.9999);
}

// A course that is much like the true one, but not like enough for these readings.
TEST(Classes, ARivalThatTheReadingsSpeakAgainstIsRuledOut) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 46;
  const HiddenCampaign campaign(kNominal, "x-loaded-course", 0.12, plan);
  const LoopResult result = closed(campaign);
  ASSERT_EQ(result.trace.effects.size(), 1u) << listed(result);
  const TracedEffect& found = result.trace.effects.front();
  EXPECT_TRUE(names(campaign.written.truth, found.effect)) << listed(result);
  EXPECT_TRUE(found.indistinguishable.empty()) << listed(result);
  ASSERT_FALSE(found.ruled_out.empty());
  EXPECT_GT(found.ruled_out.front().correlation, 0.95);
  EXPECT_GT(found.ruled_out.front().delta_ebic, 2 * std::log(1000.0));
}

TEST(Nothing, IsSaidWhenNothingIsHidden) {
  for (unsigned seed : {51u, 52u, 53u}) {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = seed;
    plan.blunders = seed == 53u ? 0.04 : 0;
    // With loads, forces and temperatures there are more candidates.
    const std::string family = seed == 52u ? "null-conditions" : "null";
    const LoopResult result = closed(HiddenCampaign(kNominal, family, 0, plan));
    EXPECT_TRUE(result.trace.effects.empty()) << "seed " << seed << "\n" << listed(result);
    EXPECT_EQ(result.verdict, Verdict::nothing_to_explain) << "seed " << seed;
    EXPECT_EQ(result.excluded_rows.empty(), seed != 53u);
  }
}

// The other visit of its pose says that a held-out reading is wrong. A pose that is wrong as a
// whole may be one that the model lacks something at.
TEST(Nothing, IsMissingWhereAHeldOutReadingIsContradicted) {
  for (unsigned seed : {55u, 56u}) {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = seed;
    HiddenCampaign campaign(kNominal, "null", 0, plan);
    Campaign& held_out = campaign.held_out;
    held_out.position[4].z() += 8e-3;
    const LoopResult one = closed(campaign);
    EXPECT_EQ(one.verdict, Verdict::nothing_to_explain) << seed;
    EXPECT_EQ(one.contradicted_rows, std::vector{held_out.line[4]});
    EXPECT_LT(one.after_sound, one.after - 1e-5);
    for (int row = 0; row < held_out.rows(); ++row)
      if (row != 4 && held_out.pose[row] == held_out.pose[4]) held_out.position[row].z() += 8e-3;
    const LoopResult whole = closed(campaign);
    EXPECT_NE(whole.verdict, Verdict::nothing_to_explain) << seed;
    EXPECT_TRUE(whole.contradicted_rows.empty());
  }
}

// Twelve poses give 72 equations, of which the geometry takes 30: what chance leaves in the other
// 42 may not look like evidence.
TEST(Nothing, IsEvidenceByChanceWhereTheGeometryTakesNearlyHalf) {
  double mean_score = 0;
  constexpr int kCampaigns = 8;
  for (unsigned seed = 54; seed < 54 + kCampaigns; ++seed) {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = seed;
    plan.poses = 12;
    plan.repeats = 1;
    const LoopResult result = closed(HiddenCampaign(kNominal, "null", 0, plan));
    EXPECT_TRUE(result.trace.effects.empty()) << "seed " << seed << "\n" << listed(result);
    mean_score += result.trace.best_score / kCampaigns;
  }
  EXPECT_LT(mean_score, 0);
}

// Joints that come to rest somewhat off, in every pose by another amount, leave far more than the
// readings' noise: much is lacking, and nothing of it follows anything. Chance levels below 0.05
// are no more than one in twenty; draws of the bare residual would put nine in ten below one half.
TEST(Nothing, IsInPosesThatErrAsAWhole) {
  int below_half = 0, below_twentieth = 0;
  const int part = thinned(2), campaigns = 40 / part;
  for (int seed = 300; seed < 300 + campaigns; ++seed) {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = seed;
    plan.rest_mrad = 0.05;
    TraceOptions options;
    options.max_effects = 0;
    const HiddenCampaign campaign(kNominal, "null", 0, plan);
    const Training training = search_training(read_robot(kNominal).robot, campaign.training,
                                              Then::report, read_catalogue(kCatalogue), options);
    below_half += training.trace.remaining_p < 0.5;
    below_twentieth += training.trace.remaining_p < 0.05;
  }
  EXPECT_LT(below_half, part == 1 ? 30 : 17);  // nine in ten are as many in 99.9 %, of 20 in 87 %
  // Of 40, 2 are expected, and more than 5 in 1.4 % of such runs; of 20, more than 3 in 1.6 %.
  EXPECT_LE(below_twentieth, part == 1 ? 5 : 3);
}

// Programs are corrected for what the arm does. A station that drifts makes the arm alone err more than the readings
// are left with; sag is the arm's, and the arm alone is the result.
TEST(ArmAlone, ErrsByWhatTheStationDoes) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 41;
  const LoopResult drift = closed(HiddenCampaign(kNominal, "drift", 0.3, plan));
  const LoopResult sag = closed(HiddenCampaign(kNominal, "compliance", 0.3, plan));
  ASSERT_FALSE(drift.parts.empty());
  EXPECT_FALSE(drift.parts.front().of_arm);
  ASSERT_TRUE(drift.after_arm);
  EXPECT_GT(*drift.after_arm, 1.2 * drift.after);
  ASSERT_FALSE(sag.parts.empty());
  EXPECT_TRUE(sag.parts.front().of_arm);
  EXPECT_FALSE(sag.after_arm);
  // The effects take off what the geometry left more than the result.
  const auto square = [](const Stage& stage) { return std::pow(stage.training.position.rms, 2); };
  double taken = 0;
  for (size_t k = 0; k < sag.trace.effects.size(); ++k) taken += std::pow(sag.parts[k].position, 2);
  const Stage& named = sag.stages[sag.stages.size() - (sag.applied ? 2 : 1)];
  EXPECT_NEAR(taken, square(sag.stages[1]) - square(named), 0.02 * square(sag.stages[1]));
}

// A station that wanders slowly while readings have no time: its wandering shows in the order of
// the visits, also at poses that were held out, and no program can follow it.
TEST(ReadingsOfARecord, AreFollowedInTheOrderOfVisits) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 43;
  plan.poses = 150;
  const Robot robot = read_robot(kNominal).robot;
  HiddenCampaign campaign(kNominal, "null", 0, plan);
  Campaign all = campaign.training;
  all.time_s.clear();
  for (int row = 0; row < all.rows(); ++row) {
    const double turn = 2 * std::numbers::pi * all.line[row] / all.line.back();
    all.position[row] +=
        0.3e-3 * Eigen::Vector3d(std::sin(turn), std::cos(turn), std::sin(2 * turn));
  }
  const Split split = split_by_pose(all, 0.3, 1);
  const auto left = [&](const Campaign& held_out) {
    return close_loop(robot, all.select(split.training), held_out, read_catalogue(kCatalogue), {});
  };
  const LoopResult same = left(all.select(split.held_out));
  ASSERT_TRUE(same.after_readings);
  EXPECT_LT(*same.after_readings, 0.5 * same.after);
  EXPECT_LT(*same.after_readings, 1.25 * same.floor);
  Campaign other = all.select(split.held_out);
  other.source = "another day.csv";
  EXPECT_FALSE(left(other).after_readings);
}

// Without times no cause that follows time can be named; that something follows the order of the
// lines is said all the same, and of what follows something else, or nothing, it is not.
TEST(ReadingsOfARecord, ThatFollowTheOrderOfTheirLinesAreNotExplained) {
  const std::map<std::string, std::string> expected{
      {"drift", "base"}, {"knock", "base"}, {"null", ""}, {"compliance", ""}};
  for (const auto& [family, parameter] : expected) {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = 44;
    HiddenCampaign campaign(kNominal, family, family == "null" ? 0 : 0.15, plan);
    campaign.training.time_s.clear();
    campaign.held_out.time_s.clear();
    const LoopResult result = closed(campaign);
    const bool is_said = result.pattern.find("follows the order of the lines") != std::string::npos;
    EXPECT_EQ(is_said, !parameter.empty()) << family << ": " << result.pattern;
    EXPECT_NE(result.pattern.find(parameter), std::string::npos)
        << family << ": " << result.pattern;
    if (is_said) EXPECT_EQ(result.verdict, Verdict::unexplained) << family;
  }
}

// Draw-wires from three anchors, whose places and zero errors the file only knows roughly.
armtrue_oracle::CampaignPlan three_wires(unsigned seed) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = seed;
  plan.anchors = {{{2.512, 1.493, 0.106}, 1.5e-3},
                  {{2.496, -1.508, 0.293}, -0.8e-3},
                  {{-0.491, 2.811, 1.497}, 0.4e-3}};
  return plan;
}

Robot with_three_anchors() {
  Robot robot = read_robot(kNominal).robot;
  robot.chain.anchors = {{"1", {2.5, 1.5, 0.1}}, {"2", {2.5, -1.5, 0.3}}, {"3", {-0.5, 2.8, 1.5}}};
  return robot;
}

TEST(Distances, ShowNothingWhereNothingIsHidden) {
  double ratio = 0;
  constexpr int kCampaigns = 8;
  for (unsigned seed = 71; seed < 71 + kCampaigns; ++seed) {
    armtrue_oracle::CampaignPlan plan = three_wires(seed);
    const bool with_blunders = seed % 4 == 0;
    plan.blunders = with_blunders ? 0.04 : 0;
    const HiddenCampaign campaign(kNominal, "null", 0, plan);
    const LoopResult result = closed(campaign, with_three_anchors());
    EXPECT_TRUE(result.trace.effects.empty()) << "seed " << seed << "\n" << listed(result);
    EXPECT_EQ(result.verdict, Verdict::nothing_to_explain) << "seed " << seed;
    EXPECT_EQ(result.excluded_rows.empty(), !with_blunders) << "seed " << seed;
    EXPECT_GT(result.stages.front().held_out.position.mean, 3 * result.after);  // nominal
    // 360 degrees of freedom show a deviation to 4 %; four of these.
    EXPECT_NEAR(result.noise.position, 1e-3 * plan.noise_mm, 0.16e-3 * plan.noise_mm);
    ratio += result.after / (campaign.written.floor_mean_mm * kMillimetre) / kCampaigns;
  }
  std::printf("distances, nothing hidden: after / floor %.4f\n", ratio);
  // 33 unknowns from 540 distances cost 3 %, and more where the held-out poses lie farther out.
  EXPECT_LT(ratio, 1.06);
}

// The masses of the file are off by 10 to 30 %; what the motors hold is the torque itself.
TEST(MotorTorque, ShowsTheComplianceOfAnArmWhoseMassesAreUnknown) {
  for (unsigned seed : {81u, 82u, 83u}) {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = seed;
    plan.motor_torque = true;
    const HiddenCampaign campaign(kNominal, "compliance", 0.12, plan);
    const auto& truth = campaign.written.truth;
    Robot robot = read_robot(kNominal).robot;
    robot.bodies.clear();
    const LoopResult result = closed(campaign, robot);
    ASSERT_FALSE(result.trace.effects.empty());
    const TracedEffect& found = result.trace.effects.front();
    EXPECT_EQ(found.effect.parameter, truth.parameter) << listed(result);
    EXPECT_EQ(found.effect.driver.kind, DriverKind::motor_torque) << listed(result);
    EXPECT_EQ(to_string(found.effect.driver).back(), truth.driver.back()) << listed(result);
    // The oracle's unit effect is a microradian for each newton metre of gravity.
    const Coefficient& c = found.effect.coefficients.front();
    EXPECT_NEAR(c.value, -1e-6 * campaign.written.amplitude, 4 * c.std);
    EXPECT_LT(result.after, 1.06 * campaign.written.floor_mean_mm * kMillimetre);
  }
}

class DistanceFamily : public testing::TestWithParam<std::string> {};

TEST_P(DistanceFamily, IsNamedAddedAndGone) {
  // Of a wire all that it errs, in one reading of three.
  const double size_mm = GetParam().starts_with("wire-") ? 0.3 : 0.12;
  const HiddenCampaign campaign(kNominal, GetParam(), size_mm, three_wires(74));
  const LoopResult result = closed(campaign, with_three_anchors());
  const auto& truth = campaign.written.truth;
  ASSERT_FALSE(result.trace.effects.empty());
  EXPECT_TRUE(names(truth, result.trace.effects.front()))
      << "hidden: " << truth.parameter << " by " << truth.driver << "\nfound: " << listed(result);
  EXPECT_LT(result.after, 1.06 * campaign.written.floor_mean_mm * kMillimetre);
  EXPECT_GT(result.before, 1.08 * campaign.written.floor_mean_mm * kMillimetre);
  if (GetParam().starts_with("wire-")) {  // no error of the arm alone
    ASSERT_TRUE(result.after_arm);
    EXPECT_LT(*result.after_arm, 1.02 * result.after_named);
  }
  std::printf("%s by distances: before %.4f, after %.4f, floor %.4f mm\n", GetParam().c_str(),
              result.before / kMillimetre, result.after / kMillimetre,
              campaign.written.floor_mean_mm);
}

INSTANTIATE_TEST_SUITE_P(Hidden, DistanceFamily,
                         testing::Values("compliance", "harmonic", "backlash", "thermal",
                                         "wire-rezeroed", "wire-drift", "wire-drum"));

// One of three targets slips in its nest at half time.
TEST(Targets, OneThatMovedIsNamedAndTheArmStaysAsItIs) {
  Robot robot = read_robot(kNominal).robot;
  for (const auto& [name, x, y, z] :
       {std::tuple{"a", 0.10, 0.0, 0.05}, std::tuple{"b", -0.12, 0.08, 0.0},
        std::tuple{"c", 0.0, -0.15, 0.1}})
    robot.chain.targets.push_back({name, {x, y, z}});
  Robot truth = robot;
  truth.chain.links[1].d += 4e-4;
  const Effect slip{"slip",
                    "target b",
                    {DriverKind::time, -1, -1, ""},
                    step_shape(1210),
                    {{"x", 3e-4}, {"y", -2e-4}, {"z", 1e-4}}};
  truth.effects.push_back(slip);
  SimulationOptions options;
  options.repeats = 2;
  options.noise_position = 95e-6;
  options.orientation = false;
  options.seed = 9;
  const Campaign campaign = simulate(robot, truth, options);
  const Split halves = split_by_pose(campaign, 0.4, 1);
  const LoopResult result =
      close_loop(robot, campaign.select(halves.training), campaign.select(halves.held_out),
                 read_catalogue(kCatalogue), {});
  ASSERT_EQ(result.trace.effects.size(), 1u) << listed(result);
  const Effect& found = result.trace.effects.front().effect;
  EXPECT_EQ(found.parameter, "target b") << listed(result);
  EXPECT_NEAR(found.shape.at, 1210, 60);
  for (size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(found.coefficients[k].value, slip.coefficients[k].value, 8e-5);
  EXPECT_EQ(result.verdict, Verdict::closed);
}

TEST(Scale, OfTheInstrumentIsSaidToBeBeyondAnyCampaign) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 41;
  const HiddenCampaign campaign(kNominal, "scale", 0.12, plan);
  const LoopResult result = closed(campaign);
  EXPECT_TRUE(result.trace.effects.empty()) << listed(result);
  const auto& not_separable = result.trace.not_separable;
  EXPECT_TRUE(std::any_of(not_separable.begin(), not_separable.end(),
                          [&](const RankedCandidate& candidate) {
                            return names(campaign.written.truth, candidate.effect);
                          }));
  EXPECT_LT(result.after, 1.06 * campaign.written.floor_mean_mm * kMillimetre);
}

TEST(Split, KeepsPosesWhole) {
  armtrue_oracle::CampaignPlan plan;
  const HiddenCampaign campaign(kNominal, "null", 0, plan);
  const Split split = split_by_pose(campaign.training, 0.25, 3);
  EXPECT_EQ(split.held_out.size(), 45u);
  EXPECT_EQ(split.training.size(), 135u);
  for (int a : split.held_out)
    for (int b : split.training) ASSERT_NE(campaign.training.pose[a], campaign.training.pose[b]);
}

// Sign flips simulate the null, so p is uniform there: count how often it is at most 0.2. This is
// the whole chain on a few campaigns; sign_flips_test.cc bounds the law of p by 1500 draws.
TEST(FamilyWiseP, IsCalibratedOnNull) {
  int low = 0;
  constexpr int kCampaigns = 40;
  for (unsigned seed = 100; seed < 100 + kCampaigns; ++seed) {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = seed;
    const HiddenCampaign campaign(kNominal, "null", 0, plan);
    TraceOptions options;
    options.beyond_catalogue = false;
    options.max_effects = 1;
    const TraceResult result =
        trace(read_robot(kNominal).robot, campaign.training, read_catalogue(kCatalogue), options);
    low += result.remaining_p <= 0.2;
  }
  // The seeds are fixed. Binomial(40, 0.2) lies outside 4 to 12 in one case of ten.
  EXPECT_GE(low, 4);
  EXPECT_LE(low, 12);
}

}  // namespace
}  // namespace armtrue::loop_test
