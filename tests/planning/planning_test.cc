#include "armtrue/planning/planning.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/identifiability.h"
#include "armtrue/io/robot_io.h"

namespace armtrue::planning_test {
namespace {

constexpr double kNoisePosition = 0.095e-3, kNoiseOrientation = 0.15e-3;
constexpr int kDesigns = 20;

Robot shipped(const std::string& name) {
  return read_robot(ARMTRUE_CONFIG "/robots/" + name + ".yaml").robot;
}

PlanOptions in_zone() {
  PlanOptions options;
  options.zone = Zone{{1.8, 0, 1}, 0.3};
  return options;
}

PlanOptions in_box() {
  PlanOptions options;
  options.box = Box{{1.4, -0.3, 1}, {2, 0.3, 1.6}};
  return options;
}

// Root of the mean, over random designs, of the square of what they promise.
double promised_by_random(const PosePlanner& planner, int poses, double PlanQuality::*deviation) {
  double squares = 0;
  for (int seed = 100; seed < 100 + kDesigns; ++seed) {
    const double value = planner.quality(planner.random(poses, seed)).*deviation;
    squares += value * value / kDesigns;
  }
  return std::sqrt(squares);
}

TEST(Planning, TellsMoreThanEveryRandomDesign) {
  for (bool orientation : {true, false}) {
    PlanOptions options;
    options.orientation = orientation;
    const PosePlanner planner(shipped("kr360-spindle"), options);
    const double planned = planner.quality(planner.plan(40)).log_determinant;
    for (int seed = 100; seed < 100 + kDesigns; ++seed)
      EXPECT_GT(planned, planner.quality(planner.random(40, seed)).log_determinant) << seed;
  }
}

// Over the whole travel random poses are good already: weights on the cloud, the bound of every
// design, promise 0.065 mm for 40 poses where the plan has 0.067 and 58 random ones have 0.060.
TEST(Planning, FortyPosesPromiseWhatFortySixRandomOnesDo) {
  const PosePlanner planner(shipped("kr360-spindle"), {});
  const double planned = planner.quality(planner.plan(40)).cloud_deviation;
  EXPECT_LT(planned, promised_by_random(planner, 46, &PlanQuality::cloud_deviation));
  EXPECT_LT(planned, 0.93 * promised_by_random(planner, 40, &PlanQuality::cloud_deviation));
}

TEST(Planning, FortyPosesForAZoneOrInABoxPromiseMoreThanFiftyEightRandomOnes) {
  const PosePlanner zone(shipped("kr360-spindle"), in_zone());
  EXPECT_LT(zone.quality(zone.plan(40)).zone_deviation,
            0.9 * promised_by_random(zone, 58, &PlanQuality::zone_deviation));
  const PosePlanner box(shipped("kr360-spindle"), in_box());
  EXPECT_LT(box.quality(box.plan(40)).cloud_deviation,
            promised_by_random(box, 58, &PlanQuality::cloud_deviation));
}

// True error [m], root mean square over `held_out` and over campaigns of these poses.
double true_error(const std::vector<std::vector<JointVector>>& campaigns,
                  const std::vector<JointVector>& held_out) {
  const Robot robot = shipped("kr360-spindle"), truth = shipped("kr360-table4");
  const Campaign exact = simulate(held_out, truth, {});
  double squares = 0;
  SimulationOptions options;
  options.noise_position = kNoisePosition;
  options.noise_orientation = kNoiseOrientation;
  for (const std::vector<JointVector>& poses : campaigns) {
    ++options.seed;
    const Robot found = calibrate(robot, simulate(poses, truth, options)).robot;
    const double rms = summarize(evaluate(found, exact).position).rms;
    squares += rms * rms / static_cast<double>(campaigns.size());
  }
  return std::sqrt(squares);
}

// 60 noisy campaigns each, calibrated; the error against the truth where the arm shall work.
TEST(Planning, CampaignsKeepWhatThePlanPromises) {
  constexpr int kCampaigns = 60;
  const PlanOptions options = in_zone();
  const Robot robot = shipped("kr360-spindle");
  const PosePlanner planner(robot, options);
  const ChainEvaluator evaluator(robot.chain);
  std::vector<JointVector> held_out = random_configurations(robot, 100000, std::nullopt, 77);
  std::erase_if(held_out, [&](const JointVector& q) {
    return (evaluator.pose(q).translation - options.zone->centre).norm() > options.zone->radius;
  });
  ASSERT_GT(held_out.size(), 50u);

  const std::vector<JointVector> plan = configurations(planner.plan(40));
  std::vector<std::vector<JointVector>> random;
  for (int seed = 100; seed < 100 + kCampaigns; ++seed)
    random.push_back(configurations(planner.random(58, seed)));
  const double planned_error = true_error({kCampaigns, plan}, held_out);
  const double random_error = true_error(random, held_out);
  const double promised = planner.quality(planned_poses(plan)).zone_deviation;
  std::printf("true error in the zone: 40 planned %.4f mm (promised %.4f), 58 random %.4f mm\n",
              1e3 * planned_error, 1e3 * promised, 1e3 * random_error);
  EXPECT_LE(planned_error, random_error);
  EXPECT_NEAR(planned_error, promised, 0.1 * promised);
}

TEST(Planning, QualityIsWhatCalibrationReports) {
  Robot robot = shipped("kr360-spindle");
  robot.noise = {1e-4, 1e-4};  // the ratio that calibrate() assumes without residuals
  const PosePlanner planner(robot, {});
  const std::vector<JointVector> poses = configurations(planner.random(30, 5));
  CalibrationOptions plain;
  plain.robust = false;  // every reading counts fully
  const CalibrationResult result = calibrate(robot, simulate(poses, robot, {}), plain);
  const PlanQuality quality = planner.quality(planned_poses(poses));
  for (size_t k = 0; k < quality.observability.size(); ++k)
    EXPECT_NEAR(quality.observability[k] / result.observability[k], 1, 1e-6) << "O" << k + 1;
}

TEST(Planning, CompletesGivenPoses) {
  const Robot robot = shipped("kr360-spindle");
  const std::vector<JointVector> first = configurations(PosePlanner(robot, {}).plan(20));
  const PosePlanner second(robot, {}, simulate(first, robot, {}));
  EXPECT_GT(second.quality(second.plan(20)).log_determinant,
            second.quality(planned_poses(first)).log_determinant);

  SimulationOptions small;  // poses that show little
  small.poses = 20;
  small.box = in_box().box;
  const PosePlanner completing(robot, {}, simulate(robot, robot, small));
  EXPECT_GT(completing.quality(completing.plan(8)).log_determinant,
            completing.quality(PosePlanner(robot, {}).plan(8)).log_determinant);
}

// All sessions count, with the base of each but the last fitted: the Schur complement of the sum.
TEST(Planning, GivenPosesOfSeveralSessionsHaveBasesOfTheirOwn) {
  Robot robot = shipped("kr360-spindle");
  robot.sessions["day 2"].base = {rotation_exp({0.3, -0.2, 1.1}), {0.8, -2.0, 0.4}};
  SimulationOptions options;
  options.poses = 40;
  Campaign given = simulate(robot, robot, options);
  given.session_names = {"day 1", "day 2"};
  for (int row = 0; row < given.rows(); ++row) given.session.push_back(row < 25 ? 0 : 1);
  const auto information = [&](int session) {
    std::vector<int> rows;
    for (int row = 0; row < given.rows(); ++row)
      if (given.session[row] == session) rows.push_back(row);
    Campaign part = given.select(rows);
    // As seen from the base of the second: turned, information about it changes its axes alone.
    Robot there = robot;
    there.sessions.clear();
    there.chain.base = robot.sessions["day 2"].base;
    const ChainEvaluator evaluator(there.chain);
    for (int row = 0; row < part.rows(); ++row)
      part.orientation[row] = evaluator.pose(part.q[row]).rotation;
    const ObservationModel model(part, there, choose_identifiable(robot, part).kept,
                                 {robot.noise.position, robot.noise.orientation});
    const auto at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
    Eigen::MatrixXd block(model.row_size(), model.unknowns() + 1);
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(model.unknowns(), model.unknowns());
    for (int row = 0; row < part.rows(); ++row) {
      at.block(row, block);
      sum += block.leftCols(sum.cols()).transpose() * block.leftCols(sum.cols());
    }
    return sum;
  };
  Eigen::MatrixXd first = information(0), both = information(1);
  const Eigen::Index p = first.cols() - 6;  // the base comes first
  both.bottomRightCorner(p, p) +=
      first.bottomRightCorner(p, p) -
      first.bottomLeftCorner(p, 6) *
          first.topLeftCorner(6, 6).ldlt().solve(first.topRightCorner(6, p));
  const PosePlanner planner(robot, {}, given);
  const double expected = both.ldlt().vectorD().array().log().sum();
  EXPECT_NEAR(planner.quality({}).log_determinant, expected, 1e-6 * std::abs(expected));
}

TEST(Planning, SameSeedSamePoses) {
  const Robot robot = shipped("kr360-spindle");
  PlanOptions other;
  other.seed = 2;
  const std::vector<PlannedPose> plan = PosePlanner(robot, {}).plan(15);
  EXPECT_EQ(plan, PosePlanner(robot, {}).plan(15));
  EXPECT_NE(plan, PosePlanner(robot, other).plan(15));
}

double lowest_point(const Robot& robot, const std::vector<PlannedPose>& poses) {
  const ChainEvaluator evaluator(robot.chain);
  double lowest = 1e9;
  for (const JointVector& q : configurations(poses)) {
    for (const Pose& frame : evaluator.link_frames(q))
      lowest = std::min(lowest, frame.translation.z());
    lowest = std::min(lowest, (inverse(robot.chain.base) * evaluator.pose(q)).translation.z());
  }
  return lowest;
}

TEST(Planning, StaysAboveTheFloor) {
  Robot robot = shipped("kr360-spindle");
  robot.chain.base.translation.z() = 3;  // the floor is the robot's, not the instrument's
  robot.chain.tool.translation.z() = -0.3;
  EXPECT_GE(lowest_point(robot, PosePlanner(robot, {}).plan(60)), -1e-8);
  PlanOptions free;
  free.floor = -10;
  EXPECT_LT(lowest_point(robot, PosePlanner(robot, free).plan(60)), -0.5);
}

TEST(Planning, TheFloorIsThatOfTheRobotFile) {
  Robot robot = shipped("r2000ic-165f");  // R_0 is 670 mm above the foot
  const double lowest = lowest_point(robot, PosePlanner(robot, {}).plan(60));
  EXPECT_GE(lowest, -0.67 - 1e-8);
  EXPECT_LT(lowest, -0.3);
  PlanOptions higher;
  higher.floor = 0;
  EXPECT_GE(lowest_point(robot, PosePlanner(robot, higher).plan(60)), -1e-8);
}

TEST(Planning, FewPosesPromiseNothingButAreChosen) {
  const PosePlanner planner(shipped("kr360-spindle"), {});
  const std::vector<PlannedPose> poses = planner.plan(3);
  EXPECT_EQ(poses.size(), 3u);
  EXPECT_TRUE(std::isinf(planner.quality(poses).cloud_deviation));
}

TEST(Planning, ReadsEveryTargetAtEveryPose) {
  Robot robot = shipped("kr360-spindle");
  robot.chain.targets = {{"1", {0.1, 0, 0}}, {"2", {0, 0.1, 0}}, {"3", {0, 0, 0.1}}};
  const PosePlanner planner(robot, {});
  const std::vector<PlannedPose> planned = planner.plan(20);
  const double deviation = planner.quality(planned).cloud_deviation;
  EXPECT_LT(deviation, promised_by_random(planner, 20, &PlanQuality::cloud_deviation));
}

// A plate that slopes, a ball and a socket, all touched by the second of two tips.
Robot touching_robot() {
  Robot robot = shipped("kr360-spindle");
  robot.chain.targets = {{"1", {0.1, 0, 0}}, {"2", {0, 0.1, 0.05}}};
  const auto add = [&](const char* name, ContactKind kind, const Pose& place, double radius) {
    Contact contact;
    contact.name = name;
    contact.kind = kind;
    contact.place = place;
    contact.radius = radius;
    robot.chain.contacts.push_back(contact);
  };
  add("plate", ContactKind::plane, {rotation_exp({0.1, 0.2, 0}), {2.0, 0, 0.6}}, 0);
  add("ball", ContactKind::sphere, {Eigen::Matrix3d::Identity(), {1.3, -1.2, 1.6}}, 0.08);
  add("socket", ContactKind::point, {Eigen::Matrix3d::Identity(), {1.9, 0.5, 0.9}}, 0);
  return robot;
}

TEST(Planning, TouchesAreOnTheContactsAndOnTheirOutside) {
  const Robot robot = touching_robot();
  PlanOptions options;
  options.touches = true;
  const PosePlanner planner(robot, options);
  const std::vector<PlannedPose> plan = planner.plan(60);
  ASSERT_EQ(plan.size(), 60u);
  std::map<std::string, int> touched;
  for (const PlannedPose& pose : plan) {
    ++touched[pose.contact];
    const Pose frame = ChainEvaluator(robot.chain).pose(pose.q);
    const LinkFrames links = ChainEvaluator(robot.chain).link_frames(pose.q);
    const Eigen::Vector3d tip =
        frame * (pose.target == "1" ? robot.chain.targets[0] : robot.chain.targets[1]).position;
    const Eigen::Vector3d flange = robot.chain.base * links.back().translation;
    const Eigen::Vector3d normal = rotation_exp({0.1, 0.2, 0}).col(2);
    const Eigen::Vector3d plate(2.0, 0, 0.6), ball(1.3, -1.2, 1.6), socket(1.9, 0.5, 0.9);
    if (pose.contact == "plate") {
      EXPECT_NEAR(normal.dot(tip - plate), 0, 1e-9);
      EXPECT_GE(normal.dot(flange - tip), 0);
    } else if (pose.contact == "ball") {
      EXPECT_NEAR((tip - ball).norm(), 0.08, 1e-9);
      EXPECT_GE((tip - ball).dot(flange - tip), 0);
    } else {
      EXPECT_LT((tip - socket).norm(), 1e-9);
    }
  }
  EXPECT_EQ(touched.size(), 3u);
  const double planned = planner.quality(plan).log_determinant;
  for (std::uint64_t seed = 1; seed <= 5; ++seed)
    EXPECT_GT(planned, planner.quality(planner.random(60, seed)).log_determinant + 3) << seed;
}

// What the plan promises is what a calibration of such touches reports: a touch of a plane is one
// number, that of a point three.
TEST(Planning, QualityOfTouchesIsWhatCalibrationReports) {
  Robot robot = touching_robot();
  robot.noise = {1e-4, 1e-4};
  PlanOptions options;
  options.touches = true;
  const PosePlanner planner(robot, options);
  const std::vector<PlannedPose> poses = planner.random(80, 5);
  Campaign campaign;
  campaign.source = "touches";
  campaign.target_names = {"1", "2"};
  campaign.contact_names = {"plate", "ball", "socket"};
  for (const PlannedPose& pose : poses) {
    const auto index = [](const std::vector<std::string>& names, const std::string& name) {
      return static_cast<int>(std::ranges::find(names, name) - names.begin());
    };
    campaign.pose.push_back(campaign.rows());
    campaign.line.push_back(campaign.rows() + 2);
    campaign.pose_ids.push_back(std::to_string(campaign.rows() + 1));
    campaign.distance.push_back(0);
    campaign.touch.push_back({index(campaign.contact_names, pose.contact), -1});
    campaign.target.push_back(index(campaign.target_names, pose.target));
    campaign.q.push_back(pose.q);
  }
  bind_touches(campaign, robot.chain);
  CalibrationOptions plain;
  plain.robust = false;
  const CalibrationResult result = calibrate(robot, campaign, plain);
  const PlanQuality quality = planner.quality(poses);
  for (size_t k = 0; k < quality.observability.size(); ++k)
    EXPECT_NEAR(quality.observability[k] / result.observability[k], 1, 1e-4) << "O" << k + 1;
}

// The same of line profiles, and of pixels beside points: rows of each kind count by their own
// noise.
void expect_reported(const Robot& robot, const PlanOptions& options) {
  const PosePlanner planner(robot, options);
  const std::vector<PlannedPose> poses = planner.random(60, 5);
  SimulationOptions read;
  static_cast<ReadingKinds&>(read) = options;
  Campaign campaign = simulate(poses, robot, read);
  if (read.count() > 1) points_to_coordinates(campaign);
  bind_touches(campaign, robot.chain);
  CalibrationOptions plain;
  plain.robust = false;
  const CalibrationResult result = calibrate(robot, campaign, plain);
  const PlanQuality quality = planner.quality(poses);
  for (size_t k = 0; k < quality.observability.size(); ++k)
    EXPECT_NEAR(quality.observability[k] / result.observability[k], 1, 1e-3) << "O" << k + 1;
}

TEST(Planning, QualityOfProfilesIsWhatCalibrationReports) {
  Robot robot = touching_robot();
  robot.chain.targets.clear();
  PlanOptions options;
  options.profiles = Scanner{{0.08, 0.4}, 30 * kDegree};
  expect_reported(robot, options);
}

TEST(Planning, QualityOfPixelsBesidePointsIsWhatCalibrationReports) {
  Robot robot = shipped("kr360-spindle");
  robot.noise = {5e-5, 1e-4, 0.3};
  Contact camera, board;
  camera.name = "eye";
  camera.kind = ContactKind::camera;
  camera.on_arm = true;
  camera.intrinsics << 1200, 1205, 660, 470, 0, 0, 0, 0, 0, 0;
  board.name = "plate";
  board.kind = ContactKind::board;
  board.place = {rotation_exp({3.0, 0, 0.1}), {1.9, 0.2, 0.8}};
  for (int k = 0; k < 20; ++k)
    board.points.push_back({std::to_string(k), {0.05 * (k % 5), 0.05 * (k / 5), 0}});
  robot.chain.contacts = {camera, board};
  PlanOptions options;
  options.points = options.images = true;
  expect_reported(robot, options);
}

std::string refusal(const PlanOptions& options) {
  try {
    PosePlanner(shipped("kr360-spindle"), options);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Planning, SaysWhatCannotBePlanned) {
  PlanOptions options;
  options.zone = Zone{{9, 0, 0}, 0.1};
  EXPECT_THAT(refusal(options), testing::HasSubstr("enlarge or move the zone"));
  options = {};
  options.floor = 5;
  EXPECT_THAT(refusal(options), testing::HasSubstr("above the floor; move the box up or lower"));
  EXPECT_THROW(PosePlanner(shipped("kr360-spindle"), {}).plan(2001), std::invalid_argument);
}

}  // namespace
}  // namespace armtrue::planning_test
