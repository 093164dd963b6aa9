// What many small effects predict together though none of them can be named.

#include "tracing/predictor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/split.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/tracing/loop.h"
#include "tracing/hidden_campaign.h"

namespace armtrue::predictor_test {
namespace {

const std::string kNominal = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";
const std::string kCatalogue = ARMTRUE_CONFIG "/effects/catalogue.yaml";

// So many sines of one joint's angle in theta or alpha of any link.
armtrue_oracle::HiddenEffect many_sines(int count, double amplitude, unsigned seed) {
  struct Sine {
    int link, joint, cycles;
    bool is_twist;
    double phase;
  };
  armtrue_oracle::Dice dice(seed);
  std::vector<Sine> sines;
  for (int k = 0; k < count; ++k)
    sines.push_back({dice.below(6), dice.below(6), 1 + dice.below(3), dice.below(2) == 1,
                     dice.uniform(0, 6.28)});
  return [=](const armtrue_oracle::Moment& moment, armtrue_oracle::OracleArm& arm) {
    for (const Sine& sine : sines) {
      armtrue_oracle::OracleLink& link = arm.links[sine.link];
      (sine.is_twist ? link.alpha : link.theta) +=
          amplitude * std::sin(sine.cycles * moment.q[sine.joint] + sine.phase);
    }
  };
}

struct Judged {
  double named, predictor;  // mean held-out error [m]
  size_t added;
};

Judged judge(const Campaign& all, std::uint64_t seed) {
  const Split split = split_by_pose(all, 0.4, seed);
  const Campaign training = all.select(split.training), held_out = all.select(split.held_out);
  const Catalogue catalogue = read_catalogue(kCatalogue);
  LoopResult loop = close_loop(read_robot(kNominal).robot, training, held_out, catalogue);
  add_predictor(loop, training, held_out, catalogue, {});
  const Robot& robot = loop.predictor->robot;
  return {loop.after, loop.predictor->stage.held_out.position.mean,
          robot.effects.size() - loop.trace.fit.robot.effects.size()};
}

TEST(Remainder, ManySmallEffectsPredictTogether) {
  double gain = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const Judged judged = judge(visits(kNominal, many_sines(60, 5e-5, seed), 200, seed), seed);
    EXPECT_GE(judged.added, 20u);
    EXPECT_LT(judged.predictor, judged.named);
    gain += std::log(judged.named / judged.predictor) / 4;
  }
  EXPECT_GT(gain, 0.05);
}

// Chance may add some, at p of 0.005 to 0.16 by what the fit lacks; they cost next to nothing.
TEST(Remainder, HarmsNothingWhereNothingIsHidden) {
  int with_some = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Judged judged = judge(visits(kNominal, many_sines(0, 0, seed), 100, seed), seed);
    EXPECT_LT(judged.predictor, 1.02 * judged.named);
    with_some += judged.added > 0;
  }
  EXPECT_LE(with_some, 2);
}

}  // namespace
}  // namespace armtrue::predictor_test
