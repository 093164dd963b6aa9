#include "armtrue/compensation/error_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "compensation/near_posture.h"
#include "compensation/second_arm.h"
#include "kinematics/six_axes.h"

namespace armtrue::error_map_test {
namespace {

using armtrue_oracle::HiddenEffect;
using armtrue_oracle::Moment;
using armtrue_oracle::OracleArm;
using armtrue_oracle::Uniform;

constexpr double kNanometre = 1e-9;

Robot nominal_arm() { return read_robot(kNominalArm).robot; }

CompensationOptions some_frames() {
  CompensationOptions options;
  options.base = {rotation_from_abc(1.2, 0.1, -0.2), {1.0, -0.3, 0.5}};
  options.tool = {rotation_from_abc(0.3, -0.8, 1.1), {0.05, -0.02, 0.21}};
  return options;
}

// Effects of the arm, and the same in KDL's words; the third belongs to the station.
struct Effects {
  std::vector<Effect> stated;
  std::vector<HiddenEffect> same;
};

Effects some_effects() {
  Effects effects;
  effects.stated = {effect_on("A3.theta", "gravity-torque 3", "linear", {2e-7}),
                    effect_on("A5.alpha", "joint-angle 4", "harmonic 1", {3e-4, 1e-4}),
                    effect_on("base.x", "time", "linear", {1e-6}),
                    effect_on("A1.theta", "arrival 1", "linear", {2e-4}),
                    effect_on("A2.theta", "force", "linear", {1e-7})};
  effects.same = {
      [](const Moment& m, OracleArm& a) { a.links[2].theta += 2e-7 * m.torque[2]; },
      [](const Moment& m, OracleArm& a) {
        a.links[4].alpha += 3e-4 * std::sin(m.q[3]) + 1e-4 * std::cos(m.q[3]);
      },
      [](const Moment& m, OracleArm& a) { a.links[0].theta += 2e-4 * m.arrival[0]; },
      [](const Moment& m, OracleArm& a) { a.links[1].theta += 1e-7 * m.force_torque[1]; }};
  return effects;
}

Eigen::Vector3d vector_of(const KDL::Vector& v) { return {v.x(), v.y(), v.z()}; }

TEST(ErrorMap, IsThatOfKdlAndSoAreTheParts) {
  Uniform uniform(31);
  const Robot nominal = nominal_arm();
  Robot robot = random_arm(uniform);
  const Effects effects = some_effects();
  robot.effects = effects.stated;
  const CompensationOptions options = some_frames();
  const KDL::Frame tcp = kdl_frame(options.tool), base = kdl_frame(options.base);
  const OracleArm arm = second(robot), controller = second(nominal);
  std::vector<JointVector> targets;
  for (int k = 0; k < 30; ++k) targets.push_back(random_target(nominal.chain, uniform));
  Program program = joint_program(targets);
  program.visits.time_s.assign(30, 4000);
  program.visits.force_n.assign(30, {300, -200, 400});
  const Eigen::Vector3d force = options.base.rotation * program.visits.force_n.front();
  const ErrorMap map = map_errors(robot, nominal, program, options);
  ASSERT_EQ(map.points.size(), 30u);
  ASSERT_EQ(map.causes.size(), 5u);
  EXPECT_EQ(map.effects, 4u);
  for (size_t k = 0; k < 30; ++k) {
    Conditions now;
    now.time_s = 4000;
    now.force = {force.x(), force.y(), force.z()};
    for (int j = 0; j < kJoints && k > 0; ++j)
      now.arrival[static_cast<size_t>(j)] = targets[k][j] > targets[k - 1][j] ? 1 : -1;
    const auto in_program = [&](const KDL::Vector& from, const KDL::Vector& to) {
      return vector_of(base.M.Inverse() * (to - from));
    };
    const KDL::Frame meant = second_pose(controller, {}, tcp, targets[k], now);
    const KDL::Frame real = second_pose(arm, effects.same, tcp, targets[k], now);
    const KDL::Frame bare = second_pose(arm, {}, tcp, targets[k], now);
    const MapPoint& point = map.points[k];
    ASSERT_TRUE(point.is_predicted);
    EXPECT_LT((point.position - vector_of((base.Inverse() * meant).p)).norm(), kNanometre);
    EXPECT_LT((point.error - in_program(meant.p, real.p)).norm(), kNanometre);
    EXPECT_NEAR(point.turn, radians_between(meant, real), kNanometre);
    EXPECT_NEAR(point.left_by_constants, metres_between(bare, real), kNanometre);
    EXPECT_LT((map.part(k, 0) - in_program(meant.p, bare.p)).norm(), kNanometre);
    Eigen::Vector3d sum = map.part(k, 0);
    for (size_t e = 0; e < 4; ++e) {
      const KDL::Frame one = second_pose(arm, {effects.same[e]}, tcp, targets[k], now);
      EXPECT_LT((map.part(k, e + 1) - in_program(bare.p, one.p)).norm(), kNanometre);
      sum += map.part(k, e + 1);
    }
    EXPECT_LT((sum - point.error).norm(), 3e-6);  // products of two of them
  }
}

// One axis with an arm of 1 m takes a turn away, but not a millimetre along the arm.
TEST(ErrorMap, LeavesWhatFewerAxesCannotCorrect) {
  Robot nominal;
  nominal.chain.links = {{.name = "A1"}, {.name = "flange", .d = 1, .joint = JointKind::fixed}};
  const Program program = joint_program({JointVector::Constant(1, 0.4)});
  Robot turned = nominal, longer = nominal;
  turned.chain.links[0].theta = 1e-3;
  longer.chain.links[1].d = 1.001;
  const MapPoint corrected = map_errors(turned, nominal, program, {}).points.front();
  EXPECT_NEAR(corrected.error.norm(), 2 * std::sin(0.5e-3), kNanometre);
  EXPECT_LT(corrected.rest.position, kNanometre);
  EXPECT_FALSE(corrected.has(CommandNote::fewer_axes));
  const MapPoint left = map_errors(longer, nominal, program, {}).points.front();
  EXPECT_NEAR(left.rest.position, 1e-3, kNanometre);
  EXPECT_TRUE(left.has(CommandNote::fewer_axes));
}

// Turning axis 1 by c m moves the TCP by 2 r sin(c m / 2), r its distance from the vertical.
TEST(ErrorMap, HasTheShareOfAKnownEffectByHand) {
  const Robot nominal = nominal_arm();
  Robot robot = nominal;
  robot.effects = {effect_on("A1.theta", "payload", "linear", {2e-5})};
  Program program = joint_program({JointVector::Zero(6)});
  program.visits.q.front() << 0.3, -1, 1.4, 0.2, 0.9, -0.5;
  program.visits.payload_kg = {50};
  const ErrorMap map = map_errors(robot, nominal, program, {});
  const MapPoint& point = map.points.front();
  const double by_hand = 2 * point.position.head<2>().norm() * std::sin(0.5 * 2e-5 * 50);
  EXPECT_GT(by_hand, 1e-3);
  EXPECT_NEAR(map.part(0, 1).norm(), by_hand, kNanometre);
  EXPECT_NEAR(point.error.norm(), by_hand, kNanometre);
  const Eigen::Vector3d across(point.position.x(), point.position.y(), 0);
  EXPECT_NEAR(point.error.dot(across), -0.5 * by_hand * by_hand, 1e-12);  // a chord
  EXPECT_EQ(map.part(0, 0).norm(), 0);
  const ErrorMapSummary summary = summarize(map);
  EXPECT_NEAR(summary.causes[1].share, 1, 1e-12);
  EXPECT_FALSE(point.deviation || point.after || point.leverage);
}

TEST(ErrorMap, OfTheEffectsOfAControllerIsTheirNegative) {
  Uniform uniform(32);
  Robot robot = nominal_arm(), controller = nominal_arm();
  robot.effects =
      controller.effects = {effect_on("A3.theta", "gravity-torque 3", "linear", {2e-7})};
  const Program program = joint_program({random_target(robot.chain, uniform)});
  const ErrorMap map = map_errors(robot, controller, program, {});
  ASSERT_EQ(map.causes.size(), 3u);
  EXPECT_LT(map.points.front().error.norm(), kNanometre);
  EXPECT_GT(map.part(0, 1).norm(), 1e-5);
  EXPECT_LT((map.part(0, 1) + map.part(0, 2)).norm(), kNanometre);
}

Grid some_grid() {
  Grid grid{{1.4, -0.4, 0.3}, {2.2, 0.4, 1.1}, {5, 4, 3}};
  return grid;
}

Campaign at_rest() {
  Campaign conditions;
  conditions.source = "box";
  conditions.pose = {0};
  conditions.pose_ids = {"box"};
  conditions.line = {0};
  conditions.q = {JointVector::Zero(6)};
  return conditions;
}

CompensationOptions tool_down() {
  CompensationOptions options;
  options.tool.translation = {0, 0, 0.15};
  JointVector start(6);
  start << 0, -60, 90, 0, 60, 0;
  options.start = kDegree * start;
  return options;
}

// The orientation of the tool at the start, of an arm with its foot at R_0.
Eigen::Matrix3d orientation_at_start(const Robot& robot, const CompensationOptions& options) {
  return ChainEvaluator(robot.chain).pose(*options.start).rotation;
}

TEST(ErrorMap, OfAGridStandsAtItsPointsOnOneBranch) {
  Uniform uniform(33);
  const Robot nominal = nominal_arm();
  const Robot robot = random_arm(uniform);
  const CompensationOptions options = tool_down();
  Grid grid = some_grid();
  grid.orientation = orientation_at_start(nominal, options);
  const ErrorMap map = map_errors(robot, nominal, grid, at_rest(), options);
  ASSERT_EQ(map.points.size(), 60u);
  EXPECT_NEAR(map.points[1].position.x() - map.points[0].position.x(), 0.2, 1e-15);
  EXPECT_EQ(map.points.back().position, grid.high);
  const KDL::Frame tcp = kdl_frame(options.tool);
  const OracleArm arm = second(robot), controller = second(nominal);
  for (const MapPoint& point : map.points) {
    ASSERT_TRUE(point.is_predicted);
    const KDL::Frame meant = second_pose(controller, {}, tcp, *point.q, {});
    EXPECT_LT((vector_of(meant.p) - point.position).norm(), kNanometre);
    EXPECT_LT(radians_between(meant, kdl_frame({grid.orientation, {}})), 2e-9);
    const KDL::Frame real = second_pose(arm, {}, tcp, *point.q, {});
    EXPECT_LT((vector_of(real.p - meant.p) - point.error).norm(), kNanometre);
    EXPECT_LT(std::abs((*point.q)[3]), 1.58);  // axis 4 nearer to the start than half a turn away
    EXPECT_GT((*point.q)[2], 0);               // the elbow as at the start
  }
}

// The reach by the sides of the triangle of axis 2, axis 3 and wrist.
TEST(ErrorMap, NamesWhatIsOutOfReach) {
  const Robot nominal = nominal_arm();
  Robot free = nominal;
  for (Link& link : free.chain.links) link.min = -100, link.max = 100;
  const CompensationOptions options = tool_down();
  Grid grid{{0.9, -0.3, -1.2}, {3.6, 0.3, 3.2}, {28, 3, 45}};
  grid.orientation = orientation_at_start(nominal, options);
  const auto frames = ChainEvaluator(nominal.chain).link_frames(*options.start);
  const Eigen::Vector3d tcp_at_start =
      ChainEvaluator(nominal.chain).pose(*options.start) * options.tool.translation;
  const Eigen::Vector3d wrist_from_tcp = frames[4].translation - tcp_at_start;
  const double upper = 1.3, lower = std::hypot(1.025, 0.055);
  const ErrorMap map = map_errors(free, free, grid, at_rest(), options);
  int out = 0;
  for (const MapPoint& point : map.points) {
    const Eigen::Vector3d wrist = point.position + wrist_from_tcp;
    const double side = std::hypot(wrist.head<2>().norm() - 0.5, wrist.z() - 1.045);
    if (std::abs(side - (upper + lower)) < 2e-3 || side < 0.35) continue;
    EXPECT_EQ(point.q.has_value(), side < upper + lower) << point.position.transpose();
    EXPECT_EQ(point.has(CommandNote::unreachable), !point.q);
    EXPECT_EQ(point.is_predicted, point.q.has_value());
    out += !point.q;
  }
  EXPECT_GT(out, 500);
  EXPECT_LT(out, 3000);

  const ErrorMap within = map_errors(nominal, nominal, grid, at_rest(), options);
  EXPECT_GT(count_of(within, CommandNote::limit), 10);
  for (const MapPoint& point : within.points)
    if (point.has(CommandNote::limit)) {
      EXPECT_TRUE(point.q && !point.is_predicted);
    }
}

TEST(ErrorMap, KeepsTargetsThatCannotBeReached) {
  const Robot nominal = nominal_arm();
  Program program = joint_program(std::vector<JointVector>(3, JointVector::Zero(6)));
  const CompensationOptions options = tool_down();
  const Eigen::Matrix3d down = orientation_at_start(nominal, options);
  for (double x : {1.8, 9.8, 1.9}) program.poses.push_back({down, {x, 0, 0.8}});
  program.hinted.assign(3, false);
  const ErrorMap map = map_errors(nominal, nominal, program, options);
  EXPECT_TRUE(map.points[0].is_predicted);
  EXPECT_TRUE(map.points[1].has(CommandNote::unreachable));
  EXPECT_EQ(map.points[1].position.x(), 9.8);
  EXPECT_TRUE(map.points[2].is_predicted);
  EXPECT_EQ(summarize(map).predicted, 2);
  CompensationOptions nowhere = options;
  nowhere.start.reset();
  EXPECT_THROW(map_errors(nominal, nominal, program, nowhere), UnreachableTarget);
  program.poses.assign(3, {down, {9.8, 0, 0.8}});
  EXPECT_THROW(summarize(map_errors(nominal, nominal, program, options)), std::invalid_argument);
}

// Towards the foot the forearm hangs down and the wrist is stretched on the way: a path goes on, a
// program of single targets keeps the side of the wrist and turns axes 4 and 6 by half a turn.
TEST(ErrorMap, FollowsAPathThroughAStretchedWrist) {
  const Robot nominal = nominal_arm();
  const CompensationOptions options = tool_down();
  const Eigen::Matrix3d down = orientation_at_start(nominal, options);
  Program program = joint_program(std::vector<JointVector>(200, JointVector::Zero(6)));
  for (int k = 0; k < 200; ++k) program.poses.push_back({down, {2.2 - 0.004 * k, 0.2, 0.3}});
  program.hinted.assign(200, false);
  const auto largest_step = [&](Following following) {
    const ErrorMap map = map_errors(nominal, nominal, program, options, following);
    double largest = 0;
    for (size_t k = 1; k < 200; ++k)
      largest = std::max(largest, (*map.points[k].q - *map.points[k - 1].q).cwiseAbs().maxCoeff());
    return largest;
  };
  EXPECT_LT(largest_step(Following::continuous), 3 * kDegree);
  EXPECT_GT(largest_step(Following::branch), 170 * kDegree);
}

TEST(ErrorMap, TakesTheWristThatIsNearer) {
  const Robot nominal = nominal_arm();
  const CompensationOptions options = tool_down();
  const ProgramArm arm(nominal, options, options.tool, {});
  const NearPosture posture(arm, *options.start, NearPosture::Turns::within_travel);
  JointVector near(6);
  near << 0.2, -1.2, 1.3, -0.4, 0.7, 0.3;
  JointVector other = near;  // the same pose
  other[3] += std::numbers::pi;
  other[4] = -near[4];
  other[5] -= std::numbers::pi;
  Context context;
  context.q = near;
  const Pose pose = arm.pose(context);
  context.q = other;
  ASSERT_LT(difference(pose, arm.pose(context)).position, kNanometre);
  EXPECT_LT((posture.nearer(context, pose, other) - near).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_LT((posture.nearer(context, pose, near) - near).cwiseAbs().maxCoeff(), 1e-8);
}

// As compensate says it, with the scatter of the readings in what is left.
TEST(ErrorMap, KnowsWhatTheReadingsDoNotCover) {
  Uniform uniform(34);
  const Robot nominal = nominal_arm();
  Robot robot = random_arm(uniform);
  Uncertainty known;
  known.parameters = {"A2.theta", "A3.d"};
  known.root = Eigen::Vector2d(2e-5, 3e-5).asDiagonal();
  known.reading = {1e-4, 1e-4};
  known.poses = 50;
  std::vector<JointVector> targets;
  for (int k = 0; k < 10; ++k) targets.push_back(random_target(nominal.chain, uniform));
  const Program program = joint_program(targets);
  for (double largest : {1e-12, 1.0}) {
    known.largest_variance = largest;
    robot.uncertainty = known;
    const ErrorMap map = map_errors(robot, nominal, program, some_frames());
    const auto corrected = compensate(robot, nominal, program, some_frames());
    for (size_t k = 0; k < 10; ++k) {
      const MapPoint& point = map.points[k];
      EXPECT_NEAR(*point.deviation, *corrected[k].deviation, 1e-12);
      EXPECT_NEAR(*point.leverage, *corrected[k].leverage, 1e-9 * *corrected[k].leverage);
      EXPECT_NEAR(point.error.norm(), corrected[k].before.position, 1e-12);
      EXPECT_NEAR(*point.after, std::sqrt(*point.deviation * *point.deviation + 3e-8), 1e-12);
      EXPECT_EQ(point.has(CommandNote::outside_readings), largest < 1e-6);
    }
  }
}

TEST(ErrorMap, NamesAStretchedWrist) {
  const Robot nominal = nominal_arm();
  JointVector bent(6), stretched;
  bent << 0, -1, 1.4, 0.3, 0.06, 0;
  stretched = bent;
  stretched[4] = 0.05;  // 2.9 deg
  const ErrorMap map = map_errors(nominal, nominal, joint_program({bent, stretched}), {});
  EXPECT_FALSE(map.points[0].has(CommandNote::singular));
  EXPECT_TRUE(map.points[1].has(CommandNote::singular));
}

// A map with errors that a test chooses.
ErrorMap made_up(const Grid& grid, Uniform& uniform) {
  ErrorMap map;
  map.grid = grid;
  map.causes = {"geometry"};
  for (int k = 0; k < grid.points(); ++k) {
    MapPoint& point = map.points.emplace_back();
    map.names.push_back(std::to_string(k + 1));
    point.position = grid.position(k);
    point.is_predicted = uniform(0, 1) < 0.98;
    if (point.is_predicted) point.error = {uniform(0, 3e-3), uniform(-1e-3, 1e-3), 0};
    map.parts.push_back(point.error);
  }
  return map;
}

TEST(ErrorMapSummary, FindsThePlaceOfAPartAsTryingAllDoes) {
  Uniform uniform(35);
  const Grid grid{{0, 0, 0}, {0.6, 0.5, 0.4}, {7, 6, 5}};
  const ErrorMap map = made_up(grid, uniform);
  const ErrorMapSummary summary = summarize(map, Eigen::Vector3d(0.2, 0.1, 0.25));
  double best = 1, worst = 0;
  Eigen::Vector3d best_at, worst_at;
  for (int z = 0; z + 2 < 5; ++z)
    for (int y = 0; y + 1 < 6; ++y)
      for (int x = 0; x + 2 < 7; ++x) {
        double sum = 0;
        bool whole = true;
        for (int k = 0; k < 18; ++k) {
          const MapPoint& point =
              map.points[static_cast<size_t>(grid.point({x + k % 3, y + k / 3 % 2, z + k / 6}))];
          sum += point.error.norm() / 18;
          whole &= point.is_predicted;
        }
        if (whole && sum < best) best = sum, best_at = grid.position(grid.point({x, y, z}));
        if (whole && sum > worst) worst = sum, worst_at = grid.position(grid.point({x, y, z}));
      }
  ASSERT_TRUE(summary.best_before && summary.worst_before);
  EXPECT_NEAR(summary.best_before->mean, best, 1e-12);
  EXPECT_NEAR(summary.worst_before->mean, worst, 1e-12);
  EXPECT_LT((summary.best_before->low - best_at).norm(), 1e-12);
  EXPECT_LT((summary.worst_before->low - worst_at).norm(), 1e-12);
  EXPECT_LT((summary.best_before->high - best_at - Eigen::Vector3d(0.2, 0.1, 0.2)).norm(), 1e-12);
  EXPECT_FALSE(summary.best_after);
}

TEST(ErrorMapSummary, SaysWhichDirectionErrs) {
  Uniform uniform(36);
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {9, 9, 9}};
  const ErrorMap map = made_up(grid, uniform);
  const ErrorMapSummary summary = summarize(map);
  double along_x = 0, along_y = 0, largest = 0;
  for (const MapPoint& point : map.points) {
    along_x += point.error.x() * point.error.x();
    along_y += point.error.y() * point.error.y();
    largest = std::max(largest, point.error.norm());
  }
  EXPECT_GT(summary.axis.x(), 0.99);
  EXPECT_NEAR(summary.axis_share, along_x / (along_x + along_y), 0.01);
  EXPECT_NEAR(summary.mean_error.x(), 1.5e-3, 1e-4);
  EXPECT_NEAR(summary.before.max, largest, 1e-15);
  EXPECT_NEAR(map.points[static_cast<size_t>(summary.worst)].error.norm(), largest, 1e-15);
  EXPECT_NEAR(summary.causes.front().share, 1, 1e-12);
}

}  // namespace
}  // namespace armtrue::error_map_test
