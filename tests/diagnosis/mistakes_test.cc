#include "armtrue/diagnosis/mistakes.h"

#include <gmock/gmock.h>

#include <string>

#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"

namespace armtrue::mistakes_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Robot nominal() { return read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot; }

// The arm of table 4 of the seed paper at poses of its own.
Campaign measured(unsigned seed, int poses = 40) {
  const Robot truth = read_robot(ARMTRUE_CONFIG "/robots/kr360-table4.yaml").robot;
  return simulate(truth, truth, {.poses = poses, .noise_position = 5e-5, .seed = seed});
}

TEST(Mistakes, ARightCampaignHasNone) {
  const Findings found = find_mistakes(nominal(), measured(1));
  EXPECT_THAT(found.errors, IsEmpty());
}

TEST(Mistakes, AJointThatCountsTheOtherWayIsTheOnlyError) {
  Campaign campaign = measured(1);
  for (int row = 0; row < campaign.rows(); ++row) campaign.q[row][2] *= -1;
  EXPECT_THAT(find_mistakes(nominal(), campaign).errors,
              ElementsAre(HasSubstr("joint 3 seems to count the other way")));
}

TEST(SharedReading, IsACopyAndNoRepeat) {
  const Campaign training = measured(1), other = measured(2);
  EXPECT_FALSE(shared_reading(training, other));
  const auto shared = shared_reading(training, training.select({17, 3}));
  ASSERT_TRUE(shared);
  EXPECT_EQ(shared->training, 17);
  EXPECT_EQ(shared->test, 0);
  Campaign again = training.select({17});  // the same pose, read once more
  again.position[0].x() += 1e-5;
  EXPECT_FALSE(shared_reading(training, again));
}

TEST(SharedReading, IsNamedByItsLines) {
  Campaign training = measured(1);
  training.source = "a.csv";
  Campaign copy = training.select({17, 3});
  EXPECT_EQ(why_not_apart(training, measured(2)), "");
  const std::string lines = std::to_string(training.line[17]);
  EXPECT_EQ(why_not_apart(training, copy), "a.csv:" + lines + ": this reading stands in line " +
                                               lines +
                                               " too, as another pose; a copy shows nothing new: "
                                               "remove it, or give both the same pose");
  copy.source = "b.csv";
  EXPECT_THAT(why_not_apart(training, copy),
              HasSubstr("b.csv:" + lines + ": this reading stands in a.csv too"));
}

TEST(RepeatedPoses, StandAtTheSameAngles) {
  const Campaign training = measured(1), other = measured(2);
  EXPECT_EQ(repeated_poses(training, other).repeated, 0);
  Campaign near = training.select({4, 9});
  near.q[0][1] += 1e-3;  // 0.057 deg
  near.q[1][1] += 3e-3;  // 0.17 deg
  const RepeatedPoses poses = repeated_poses(training, near);
  EXPECT_EQ(poses.repeated, 1);
  EXPECT_EQ(poses.of, 2);
  EXPECT_EQ(poses.test, near.pose_ids[near.pose[0]]);
  EXPECT_EQ(poses.training, training.pose_ids[training.pose[4]]);
  EXPECT_THAT(repeats_in_words(training, near), HasSubstr("1 of 2 held-out poses"));
  EXPECT_EQ(repeats_in_words(training, other), "");
}

TEST(BeyondAnyArm, SaysHowMuchAnArmCanErr) {
  const Robot robot = nominal();
  EXPECT_EQ(beyond_any_arm(robot, 1e-3, 1e-5), "");
  EXPECT_THAT(beyond_any_arm(robot, 0.5, 1e-5), HasSubstr("500 mm, is more than an arm"));
}

}  // namespace
}  // namespace armtrue::mistakes_test
