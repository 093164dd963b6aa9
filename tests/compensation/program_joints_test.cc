#include "armtrue/compensation/program_joints.h"

#include <gtest/gtest.h>

namespace armtrue::program_joints_test {
namespace {

// An arm on a rail, whose program counts axis 3 from the ground: the chain's joint 3 and 0.5 of
// joint 2 together.
ProgramJoints on_a_rail() {
  ProgramJoints joints;
  joints.arm = {1, 2, 3, 4, 5, 6};
  joints.external[0] = {0, 1e-3};
  joints.third_by_second = 0.5;
  return joints;
}

const JointVector kChain = (JointVector(7) << 1.25, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6).finished();

TEST(ProgramJoints, AxisThreeContainsWhatItsCouplingAdds) {
  const JointVector arm = on_a_rail().arm_of(kChain);
  EXPECT_LT((arm - (JointVector(6) << 0.1, 0.2, 0.4, 0.4, 0.5, 0.6).finished()).norm(), 1e-15);
}

TEST(ProgramJoints, TheWholeHasTheAnglesOfTheArmAndTheRailOfTheOther) {
  const ProgramJoints joints = on_a_rail();
  JointVector other = JointVector::Zero(7);
  other[0] = kChain[0];
  EXPECT_LT((joints.whole(joints.arm_of(kChain), other) - kChain).norm(), 1e-15);
}

TEST(ProgramJoints, ExternalAxesAreInTheUnitOfTheProgram) {
  EXPECT_EQ(on_a_rail().external_numbers(kChain, {7, 8}), (std::vector<double>{1250, 8}));
}

}  // namespace
}  // namespace armtrue::program_joints_test
