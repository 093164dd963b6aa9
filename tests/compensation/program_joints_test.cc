#include "armtrue/compensation/program_joints.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "armtrue/kinematics/units.h"

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

// The links of a palletiser or a SCARA: a name, whether it slides, whether it has a motor.
KinematicChain chain_of(const std::vector<std::string>& names) {
  KinematicChain chain;
  for (const std::string& name : names) {
    Link link;
    link.name = name;
    link.joint = name == "flange" ? JointKind::fixed
                 : name == "Z3"   ? JointKind::prismatic
                                  : JointKind::revolute;
    link.has_encoder = name != "tilt";
    chain.links.push_back(link);
  }
  return chain;
}

TEST(ProgramJoints, FewerAxesHaveTheNumbersOfTheirNames) {
  const auto palletiser = program_joints(chain_of({"A1", "A2", "A3", "tilt", "A6", "flange"}));
  ASSERT_TRUE(palletiser);
  EXPECT_EQ(palletiser->arm, (std::array<int, 6>{0, 1, 2, -1, -1, 3}));
  EXPECT_EQ(palletiser->count(), 4);
  EXPECT_FALSE(palletiser->is_six());
  EXPECT_EQ(palletiser->passive, 4);
  const JointVector program = (JointVector(6) << 0.1, 0.2, 0.3, 0, -0.5, 0.6).finished();
  const JointVector q = palletiser->whole(program, JointVector::Zero(4));
  EXPECT_EQ(q, (JointVector(4) << 0.1, 0.2, 0.3, 0.6).finished());
  EXPECT_EQ(palletiser->arm_of(q, program), program);
}

// 170 mm stand in the place of 170 deg.
TEST(ProgramJoints, AnAxisThatSlidesIsInMillimetres) {
  const auto scara = program_joints(chain_of({"J1", "J2", "Z3", "J4", "flange"}));
  ASSERT_TRUE(scara);
  const JointVector program = (JointVector(6) << 0.1, 0.2, 170 * kDegree, 0.4, 0, 0).finished();
  const JointVector q = scara->whole(program, JointVector::Zero(4));
  EXPECT_NEAR(q[2], 0.170, 1e-15);
  EXPECT_LT((scara->arm_of(q) - program).norm(), 1e-14);
}

TEST(ProgramJoints, NamesThatTellNoAxesAreNone) {
  EXPECT_FALSE(program_joints(chain_of({"shoulder", "elbow", "wrist", "flange"})));
  EXPECT_FALSE(program_joints(chain_of({"A1", "A3", "A2", "A6", "flange"})));
  EXPECT_FALSE(program_joints(chain_of({"A1", "A2", "A3", "A12", "flange"})));
  EXPECT_FALSE(program_joints(chain_of({"A1", "A2", "A3", "A4", "A5", "A6", "A7", "flange"})));
  EXPECT_TRUE(program_joints(chain_of({"a", "b", "c", "d", "e", "f", "flange"})));
}

}  // namespace
}  // namespace armtrue::program_joints_test
