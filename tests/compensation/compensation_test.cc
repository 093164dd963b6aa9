#include "armtrue/compensation/compensation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <numeric>

#include "compensation/arms.h"
#include "compensation/second_arm.h"
#include "kinematics/six_axes.h"

namespace armtrue::compensation_test {
namespace {

using armtrue_oracle::HiddenEffect;
using armtrue_oracle::Moment;
using armtrue_oracle::OracleArm;
using armtrue_oracle::Uniform;

constexpr double kNanometre = 1e-9;  // 1e-6 mm

Robot nominal_arm() { return read_robot(kNominalArm).robot; }

// Effects of the arm in armtrue's words, and of its station; then those of the arm in KDL's.
void add_effects(Robot& robot, std::vector<HiddenEffect>& same) {
  robot.effects = {effect_on("A2.theta", "gravity-torque 2", "linear", {1e-7}),
                   effect_on("A3.theta", "gravity-torque 3", "linear", {2e-7}),
                   effect_on("A5.alpha", "joint-angle 4", "harmonic 1", {3e-4, 1e-4}),
                   effect_on("A6.theta", "joint-angle 6", "harmonic 50", {1e-4, 0}),
                   effect_on("A1.theta", "arrival 1", "linear", {2e-4}),
                   effect_on("A3.d", "temperature arm", "linear", {1e-5}),
                   effect_on("A4.theta", "payload", "linear", {2e-6}),
                   effect_on("A1.theta", "force", "linear", {1e-7}),
                   effect_on("A2.r", "time", "linear", {1e-7}),
                   effect_on("base", "moment", "linear", {1e-8}),
                   effect_on("base.x", "time", "linear", {1e-6}),
                   effect_on("base.rz", "temperature arm", "linear", {1e-5}),
                   effect_on("tool.x", "temperature arm", "linear", {1e-5}),
                   effect_on("instrument.scale", "position", "linear", {1e-3})};
  const auto on = [&](const HiddenEffect& effect) { same.push_back(effect); };
  on([](const Moment& m, OracleArm& a) { a.links[1].theta += 1e-7 * m.torque[1]; });
  on([](const Moment& m, OracleArm& a) { a.links[2].theta += 2e-7 * m.torque[2]; });
  on([](const Moment& m, OracleArm& a) {
    a.links[4].alpha += 3e-4 * std::sin(m.q[3]) + 1e-4 * std::cos(m.q[3]);
  });
  on([](const Moment& m, OracleArm& a) { a.links[5].theta += 1e-4 * std::sin(50 * m.q[5]); });
  on([](const Moment& m, OracleArm& a) { a.links[0].theta += 2e-4 * m.arrival[0]; });
  on([](const Moment& m, OracleArm& a) { a.links[2].d += 1e-5 * m.temperature_c; });
  on([](const Moment& m, OracleArm& a) { a.links[3].theta += 2e-6 * m.payload_kg; });
  on([](const Moment& m, OracleArm& a) { a.links[0].theta += 1e-7 * m.force_torque[0]; });
  on([](const Moment& m, OracleArm& a) { a.links[1].r += 1e-7 * m.time_s; });
  on([](const Moment& m, OracleArm& a) {
    const KDL::Vector turn = a.base.M * m.overturning * 1e-8;
    const double angle = length(turn);  // KDL::Rot takes those below 1e-6 for turns about x
    a.base = KDL::Frame(KDL::Rotation::Rot2(turn / angle, angle) * a.base.M, a.base.p);
  });
}

// Random conditions, for armtrue and for KDL.
std::vector<Conditions> random_conditions(Program& program, const Pose& base, Uniform& uniform) {
  Campaign& visits = program.visits;
  visits.temperature_names = {"air", "arm"};
  std::vector<Conditions> all;
  for (int row = 0; row < program.rows(); ++row) {
    Conditions now;
    for (size_t j = 0; j < 6; ++j) now.arrival[j] = uniform(0, 1) < 0.5 ? -1 : 1;
    now.time_s = uniform(0, 5000);
    now.payload_kg = uniform(0, 100);
    now.temperature_c = uniform(15, 40);
    Eigen::Vector3d force(uniform(-500, 500), uniform(-500, 500), uniform(-500, 500));
    visits.time_s.push_back(now.time_s);
    visits.payload_kg.push_back(now.payload_kg);
    visits.temperature_c.push_back({-7, now.temperature_c});
    visits.force_n.push_back(force);  // in the program's frame
    force = base.rotation * force;
    now.force = {force.x(), force.y(), force.z()};
    Direction& direction = visits.arrival.emplace_back();
    for (size_t j = 0; j < 6; ++j) direction[j] = static_cast<std::int8_t>(now.arrival[j]);
    all.push_back(now);
  }
  return all;
}

CompensationOptions frames() {
  CompensationOptions options;
  options.tool = {rotation_from_abc(0.3, -0.8, 1.1), {0.05, -0.02, 0.21}};
  options.base = {rotation_from_abc(1.2, 0.1, -0.2), {1.5, 0.4, 0.8}};
  options.max_correction = 0.1;
  return options;
}

TEST(Compensation, TheSecondArmReachesTheIntendedPose) {
  Uniform uniform(1);
  const Robot nominal = nominal_arm();
  const OracleArm controller = second(nominal);
  const CompensationOptions options = frames();
  const KDL::Frame tcp = kdl_frame(options.tool);
  for (int arm = 0; arm < 60; ++arm) {
    Robot identified = random_arm(uniform);
    std::vector<HiddenEffect> effects;
    add_effects(identified, effects);
    std::vector<JointVector> targets;
    for (int k = 0; k < 10; ++k) targets.push_back(random_target(nominal.chain, uniform));
    Program program = joint_program(targets);
    const std::vector<Conditions> now = random_conditions(program, options.base, uniform);
    const OracleArm truth = second(identified);
    const auto corrected = compensate(identified, nominal, program, options);
    for (size_t k = 0; k < targets.size(); ++k) {
      const KDL::Frame intended = second_pose(controller, {}, tcp, targets[k], {});
      ASSERT_TRUE(corrected[k].is_corrected) << to_string(corrected[k].notes.front());
      const KDL::Frame reached = second_pose(truth, effects, tcp, corrected[k].q, now[k]);
      EXPECT_LT(metres_between(intended, reached), kNanometre);
      EXPECT_LT(radians_between(intended, reached), 1e-9);
      // And what would have been without.
      const KDL::Frame before = second_pose(truth, effects, tcp, targets[k], now[k]);
      EXPECT_NEAR(metres_between(intended, before), corrected[k].before.position, kNanometre);
      EXPECT_NEAR(radians_between(intended, before), corrected[k].before.orientation, 1e-9);
      EXPECT_GT(corrected[k].before.position, 1e-4);
      // The wrist stays bent to its side; a controller that is given the pose finds the joints.
      EXPECT_GT(targets[k][4] * corrected[k].q[4], 0);
      EXPECT_LT((corrected[k].q - targets[k]).cwiseAbs().maxCoeff(), 10 * kDegree);
      const KDL::Frame fake =
          kdl_frame(options.base).Inverse() * second_pose(controller, {}, tcp, corrected[k].q, {});
      EXPECT_LT(metres_between(fake, kdl_frame(corrected[k].pose)), kNanometre);
      EXPECT_LT(radians_between(fake, kdl_frame(corrected[k].pose)), 1e-9);
    }
  }
}

// As a UR10: axes 2, 3 and 4 are parallel, and axes 4, 5 and 6 have no point in common.
Robot arm_without_a_wrist_centre() {
  Robot robot = nominal_arm();
  robot.bodies.clear();
  const double quarter = std::numbers::pi / 2;
  const double alpha[] = {0, quarter, 0, 0, quarter, -quarter, 0};
  const double d[] = {0, 0, -0.612, -0.5723, 0, 0, 0};
  const double r[] = {0.1273, 0, 0, 0.163941, 0.1157, 0.0922, 0};
  for (size_t j = 0; j < kLinks; ++j) {
    Link& link = robot.chain.links[j];
    link = {link.name, alpha[j], d[j], 0, r[j]};
    link.sign = j == 2 ? -1 : 1;
    if (j + 1 == kLinks) link.joint = JointKind::fixed;
  }
  return robot;
}

TEST(Compensation, TheWristNeedsNoCentre) {
  Uniform uniform(7);
  const Robot nominal = arm_without_a_wrist_centre();
  const CompensationOptions options = frames();
  const KDL::Frame tcp = kdl_frame(options.tool);
  int noted = 0;
  for (int k = 0; k < 200; ++k) {
    Robot identified = nominal;
    for (Link& link : identified.chain.links) {
      for (double* angle : {&link.alpha, &link.theta}) *angle += uniform(-1e-3, 1e-3);
      for (double* length : {&link.d, &link.r}) *length += uniform(-1e-3, 1e-3);
    }
    identified.effects = {effect_on("A3.theta", "joint-angle 3", "harmonic 2", {3e-4, 1e-4})};
    const std::vector<HiddenEffect> same{[](const Moment& m, OracleArm& a) {
      a.links[2].theta += 3e-4 * std::sin(2 * m.q[2]) + 1e-4 * std::cos(2 * m.q[2]);
    }};
    JointVector q(6);
    for (int j = 0; j < kJoints; ++j) q[j] = uniform(-3, 3);
    for (int j : {2, 4}) q[j] = (k % 2 ? -1 : 1) * uniform(0.3, 2.8);
    const CorrectedTarget target =
        compensate(identified, nominal, joint_program({q}), options).front();
    const KDL::Frame intended = second_pose(second(nominal), {}, tcp, q, {});
    const KDL::Frame reached = second_pose(second(identified), same, tcp, target.q, {});
    if (!target.notes.empty() && !target.has(CommandNote::turn)) {  // the shoulder's singularity
      ++noted;
      continue;
    }
    EXPECT_LT(metres_between(intended, reached), kNanometre);
    EXPECT_LT((target.q - q).cwiseAbs().maxCoeff(), 10 * kDegree);
  }
  EXPECT_LT(noted, 20);
}

TEST(Compensation, CartesianTargetsGetTheCommandsOfTheirJoints) {
  Uniform uniform(2);
  const Robot nominal = nominal_arm();
  CompensationOptions options = frames();
  const Robot identified = random_arm(uniform);
  std::vector<JointVector> targets;
  for (int k = 0; k < 200; ++k) targets.push_back(random_target(nominal.chain, uniform));
  const Program joints = joint_program(targets);
  const auto expected = compensate(identified, nominal, joints, options);
  Program cartesian = joints;
  for (size_t k = 0; k < targets.size(); ++k) {
    cartesian.poses.push_back(expected[k].intended);
    cartesian.hinted.push_back(true);
    for (int j = 0; j < kJoints; ++j) cartesian.visits.q[k][j] += uniform(-0.03, 0.03);
  }
  const auto found = compensate(identified, nominal, cartesian, options);
  for (size_t k = 0; k < targets.size(); ++k) {
    EXPECT_LT((found[k].programmed - targets[k]).norm(), 1e-7);
    EXPECT_LT((found[k].q - expected[k].q).norm(), 1e-7);
    EXPECT_LT(found[k].after.position, kNanometre);
  }
}

TEST(Compensation, TheRowBeforeTellsTheBranchAndTheTurnTheWholeTurns) {
  const Robot nominal = nominal_arm();
  Uniform uniform(3);
  const Robot identified = random_arm(uniform);
  CompensationOptions options = frames();
  JointVector q(6);
  q << 0.2, -1.2, 1.5, 0.4, 0.7, -0.3;
  std::vector<JointVector> targets;
  for (int k = 0; k < 20; ++k) targets.push_back(q + k * JointVector::Constant(6, 0.02));
  Program program = joint_program(targets);
  for (const CorrectedTarget& target : compensate(identified, nominal, program, options)) {
    program.poses.push_back(target.intended);
    program.hinted.push_back(false);
  }
  EXPECT_THROW(compensate(identified, nominal, program, options), UnreachableTarget);
  options.start = targets.front() + JointVector::Constant(6, 0.1);
  const auto found = compensate(identified, nominal, program, options);
  for (size_t k = 0; k < targets.size(); ++k)
    EXPECT_LT((found[k].programmed - targets[k]).norm(), 1e-8) << k;

  program.turns.assign(targets.size(), 0b001010);  // A4 below zero: a turn less
  const auto turned = compensate(identified, nominal, program, options);
  EXPECT_NEAR(turned.front().programmed[3], targets.front()[3] - 2 * std::numbers::pi, 1e-8);
  EXPECT_NEAR(turned.front().programmed[5], targets.front()[5] + 2 * std::numbers::pi, 1e-8);
  program.turns.assign(targets.size(), 0b001011);  // A1 at -348 deg: beyond its travel
  EXPECT_THROW(compensate(identified, nominal, program, options), UnreachableTarget);
}

TEST(Compensation, TheHintTellsOneOfTwoWrists) {
  const Robot nominal = nominal_arm();
  Uniform uniform(8);
  const Robot identified = random_arm(uniform);
  const CompensationOptions options = frames();
  for (int k = 0; k < 50; ++k) {
    JointVector q = random_target(nominal.chain, uniform);
    Program program = joint_program({q});
    program.poses = {compensate(identified, nominal, program, options).front().intended};
    program.hinted = {true};
    JointVector other = q;
    other[3] += q[3] > 0 ? -std::numbers::pi : std::numbers::pi;
    other[4] = -q[4];
    other[5] += q[5] > 0 ? -std::numbers::pi : std::numbers::pi;
    program.visits.q = {other};
    for (int j = 0; j < kJoints; ++j) program.visits.q.front()[j] += uniform(-0.05, 0.05);
    const CorrectedTarget found = compensate(identified, nominal, program, options).front();
    EXPECT_LT((found.programmed - other).norm(), 1e-7);
    EXPECT_LT(found.after.position, kNanometre);
  }
}

TEST(Compensation, TheStationMovesNoProgram) {
  Uniform uniform(4);
  const Robot nominal = nominal_arm();
  Robot identified = random_arm(uniform);
  identified.effects = {effect_on("A2.theta", "gravity-torque 2", "linear", {1e-7}),
                        effect_on("base", "moment", "linear", {1e-8})};
  std::vector<JointVector> targets;
  for (int k = 0; k < 50; ++k) targets.push_back(random_target(nominal.chain, uniform));
  Program program = joint_program(targets);
  program.visits.payload_kg.assign(targets.size(), 40);
  const auto here = compensate(identified, nominal, program, frames());
  Robot elsewhere = identified;
  const Robot other = random_arm(uniform);
  elsewhere.chain.base = other.chain.base;
  elsewhere.chain.tool = other.chain.tool;
  elsewhere.effects.push_back(effect_on("instrument.scale", "position", "linear", {1e-4}));
  Robot controller = nominal;  // nor does that of the controller's file
  controller.chain.base = identified.chain.base;
  controller.chain.tool = other.chain.tool;
  const auto there = compensate(elsewhere, controller, program, frames());
  for (size_t k = 0; k < targets.size(); ++k) {
    EXPECT_LT((here[k].q - there[k].q).norm(), 1e-9);
    EXPECT_LT((here[k].pose.translation - there[k].pose.translation).norm(), kNanometre);
  }
  EXPECT_FALSE(moves_program(effect_on("base", "time", "linear", {}), true));
  EXPECT_FALSE(moves_program(effect_on("tool", "moment", "linear", {}), false));
  EXPECT_TRUE(moves_program(effect_on("tool", "moment", "linear", {}), true));
  EXPECT_TRUE(moves_program(effect_on("base.rx", "moment", "linear", {}), false));
  EXPECT_TRUE(
      moves_program(effect_on("base.x", "joint-angle 1 * temperature arm", "linear", {}), false));
  for (const char* parameter :
       {"instrument.scale", "instrument.range", "target 1", "target 1.x", "anchor 1.zero"})
    EXPECT_FALSE(moves_program(effect_on(parameter, "position", "linear", {}), true)) << parameter;
  EXPECT_FALSE(moves_program(effect_on("base.x", "azimuth", "linear", {}), false));
  EXPECT_TRUE(moves_program(effect_on("base.x", "stroke 1", "linear", {}), false));
}

TEST(Compensation, TheMeasuredToolBringsItsEffects) {
  Uniform uniform(5);
  const Robot nominal = nominal_arm();
  Robot identified = random_arm(uniform);
  identified.effects = {effect_on("tool.z", "temperature arm", "linear", {1e-5})};
  Program program = joint_program({random_target(nominal.chain, uniform)});
  program.visits.temperature_names = {"arm"};
  program.visits.temperature_c = {{30}};
  CompensationOptions options;
  options.tool_is_measured = true;
  options.max_correction = 0.1;
  const CorrectedTarget target = compensate(identified, nominal, program, options).front();
  const KDL::Frame tcp = kdl_frame(identified.chain.tool);
  const HiddenEffect growth = [](const Moment& m, OracleArm& arm) {
    arm.tool.p.z(arm.tool.p.z() + 1e-5 * m.temperature_c);
  };
  Conditions now;
  now.temperature_c = 30;
  EXPECT_LT(metres_between(second_pose(second(identified), {growth}, tcp, target.q, now),
                           second_pose(second(nominal), {}, tcp, target.programmed, {})),
            kNanometre);
}

TEST(Compensation, AMakersModelWithEffectsIsTheControllersOwn) {
  Uniform uniform(6);
  Robot maker = random_arm(uniform);
  maker.effects = {effect_on("A3.theta", "gravity-torque 3", "linear", {1e-7})};
  const Robot identified = random_arm(uniform);
  const std::vector<HiddenEffect> sag{
      [](const Moment& m, OracleArm& a) { a.links[2].theta += 1e-7 * m.torque[2]; }};
  const CompensationOptions options = frames();
  const KDL::Frame tcp = kdl_frame(options.tool);
  for (int k = 0; k < 20; ++k) {
    const JointVector q = random_target(maker.chain, uniform);
    const CorrectedTarget target =
        compensate(identified, maker, joint_program({q}), options).front();
    const KDL::Frame intended = second_pose(second(maker), sag, tcp, q, {});
    EXPECT_LT(metres_between(intended, second_pose(second(identified), {}, tcp, target.q, {})),
              kNanometre);
  }
  EXPECT_TRUE(states_calibration(maker));
  EXPECT_FALSE(states_calibration(identified));
}

TEST(Compensation, DirectionsOfArrivalFollowTheCommands) {
  const Robot nominal = nominal_arm();
  Robot identified = nominal;
  identified.effects = {effect_on("A1.theta", "arrival 1", "linear", {3e-4})};
  JointVector q(6);
  q << 0.1, -1.2, 1.5, 0.4, 0.7, -0.3;
  const auto at = [&](double first) {
    JointVector other = q;
    other[0] = first;
    return other;
  };
  // Up, down, down; then a program that stands, but whose correction would move the joint.
  const auto found = compensate(identified, nominal,
                                joint_program({at(0.1), at(0.3), at(0.2), at(0.1), at(0.1)}), {});
  EXPECT_NEAR(found[0].q[0], 0.1, 1e-9);  // nobody knows how it came there
  EXPECT_NEAR(found[1].q[0], 0.3 - 3e-4, 1e-9);
  EXPECT_NEAR(found[2].q[0], 0.2 + 3e-4, 1e-9);
  EXPECT_NEAR(found[3].q[0], 0.1 + 3e-4, 1e-9);
  EXPECT_NEAR(found[4].q[0], 0.1 + 3e-4, 1e-9);
  for (const CorrectedTarget& target : found) EXPECT_FALSE(target.has(CommandNote::arrival));
  // From below by less than the correction: it comes from above in either case.
  const auto small =
      compensate(identified, nominal, joint_program({at(0.1), at(0.3), at(0.30001)}), {});
  EXPECT_NEAR(small[2].q[0], 0.30001 - 3e-4, 1e-9);
  EXPECT_FALSE(small[2].has(CommandNote::arrival));
  const auto contrary =
      compensate(identified, nominal, joint_program({at(0.1), at(0.3), at(0.2999)}), {});
  EXPECT_TRUE(contrary[2].has(CommandNote::arrival));
  // The command for the mean: the joint comes from below, and stands beside it.
  EXPECT_NEAR(contrary[2].q[0], 0.2999, 1e-9);
  const double half = metres_between(second_pose(second(nominal), {}, {}, at(0.2999), {}),
                                     second_pose(second(nominal), {}, {}, at(0.2999 + 3e-4), {}));
  EXPECT_NEAR(contrary[2].after.position, half, kNanometre);
}

// Of a joint that has not moved yet, nobody knows the side on which it stands.
TEST(Compensation, AnUnknownDirectionOfArrivalIsInTheDeviation) {
  const Robot nominal = nominal_arm();
  Robot identified = nominal;
  identified.effects = {effect_on("A1.theta", "arrival 1", "linear", {3e-4})};
  Uncertainty& exact = identified.uncertainty.emplace();
  exact.root = Eigen::MatrixXd::Zero(1, 1);
  exact.poses = 40;
  JointVector q(6), moved(6);
  q << 0.1, -1.2, 1.5, 0.4, 0.7, -0.3;
  moved = q;
  moved[0] = 0.4;
  const auto found = compensate(identified, nominal, joint_program({q, q, moved}), {});
  JointVector beside = q;
  beside[0] += 3e-4;
  const double half = metres_between(second_pose(second(nominal), {}, {}, q, {}),
                                     second_pose(second(nominal), {}, {}, beside, {}));
  EXPECT_GT(half, 1e-4);
  EXPECT_NEAR(found[0].deviation.value(), half, 1e-3 * half);
  EXPECT_NEAR(found[1].deviation.value(), half, 1e-3 * half);
  EXPECT_LT(found[2].deviation.value(), 1e-9);
}

// Where a joint with play reverses among close points, it moves less from point to point than the
// correction does, and commands of either direction agree with themselves. The program turns once,
// and so do the commands, with one step of twice the play.
TEST(Compensation, CommandsReverseOnceWhereTheProgramDoes) {
  const Robot nominal = nominal_arm();
  Robot identified = nominal;
  constexpr double kPlay = 4e-4;
  identified.effects = {effect_on("A3.theta", "arrival 3", "sign", {-kPlay})};
  std::vector<JointVector> targets;
  for (int k = 0; k <= 40; ++k) {
    JointVector& q = targets.emplace_back(6);
    q << 0.1, -1.2, 1.5 - 2e-6 * (k - 20) * (k - 20), 0.4, 0.7, -0.3;
  }
  const auto found = compensate(identified, nominal, joint_program(targets), {});
  for (size_t k = 1; k < targets.size(); ++k) {
    const double direction = k <= 20 ? 1 : -1;
    EXPECT_NEAR(found[k].q[2], targets[k][2] + direction * kPlay, 1e-9) << k;
    EXPECT_FALSE(found[k].has(CommandNote::arrival)) << k;
  }
}

// Friction turns round within the stroke, which is that of the commands.
TEST(Compensation, StrokesFollowTheCommandsToo) {
  const Robot nominal = nominal_arm();
  Robot identified = nominal;
  constexpr double kLag = 2e-4, kTurnRound = 3e-3;
  Effect friction = effect_on("A1.theta", "stroke 1", "pre-sliding", {kLag});
  friction.shape.tau = kTurnRound;
  identified.effects = {friction};
  JointVector q(6);
  q << 0.1, -1.2, 1.5, 0.4, 0.7, -0.3;
  std::vector<JointVector> targets(5, q);
  const double first[] = {0.1, 0.3, 0.298, 0.2965, 0.297};  // up, down in two steps, up again
  for (size_t k = 0; k < targets.size(); ++k) targets[k][0] = first[k];
  const auto found = compensate(identified, nominal, joint_program(targets), {});
  double turned_at = found[0].q[0], before = turned_at;
  int direction = 0;
  for (size_t k = 1; k < targets.size(); ++k) {
    const double now = found[k].q[0];
    const int sign = now > before ? 1 : -1;
    if (sign != direction) turned_at = before;
    direction = sign;
    before = now;
    const double lag = kLag * sign * (1 - 2 * std::exp(-std::abs(now - turned_at) / kTurnRound));
    EXPECT_NEAR(now + lag, first[k], 1e-11) << k;
    EXPECT_FALSE(found[k].has(CommandNote::arrival));
  }
  Program stated = joint_program(targets);
  stated.visits.arrival.assign(targets.size(), Direction{1, 1, 1, 1, 1, 1});
  EXPECT_THROW(compensate(identified, nominal, stated, {}), std::invalid_argument);
  stated.visits.stroke.assign(targets.size(), JointVector::Constant(6, 1));
  EXPECT_NEAR(compensate(identified, nominal, stated, {}).back().q[0], 0.297 - kLag, 1e-9);
}

TEST(Compensation, NeitherLimitsNorLargeCorrectionsArePassedInSilence) {
  const Robot nominal = nominal_arm();
  Robot identified = nominal;
  identified.chain.links[1].theta += 2e-3;
  JointVector q(6);
  q << 0.1, 0, 0.5, 0.4, 0.7, -0.3;
  q[1] = nominal.chain.links[1].min + 1e-3;
  CompensationOptions options;
  options.max_correction = 1;
  const auto limit = compensate(identified, nominal, joint_program({q}), options).front();
  EXPECT_TRUE(limit.has(CommandNote::limit));
  EXPECT_EQ(limit.q, q);
  EXPECT_FALSE(limit.is_corrected);
  EXPECT_EQ(limit.after.position, limit.before.position);

  q[1] = -1;
  options.max_correction = 1e-3;
  const auto large = compensate(identified, nominal, joint_program({q}), options).front();
  EXPECT_TRUE(large.has(CommandNote::beyond_max));
  EXPECT_EQ(large.q, q);
  options.max_correction = 10e-3;
  const auto allowed = compensate(identified, nominal, joint_program({q}), options).front();
  EXPECT_TRUE(allowed.notes.empty());
  EXPECT_NEAR(allowed.q[1], -1 - 2e-3, 1e-9);

  q[1] = -1e-3;  // A2 crosses zero
  identified.chain.links[1].theta -= 4e-3;
  EXPECT_TRUE(
      compensate(identified, nominal, joint_program({q}), options).front().has(CommandNote::turn));

  // Out of reach: a stretched arm that is shorter than the controller thinks.
  Robot longer = nominal;
  longer.chain.links[2].d -= 0.1;
  const auto far_away = compensate(nominal, longer, joint_program({[&] {
                                     JointVector stretched = q;
                                     stretched << 0, -1, 0.05, 0.4, 0.7, -0.3;
                                     return stretched;
                                   }()}),
                                   options)
                            .front();
  EXPECT_TRUE(far_away.has(CommandNote::unreachable) || far_away.has(CommandNote::singular) ||
              far_away.has(CommandNote::beyond_max));
  EXPECT_FALSE(far_away.is_corrected);
}

TEST(Compensation, SessionsWithZerosOfTheirOwnMustBeNamed) {
  Robot robot = nominal_arm();
  EXPECT_THROW(in_session(robot, "day 1"), std::invalid_argument);
  robot.sessions["day 1"];
  EXPECT_EQ(in_session(robot, "").chain.links[1].theta, robot.chain.links[1].theta);
  robot.sessions["day 2"].zero[1] = 3.1;
  EXPECT_THROW(in_session(robot, ""), std::invalid_argument);
  EXPECT_EQ(in_session(robot, "day 2").chain.links[1].theta, 3.1);

  Robot rail = read_robot(ARMTRUE_CONFIG "/robots/kr360-rail.yaml").robot;
  rail.sessions["day 2"].zero[0] = 0.5;
  EXPECT_EQ(in_session(rail, "day 2").chain.links[0].r, 0.5);
  EXPECT_EQ(in_session(rail, "day 2").chain.links[0].theta, rail.chain.links[0].theta);
}

// What happened between sessions holds for a program as it was in the session that is named, and
// else as it was after the last.
TEST(Compensation, AppliesTheArmAsItWasInASession) {
  Robot robot = nominal_arm();
  Effect step = effect_on("A2.theta", "session", "step", {1e-3});
  step.driver.sessions = {"winter", "spring", "summer"};
  step.shape.at = 0.5;
  robot.effects = {step};
  for (const char* name : {"winter", "spring", "summer"}) robot.sessions[name].base = {};
  Uniform uniform(11);
  const Program program = joint_program({random_target(robot.chain, uniform)});
  const auto moved = [&](const Robot& identified) {
    const auto targets = compensate(identified, nominal_arm(), program, {});
    return targets.front().q[1] - targets.front().programmed[1];
  };
  EXPECT_NEAR(moved(in_session(robot, "")), -1e-3, 1e-9);
  EXPECT_NEAR(moved(in_session(robot, "winter")), 0, 1e-9);
  EXPECT_NEAR(moved(in_session(robot, "spring")), -1e-3, 1e-9);
}

// A long program is corrected in blocks, each of which selects its rows.
TEST(Compensation, SomeRowsOfALongProgramCostAsManyOfAShortOne) {
  const auto seconds = [](int rows) {
    Program program =
        joint_program(std::vector<JointVector>(static_cast<size_t>(rows), JointVector::Zero(6)));
    program.poses.resize(static_cast<size_t>(rows));
    program.hinted.resize(static_cast<size_t>(rows), true);
    std::vector<int> some(1000);
    std::iota(some.begin(), some.end(), 0);
    const std::clock_t start = std::clock();
    for (int k = 0; k < 20; ++k) EXPECT_EQ(select(program, some).rows(), 1000);
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  };
  const double of_short = seconds(1000);
  EXPECT_LT(seconds(300000), 0.05 + 20 * of_short);
}

}  // namespace
}  // namespace armtrue::compensation_test
