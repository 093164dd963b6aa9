#include "armtrue/tracing/loop_doubts.h"

#include <gmock/gmock.h>

#include <utility>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"

namespace armtrue::loop_doubts_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A loop of which nothing speaks against: one stage, a known noise, an error of twice the noise.
struct Judged {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  Campaign campaign = simulate(robot, robot, {.noise_position = 5e-5});
  LoopResult loop;

  Judged() {
    loop.trace.fit = calibrate(robot, campaign);
    loop.noise.source = NoiseFloor::Source::instrument;
    loop.noise.position = 5e-5;
    loop.after = 1e-4;
    loop.stages.emplace_back().held_out.position.mean = 1e-3;
  }
  LoopDoubts doubts() const { return doubts_of_loop(robot, campaign, loop); }
};

TEST(LoopDoubts, AreNoneOfAGoodLoop) {
  const Judged judged;
  EXPECT_TRUE(judged.doubts().may_be_used);
  EXPECT_THAT(judged.doubts().sentences, IsEmpty());
}

TEST(LoopDoubts, WhatMustNotBeUsedSaysWhy) {
  Judged unfinished, far, worse;
  unfinished.loop.trace.fit.converged = false;
  far.loop.after = 1;
  worse.loop.worse_than_nominal = true;
  for (const auto& [judged, why] : {std::pair{&unfinished, "not converged"},
                                    std::pair{&far, "is more than an arm of this size"},
                                    std::pair{&worse, "worse than the nominal robot"}}) {
    EXPECT_FALSE(judged->doubts().may_be_used) << why;
    EXPECT_THAT(judged->doubts().sentences, ElementsAre(HasSubstr(why)));
  }
}

TEST(LoopDoubts, OthersLeaveTheResultUsable) {
  Judged judged;
  judged.loop.common_backlash = -2e-4;
  judged.loop.left_out_together = "blunders stand together";
  EXPECT_TRUE(judged.doubts().may_be_used);
  EXPECT_THAT(judged.doubts().sentences,
              ElementsAre(HasSubstr("one backlash, 0.011 deg"), "blunders stand together"));
}

}  // namespace
}  // namespace armtrue::loop_doubts_test
