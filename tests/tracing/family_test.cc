// Families of the catalogue: small sags that hide in zero offsets one by one are found together.

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "armtrue/campaign/simulation.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/tracing/description.h"
#include "armtrue/tracing/loop.h"

namespace armtrue::family_test {
namespace {

const std::string kNominal = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";
const std::string kTruth = ARMTRUE_CONFIG "/robots/kr360-table4.yaml";
const std::string kCatalogue = ARMTRUE_CONFIG "/effects/catalogue.yaml";

Effect sag(int joint, double compliance) {
  Effect effect{"joint compliance",
                "A" + std::to_string(joint) + ".theta",
                {DriverKind::gravity_torque, joint - 1, -1, ""},
                {},
                {}};
  effect.coefficients = {{"c", compliance}};
  return effect;
}

// 30 poses, two visits each, in a box of 0.6 m, and 60 poses over the whole travel.
LoopResult carried(const Robot& truth, unsigned seed) {
  const Robot nominal = read_robot(kNominal).robot;
  SimulationOptions options;
  options.noise_position = 0.095e-3;
  options.noise_orientation = 0.15e-3;
  options.poses = 60;
  options.seed = 100 + seed;
  const Campaign everywhere = simulate(nominal, truth, options);
  options.poses = 30;
  options.repeats = 2;
  options.seed = seed;
  options.box = Box{{1.6, -0.3, 0.9}, {2.2, 0.3, 1.5}};
  return close_loop(nominal, simulate(nominal, truth, options), everywhere,
                    read_catalogue(kCatalogue));
}

// Without masses the compliance of an axis takes sine and cosine of its angle too: it is not held
// beside an eccentricity that was found, which would have no direction of its own left.
TEST(Families, NoMemberTakesTheDirectionsOfWhatWasFound) {
  const Robot nominal = read_robot(ARMTRUE_CONFIG "/robots/irb120.yaml").robot;
  Robot truth = nominal;
  const std::string parameter = nominal.chain.links[1].name + ".theta";
  Effect& eccentricity = truth.effects.emplace_back();
  eccentricity = {"eccentricity",
                  parameter,
                  {DriverKind::joint_angle, 1, -1, ""},
                  harmonic_shape(1),
                  {{"sin", 5e-4}, {"cos", -4e-4}}};
  SimulationOptions options{
      .poses = 25, .repeats = 2, .noise_position = 1e-4, .noise_orientation = 1.5e-4};
  for (options.seed = 1; options.seed <= 6; ++options.seed) {
    const TraceResult found =
        trace(nominal, simulate(nominal, truth, options), read_catalogue(kCatalogue), {});
    ASSERT_FALSE(found.effects.empty()) << options.seed;
    for (const TracedEffect& traced : found.effects)
      EXPECT_GT(traced.evidence.delta_ebic, 0) << options.seed << ": " << describe(traced.effect);
  }
}

TEST(Families, ArmThatBendsIsFoundInABoxAndCarriedOut) {
  Robot truth = read_robot(kTruth).robot;
  truth.effects = {sag(2, 6e-8), sag(3, 1.4e-7), sag(5, 8e-7)};
  double before = 0, after = 0;
  int found = 0;
  constexpr int kCampaigns = 6;
  for (unsigned seed = 1; seed <= kCampaigns; ++seed) {
    const LoopResult result = carried(truth, seed);
    before += result.before / kCampaigns;
    after += result.after / kCampaigns;
    for (const TracedEffect& traced : result.trace.effects) {
      EXPECT_EQ(traced.effect.driver.kind, DriverKind::gravity_torque) << describe(traced.effect);
      EXPECT_TRUE(traced.effect.members.empty());
      EXPECT_GT(traced.effect.coefficients.front().value, 0);
    }
    found += static_cast<int>(result.trace.effects.size());
  }
  std::printf("arm that bends: %.3f -> %.3f mm, %d of %d sags named\n", 1e3 * before, 1e3 * after,
              found, 3 * kCampaigns);
  EXPECT_LT(after, 0.5 * before);
  EXPECT_GE(found, 2 * kCampaigns);
}

// What most arms have may stay by its prior, unless poses left out are clearly predicted worse with
// it; nothing is named, and nominal is never better. The error before is that of the geometry alone.
TEST(Families, RigidArmHasNone) {
  int held = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const LoopResult result = carried(read_robot(kTruth).robot, seed);
    EXPECT_TRUE(result.trace.effects.empty()) << describe(result.trace.effects.front().effect);
    // Outside the box these poses may be too few to say that nothing is left.
    EXPECT_TRUE(result.verdict == Verdict::nothing_to_explain ||
                result.verdict == Verdict::too_few_poses)
        << to_string(result.verdict);
    EXPECT_LT(result.after, 0.5 * result.stages.front().held_out.position.mean) << seed;
    EXPECT_TRUE(result.trace.stages.front().robot.effects.empty()) << seed;
    held += result.rejected || !result.trace.fit.robot.effects.empty();
  }
  EXPECT_GT(held, 0);
}

// A whole family moves the arm as its members do one by one.
TEST(Families, AreTheSumOfTheirMembers) {
  Robot robot = read_robot(kTruth).robot;
  Robot singles = robot;
  singles.effects = {sag(2, 6e-8), sag(3, 1.4e-7), sag(5, 8e-7)};
  Effect family = singles.effects.front();
  family.parameter = "compliance of the arm";
  family.coefficients.clear();
  for (const Effect& single : singles.effects) {
    family.members.push_back(single);
    family.coefficients.push_back(single.coefficients.front());
    family.members.back().coefficients.front().value = 0;
  }
  robot.effects = {family};
  const RobotModel whole(robot), apart(singles);
  const auto split = single_effects(family);
  ASSERT_EQ(split.size(), 3u);
  for (size_t k = 0; k < 3; ++k)
    EXPECT_EQ(split[k].coefficients.front().value, singles.effects[k].coefficients.front().value);
  for (double q : {-1.0, 0.3, 1.2}) {
    Context context;
    context.q = Eigen::Vector<double, 6>{q, -1 + 0.2 * q, 1 + 0.3 * q, q, 0.5 * q, -q};
    EXPECT_EQ(whole.pose(context).translation, apart.pose(context).translation);
  }
}

}  // namespace
}  // namespace armtrue::family_test
