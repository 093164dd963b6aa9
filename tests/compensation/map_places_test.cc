// Where a map of errors is taken: grids of boxes and paths as targets.

#include "armtrue/compensation/map_places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "armtrue/text/input_error.h"
#include "compensation/second_arm.h"
#include "kinematics/six_axes.h"

namespace armtrue::map_places_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const Eigen::Vector3d kLow(0, 0, 0), kHigh(1, 0.5, 0);

// What it says when it refuses.
template <typename Error, typename Work>
std::string refusal(const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Grid, StepsATwentiethOfTheLongestSide) {
  EXPECT_THAT(grid_of_box(kLow, kHigh, {}).count, ElementsAre(21, 11, 1));
  EXPECT_THAT(grid_of_box(kLow, kHigh, {.step = 0.3}).count, ElementsAre(5, 3, 1));
  EXPECT_THAT(grid_of_box(kLow, kHigh, {.step = 0.1}).count, ElementsAre(11, 6, 1));
  EXPECT_THAT(grid_of_box(kLow, kHigh, {.count = {{3, 4, 2}}}).count, ElementsAre(3, 4, 2));
}

TEST(Grid, IsRefusedWithoutWholeNumbersAndBeyondMemory) {
  for (const double count : {0.0, 2.5, -1.0})
    EXPECT_THAT(refusal<std::invalid_argument>([&] {
                  grid_of_box(kLow, kHigh, {.count = {{3, count, 2}}});
                }),
                HasSubstr("three whole numbers from 1 on"));
  EXPECT_THAT(refusal<std::invalid_argument>([] { grid_of_box(kLow, kHigh, {.step = 1e-4}); }),
              HasSubstr("larger --step-mm"));
}

Path line(bool with_joints, const Robot& arm) {
  Path path;
  path.time = Eigen::VectorXd::LinSpaced(3, 0, 2);
  path.position.resize(3, 3);
  if (with_joints) path.q.resize(6, 3);
  for (int k = 0; k < 3; ++k) {
    JointVector q = JointVector::Constant(6, 0.3 + 0.1 * k);
    path.position.col(k) = tcp_in_program(arm, {}, q).translation;
    if (with_joints) path.q.col(k) = q;
  }
  return path;
}

TEST(TargetsOfPath, HaveTheOrientationThatIsStatedElseThatOfTheJoints) {
  const Robot arm = read_robot(kNominalArm).robot;
  const Eigen::Matrix3d stated = rotation_from_abc(0.2, -0.1, 0.5);
  const std::vector<int> lines{2, 3, 4};
  const Path joints = line(true, arm), plain = line(false, arm);
  const Program by_joints = targets_of_path(joints, "p.csv", lines, arm, {}, std::nullopt);
  ASSERT_EQ(by_joints.poses.size(), 3u);
  EXPECT_TRUE(by_joints.hinted[1]);
  EXPECT_LT(
      (by_joints.poses[1].rotation - tcp_in_program(arm, {}, JointVector(joints.q.col(1))).rotation)
          .norm(),
      1e-12);
  EXPECT_EQ(targets_of_path(joints, "p.csv", lines, arm, {}, stated).poses[2].rotation, stated);
  CompensationOptions options;
  options.start = JointVector::Constant(6, 0.25);
  const Program by_start = targets_of_path(plain, "p.csv", lines, arm, options, std::nullopt);
  EXPECT_FALSE(by_start.hinted[0]);
  EXPECT_EQ(by_start.poses[2].rotation, tcp_in_program(arm, options, *options.start).rotation);
  EXPECT_EQ(by_start.poses[2].translation, plain.position.col(2));
}

TEST(TargetsOfPath, AreRefusedWithoutOrWithTwoOrientationsAndForJointsOfAnotherArm) {
  const Robot arm = read_robot(kNominalArm).robot;
  const std::vector<int> lines{2, 3, 4};
  Path path = line(false, arm);
  const auto why = [&](const std::optional<Eigen::Matrix3d>& stated) {
    return refusal<InputError>([&] { targets_of_path(path, "p.csv", lines, arm, {}, stated); });
  };
  EXPECT_THAT(why(std::nullopt), HasSubstr("p.csv: states neither an orientation"));
  path.orientation = Eigen::Matrix3Xd::Zero(3, 3);
  EXPECT_THAT(why(Eigen::Matrix3d::Identity()), HasSubstr("--orientation is given too"));
  path = line(true, arm);
  path.position(0, 1) += 0.02;
  EXPECT_THAT(why(std::nullopt), HasSubstr("p.csv:3: its joint angles put the tool 20 mm away"));
}

TEST(NotesOfMap, NameTheFirstFivePoints) {
  ErrorMap map;
  for (int k = 0; k < 8; ++k) {
    map.names.push_back("P" + std::to_string(k));
    MapPoint& point = map.points.emplace_back();
    if (k > 0) point.notes = {CommandNote::singular};
  }
  EXPECT_THAT(sentences_of_notes(map),
              ElementsAre("7 of 8 points: singular (P1, P2, P3, P4, P5, ...)"));
  map.grid = Grid{};
  EXPECT_THAT(sentences_of_notes(map), ElementsAre("7 of 8 points: singular"));
}

}  // namespace
}  // namespace armtrue::map_places_test
