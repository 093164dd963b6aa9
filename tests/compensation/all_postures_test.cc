#include "compensation/all_postures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <string>
#include <vector>

#include "compensation/joint_correction.h"
#include "compensation/posture_search.h"
#include "compensation/second_arm.h"

namespace armtrue::all_postures_test {
namespace {

using armtrue_oracle::Uniform;

// All of them have axes 4 to 6 through one point.
const std::vector<std::string> kArms{"kr360-spindle", "kr10-r1100", "kr210-r2700", "irb120",
                                     "tx2-90"};

class Case {
 public:
  explicit Case(const Robot& robot) : arm_(robot, {}, {}, {}) { context_.q = JointVector::Zero(6); }

  Pose pose(const JointVector& q) {
    Context there = context_;
    there.q = q;
    return arm_.pose(there);
  }
  std::optional<std::vector<JointVector>> all(const Pose& wanted) {
    return all_postures(arm_, context_, wanted);
  }
  // By many starts, each of which ends anywhere: the postures that differ.
  std::vector<JointVector> by_starts(const Pose& wanted) {
    std::vector<JointVector> found;
    for (int k = 1; k <= 400; ++k) {
      JointVector start(6);
      for (int j = 0; j < 6; ++j) start[j] = (2 * share_of_start(k, j) - 1) * 180 * kDegree;
      const JointCorrection reached = joints_of_pose(arm_, context_, wanted, start);
      if (reached.is_reached && !holds(found, reached.q)) found.push_back(reached.q);
    }
    return found;
  }
  static bool holds(const std::vector<JointVector>& list, const JointVector& q) {
    for (const JointVector& other : list) {
      double apart = 0;
      for (int j = 0; j < 6; ++j)
        apart = std::max(apart, std::abs(std::remainder(q[j] - other[j], kTurn)));
      if (apart < 1e-6) return true;
    }
    return false;
  }
  double seconds_of_search(const Pose& wanted, const Configuration& stated,
                           const std::optional<JointVector>& before, bool is_found) {
    const std::clock_t start = std::clock();
    const PostureSearch search(arm_, context_, wanted, stated, before);
    EXPECT_EQ(search.find().has_value(), is_found);
    EXPECT_TRUE(search.is_reached());
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  }

 private:
  ProgramArm arm_;
  Context context_;
};

Robot starter(const std::string& name) {
  return read_robot(std::string(ARMTRUE_CONFIG) + "/robots/" + name + ".yaml").robot;
}

TEST(AllPostures, AreThoseThatManyStartsFind) {
  Uniform uniform(3);
  int compared = 0, eight = 0;
  for (const std::string& name : kArms) {
    const Robot robot = starter(name);
    Case of(robot);
    for (int k = 0; k < 6; ++k) {
      JointVector q(6);
      for (double& angle : q) angle = uniform(-100, 100) * kDegree;
      const Pose wanted = of.pose(q);
      const auto all = of.all(wanted);
      if (!all) continue;  // near the end of a side
      ++compared;
      eight += all->size() == 8;
      EXPECT_TRUE(Case::holds(*all, q)) << name;
      const std::vector<JointVector> others = of.by_starts(wanted);
      for (const JointVector& other : others) EXPECT_TRUE(Case::holds(*all, other)) << name;
      // Starts miss one or two of eight of a small arm.
      EXPECT_GE(others.size() + 2, all->size()) << name;
      EXPECT_LE(others.size(), all->size()) << name;
      for (const JointVector& one : *all)
        EXPECT_LT(difference(wanted, of.pose(one)).position, 1e-9) << name;
    }
  }
  EXPECT_GE(compared, 25);
  EXPECT_GE(eight, 5);
  EXPECT_LT(eight, compared);  // some of an arm whose back does not reach
}

TEST(AllPostures, OfAnIdentifiedArmHaveItsOwnPose) {
  Uniform uniform(4);
  int found = 0;
  for (int k = 0; k < 20; ++k) {
    Case of(random_arm(uniform));
    const JointVector q = random_target(starter(kArms[0]).chain, uniform);
    const Pose wanted = of.pose(q);
    const auto all = of.all(wanted);
    if (!all) continue;
    ++found;
    EXPECT_TRUE(Case::holds(*all, q));
    for (const JointVector& one : *all) {
      const PoseDifference apart = difference(wanted, of.pose(one));
      EXPECT_LT(apart.position, 1e-9);
      EXPECT_LT(apart.orientation, 1e-9);
    }
  }
  EXPECT_GE(found, 15);
}

// That the closed form has no posture says nothing of an arm that is not built so.
TEST(AllPostures, OfAnArmWithAnotherWristAreNotKnown) {
  Uniform uniform(6);
  Robot offset = starter(kArms[0]);
  offset.chain.links[5].d = 20 * kMillimetre;
  for (const Robot& robot : {starter("ur5e"), offset}) {
    Case of(robot);
    for (int k = 0; k < 300; ++k) {
      JointVector q(6);
      for (double& angle : q) angle = uniform(-100, 100) * kDegree;
      EXPECT_FALSE(of.all(of.pose(q))) << robot.name;
    }
  }
}

// Axis 6 may not stand where every posture of these targets has it. Hundreds of starts took hundreds
// of times as long as a target that is found.
TEST(AllPostures, TellSoonThatNoneIsInTheConfiguration) {
  Uniform uniform(5);
  const Robot robot = starter(kArms[0]);
  Case of(robot);
  double found = 0, none = 0;
  for (int k = 0; k < 60; ++k) {
    const JointVector q = random_target(robot.chain, uniform);
    const Pose wanted = of.pose(q);
    if (!of.all(wanted)) continue;
    Configuration stated;
    stated.reference << 0, -90, 90, 0, 45, 0;
    stated.reference *= kDegree;
    const JointVector before = q + JointVector::Constant(6, 0.2);
    found += of.seconds_of_search(wanted, stated, before, true);
    stated.low[5] = 20 * kTurn;
    stated.high[5] = 21 * kTurn;
    none += of.seconds_of_search(wanted, stated, before, false);
  }
  EXPECT_LT(none, 60 * found);
}

}  // namespace
}  // namespace armtrue::all_postures_test
