// Poses that tell two causes apart, on campaigns of the oracle, which shares no code with armtrue:
// what the plan promises must be what is counted, and more than random poses give.

#include "armtrue/planning/separation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/search/trace.h"
#include "kinematics/six_axes.h"
#include "support/oracle.h"

namespace armtrue::separation_test {
namespace {

const std::string kNominal = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";
constexpr double kPositionNoise = 0.095, kOrientationNoise = 0.15;  // mm, mrad
constexpr double kDistinct = 6;  // EBIC, as the tracer asks before it calls one of two shown

// Two causes of one class, as the library names them and as the oracle makes them.
struct Class {
  std::string name;
  TracedEffect found;
  std::function<armtrue_oracle::HiddenEffect(const std::vector<Coefficient>&)> make_found,
      make_rival;
  int next_poses;
};

Driver driver(const std::string& text) { return *parse_driver(text); }

TracedEffect found(const Effect& effect, const Effect& rival) {
  TracedEffect traced;
  traced.effect = effect;
  traced.indistinguishable.push_back({rival, 0, 0, {}, ""});
  return traced;
}

// What a bench in front of the arm allows: A2 and A3 hardly move, the wrist within half a turn.
std::vector<JointVector> over_a_bench() {
  constexpr double kLow[] = {-30, -100, 70, -60, 20, -90}, kHigh[] = {30, -60, 110, 60, 80, 90};
  armtrue_oracle::Dice dice(7);
  std::vector<JointVector> poses(30, JointVector(kJoints));
  for (JointVector& q : poses)
    for (int j = 0; j < kJoints; ++j) q[j] = dice.uniform(kLow[j], kHigh[j]) * kDegree;
  return poses;
}

using armtrue_oracle::Moment;
using armtrue_oracle::OracleArm;

auto compliance(size_t joint) {
  return [joint](const std::vector<Coefficient>& c) -> armtrue_oracle::HiddenEffect {
    return [=](const Moment& m, OracleArm& arm) {
      arm.links[joint].theta += c[0].value * m.torque[joint];
    };
  };
}

Class compliance_or_eccentricity() {
  return {"compliance or eccentricity of A2",
          found({"joint compliance", "A2.theta", driver("gravity-torque 2"), {}, {{"c", 2e-8}}},
                {"eccentricity", "A2.theta", driver("joint-angle 2"), harmonic_shape(1), {}}),
          compliance(1),
          [](const std::vector<Coefficient>& c) -> armtrue_oracle::HiddenEffect {
            return [=](const Moment& m, OracleArm& arm) {
              arm.links[1].theta += c[0].value * std::sin(m.q[1]) + c[1].value * std::cos(m.q[1]);
            };
          },
          8};
}

Class floor_or_compliance() {
  return {"floor or compliance of A2",
          found({"floor compliance", "base", driver("moment"), {}, {{"c", 2.5e-8}}},
                {"joint compliance", "A2.theta", driver("gravity-torque 2"), {}, {}}),
          [](const std::vector<Coefficient>& c) -> armtrue_oracle::HiddenEffect {
            return [=](const Moment& m, OracleArm& arm) {
              arm.base = KDL::Frame(KDL::Rot(arm.base.M * m.overturning * c[0].value) * arm.base.M,
                                    arm.base.p);
            };
          },
          compliance(1), 8};
}

Class coupling_or_wobble() {
  return {"coupling of A5 or wobble of its axis",
          found({"wrist coupling", "A5.theta", driver("joint-angle 4"), {}, {{"c", 2.2e-4}}},
                {"axis wobble", "A5.beta", driver("joint-angle 4"), harmonic_shape(1), {}}),
          [](const std::vector<Coefficient>& c) -> armtrue_oracle::HiddenEffect {
            return
                [=](const Moment& m, OracleArm& arm) { arm.links[4].theta += c[0].value * m.q[3]; };
          },
          [](const std::vector<Coefficient>& c) -> armtrue_oracle::HiddenEffect {
            return [=](const Moment& m, OracleArm& arm) {
              arm.links[4].beta += c[0].value * std::sin(m.q[3]) + c[1].value * std::cos(m.q[3]);
            };
          },
          5};
}

class Separation : public testing::TestWithParam<Class> {
 protected:
  Separation() : folder_(std::filesystem::temp_directory_path() / "armtrue-separation-XXXXXX") {
    if (!mkdtemp(folder_.data())) throw std::runtime_error("cannot create " + folder_);
  }
  ~Separation() override { std::filesystem::remove_all(folder_); }

  Campaign measured(const armtrue_oracle::HiddenEffect& effect,
                    const std::vector<JointVector>& commanded, unsigned seed) const {
    armtrue_oracle::CampaignPlan plan;
    plan.noise_mm = kPositionNoise;
    plan.noise_mrad = kOrientationNoise;
    plan.known_masses = true;
    plan.seed = seed;
    std::vector<std::array<double, 6>> poses(commanded.size());
    for (size_t i = 0; i < poses.size(); ++i)
      for (size_t j = 0; j < 6; ++j) poses[i][j] = commanded[i][static_cast<Eigen::Index>(j)];
    armtrue_oracle::write_visits(armtrue_oracle::read_arm(kNominal), effect, poses, plan,
                                 folder_ + "/m.csv");
    return read_campaign(folder_ + "/m.csv").campaign;
  }

  std::string folder_;
};

// Sum of squares, in standard deviations, that a model leaves.
double left(Robot robot, const std::vector<Effect>& effects, const Campaign& campaign) {
  for (Effect effect : effects) {
    const int count = BoundEffect(effect, robot).coefficient_count();
    effect.coefficients.assign(static_cast<size_t>(count), {});
    robot.effects.push_back(effect);
  }
  CalibrationOptions plain;
  plain.robust = false;
  const Evaluation evaluation = evaluate(calibrate(robot, campaign, plain).robot, campaign);
  double sum = 0;
  for (const auto& r : evaluation.residuals)
    sum += r.head<3>().squaredNorm() / std::pow(kPositionNoise * kMillimetre, 2) +
           r.tail<3>().squaredNorm() / std::pow(kOrientationNoise * kMilliradian, 2);
  return sum;
}

struct Count {
  int campaigns = 0, rejected = 0, right = 0;
  double promised = 0, variance = 0;  // of `rejected`

  double share(int of) const { return static_cast<double>(of) / campaigns; }
  double variance_of_right() const { return share(right) * (1 - share(right)) / campaigns; }
  void promise(double power) {
    promised += power;
    variance += power * (1 - power);
  }
};

// For every class and each of its members as the truth, 40 campaigns with the planned poses and 40
// with random ones, after the same first campaign.
TEST_P(Separation, PlannedPosesTellMoreAndAsMuchAsPromised) {
  constexpr int kCampaigns = 40;
  constexpr double kChiSquare95[] = {0, 3.841459, 5.991465};
  const Class& one = GetParam();
  const Robot robot = read_robot(kNominal).robot;
  const std::vector<JointVector> first = over_a_bench();
  const SeparationPlan plan =
      plan_separation(robot, {one.found}, one.next_poses, {}, measured({}, first, 1));
  ASSERT_EQ(plan.pairs.size(), 2u);
  ASSERT_EQ(plan.poses.size(), static_cast<size_t>(one.next_poses));
  const PoseCloud cloud = pose_cloud(robot, {});

  Count planned, random;
  unsigned seed = 100;
  for (const SeparatedPair& pair : plan.pairs) {
    EXPECT_TRUE(pair.by_poses);
    EXPECT_LT(pair.power_given, 0.1);
    const bool is_found = pair.truth.name == one.found.effect.name;
    const auto truth = (is_found ? one.make_found : one.make_rival)(pair.truth.coefficients);
    const size_t freedom = pair.truth.coefficients.size();
    const double more_coefficients =
        static_cast<double>(freedom) - static_cast<double>(pair.rival.coefficients.size());
    for (int k = 0; k < kCampaigns; ++k, ++seed)
      for (Count* count : {&planned, &random}) {
        const bool is_planned = count == &planned;
        std::vector<JointVector> all = first;
        for (const PlannedPose& pose :
             is_planned ? plan.poses : random_poses(cloud, one.next_poses, seed))
          all.push_back(pose.q);
        const Campaign campaign = measured(truth, all, seed);
        const double rival = left(robot, {pair.rival}, campaign);
        const double lead = rival - left(robot, {pair.truth}, campaign) -
                            more_coefficients * std::log(6.0 * campaign.rows());
        const double beside_rival = left(robot, {pair.rival, pair.truth}, campaign);
        ++count->campaigns;
        count->right += lead > kDistinct;
        count->rejected += rival - beside_rival > kChiSquare95[freedom];
        count->promise(is_planned ? pair.power_planned : pair.power_random);
      }
  }
  std::printf(
      "%s, %d poses: rival rejected: planned %.2f (promised %.2f), random %.2f (promised %.2f); "
      "right one distinctly ahead: planned %.2f, random %.2f\n",
      one.name.c_str(), one.next_poses, planned.share(planned.rejected),
      planned.promised / planned.campaigns, random.share(random.rejected),
      random.promised / random.campaigns, planned.share(planned.right), random.share(random.right));
  // Three standard deviations of the counts, and one campaign for their being whole numbers.
  for (const Count* count : {&planned, &random})
    EXPECT_NEAR(count->rejected, count->promised, 1 + 3 * std::sqrt(count->variance));
  EXPECT_GT(planned.share(planned.right) - random.share(random.right),
            2.5 * std::sqrt(planned.variance_of_right() + random.variance_of_right()));
}

// With enough of the planned poses the tracer leaves the right one alone in its class.
TEST_P(Separation, PlannedPosesCloseTheClass) {
  constexpr unsigned kCampaigns = 3;  // for each truth
  const Class& one = GetParam();
  const Robot robot = read_robot(kNominal).robot;
  const Catalogue catalogue = read_catalogue(ARMTRUE_CONFIG "/effects/catalogue.yaml");
  std::vector<JointVector> poses = over_a_bench();
  const SeparationPlan plan =
      plan_separation(robot, {one.found}, 3 * one.next_poses, {}, measured({}, poses, 1));
  for (const PlannedPose& pose : plan.poses) poses.push_back(pose.q);
  TraceOptions options;
  options.beyond_catalogue = false;
  unsigned closed = 0;
  for (const SeparatedPair& pair : plan.pairs) {
    const bool is_found = pair.truth.name == one.found.effect.name;
    const auto truth = (is_found ? one.make_found : one.make_rival)(pair.truth.coefficients);
    for (unsigned seed = 1; seed <= kCampaigns; ++seed) {
      const TraceResult result = trace(robot, measured(truth, poses, seed), catalogue, options);
      ASSERT_FALSE(result.effects.empty());
      const TracedEffect& traced = result.effects.front();
      const auto in_class = [&](const Effect& effect) {
        return same_place(traced.effect, effect) ||
               std::any_of(traced.indistinguishable.begin(), traced.indistinguishable.end(),
                           [&](const Rival& rival) { return same_place(rival.effect, effect); });
      };
      EXPECT_TRUE(in_class(pair.truth)) << one.name << ", seed " << seed;
      closed += in_class(pair.truth) && !in_class(pair.rival);
    }
  }
  EXPECT_GE(closed + 1, 2 * kCampaigns);
}

INSTANTIATE_TEST_SUITE_P(Classes, Separation,
                         testing::Values(compliance_or_eccentricity(), floor_or_compliance(),
                                         coupling_or_wobble()),
                         [](const auto& instance) {
                           return "class" + std::to_string(instance.index);
                         });

// The axis of A5's beta is that of the joint.
Rival the_same_twice() {
  return {{"axis wobble", "A5.beta", driver("joint-angle 4"), {}, {}}, 1, 0, {}, "a reading"};
}

Effect coupling() {
  return {"wrist coupling", "A5.theta", driver("joint-angle 4"), {}, {{"c", 2.2e-4}}};
}

TEST(SeparationPlan, SaysWhatNoPosesTell) {
  TracedEffect found;
  found.effect = coupling();
  found.indistinguishable.push_back(the_same_twice());
  const SeparationPlan plan = plan_separation(read_robot(kNominal).robot, {found}, 10, {});
  EXPECT_TRUE(plan.poses.empty());
  ASSERT_EQ(plan.pairs.size(), 2u);
  for (const SeparatedPair& pair : plan.pairs) {
    EXPECT_FALSE(pair.by_poses);
    EXPECT_NEAR(pair.power_planned, 0.05, 0.01);
    EXPECT_THAT(pair.readings, testing::ElementsAre("a reading"));
  }
}

// The pairs that poses can tell are planned for whatever the others are.
TEST(SeparationPlan, SeveralClassesAndMembers) {
  TracedEffect wrist = coupling_or_wobble().found, arm = compliance_or_eccentricity().found, alone;
  wrist.indistinguishable.push_back(the_same_twice());
  alone.effect = {"backlash", "A1.theta", driver("arrival 1"), sign_shape(), {{"c", 1e-4}}};
  const Robot robot = read_robot(kNominal).robot;
  const SeparationPlan plan =
      plan_separation(robot, {wrist, alone, arm}, 8, {}, simulate(over_a_bench(), robot, {}));
  EXPECT_EQ(plan.poses.size(), 8u);
  ASSERT_EQ(plan.pairs.size(), 3u * 2 + 2);
  int told = 0;
  for (const SeparatedPair& pair : plan.pairs) {
    told += pair.by_poses;
    if (pair.by_poses) EXPECT_GT(pair.power_planned, pair.power_random - 1e-9);
  }
  EXPECT_EQ(told, 6);
}

// An effect that the robot file already has is not fitted beside itself.
TEST(SeparationPlan, KnowsTheFoundEffectInTheRobot) {
  const Robot robot = read_robot(kNominal).robot;
  Robot closed = robot;
  const TracedEffect found = compliance_or_eccentricity().found;
  closed.effects.push_back(found.effect);
  const Campaign given = simulate(over_a_bench(), robot, {});
  const SeparationPlan a = plan_separation(robot, {found}, 6, {}, given);
  const SeparationPlan b = plan_separation(closed, {found}, 6, {}, given);
  EXPECT_EQ(a.poses, b.poses);
  EXPECT_EQ(a.pairs.front().power_planned, b.pairs.front().power_planned);
  CloudOptions other;
  other.seed = 2;
  EXPECT_NE(a.poses, plan_separation(robot, {found}, 6, other, given).poses);
}

// A zero point that drifts and a tracker that turns about the same axis are one for every pose; a
// joint that stands askew to it is not.
TEST(SeparationPlan, FollowsTimeOnAfterTheGivenPoses) {
  const Robot robot = read_robot(kNominal).robot;
  const Campaign given = simulate(over_a_bench(), robot, {});
  TracedEffect found;
  found.effect = {"zero drift", "A1.theta", driver("time"), {}, {{"c", 1e-6}}};
  for (const char* parameter : {"base.rz", "A4.theta"})
    found.indistinguishable.push_back(
        {{"rival", parameter, driver("time"), {}, {}}, 0, 0, {}, "fixed monuments"});
  const SeparationPlan plan = plan_separation(robot, {found}, 10, {}, given);
  for (const SeparatedPair& pair : plan.pairs)
    EXPECT_EQ(pair.by_poses,
              pair.truth.parameter == "A4.theta" || pair.rival.parameter == "A4.theta")
        << pair.truth.parameter << " " << pair.rival.parameter;
}

// What was given in another session counts, but not for as much as in one.
TEST(SeparationPlan, CountsAllSessions) {
  const Robot robot = read_robot(kNominal).robot;
  const Campaign one = simulate(over_a_bench(), robot, {});
  Campaign both = one;
  both.session_names = {"second", "first"};
  std::vector<int> last;
  for (int row = 0; row < both.rows(); ++row) {
    both.session.push_back(row < 12 ? 0 : 1);
    if (row >= 12) last.push_back(row);
  }
  const TracedEffect found = coupling_or_wobble().found;
  const auto power = [&](const Campaign& given) {
    return plan_separation(robot, {found}, 4, {}, given).pairs.front().power_given;
  };
  EXPECT_GT(power(both), power(both.select(last)));
  EXPECT_LT(power(both), power(one));
}

TEST(SeparationPlan, RefusesWhatThePosesDoNotHold) {
  TracedEffect found;
  found.effect = {"thermal growth", "A4.r", driver("temperature air"), {}, {{"c", 1e-5}}};
  found.indistinguishable.push_back(the_same_twice());
  EXPECT_THROW(plan_separation(read_robot(kNominal).robot, {found}, 10, {}), std::invalid_argument);
  found.effect = coupling();
  found.effect.coefficients.clear();
  EXPECT_THROW(plan_separation(read_robot(kNominal).robot, {found}, 10, {}), std::invalid_argument);
}

}  // namespace
}  // namespace armtrue::separation_test
