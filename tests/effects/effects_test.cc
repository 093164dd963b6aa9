#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/gravity.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/effects/sampling.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "kinematics/six_axes.h"
#include "support/oracle.h"

namespace armtrue::effects_test {
namespace {

const std::string kRobotFile = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";

JointVector pose_of_test() { return (JointVector(6) << 0.1, -1.2, 0.7, 0.9, 0.4, -0.3).finished(); }

double load(const Robot& robot, int parameter, const JointVector& q) {
  const GravityLoad gravity(robot, parameter);
  Context context;
  context.q = q;
  double value = 0;
  gravity.values(context, ChainEvaluator(robot.chain).link_frames(q), &value);
  return value;
}

// Weights summed in world axes by the oracle.
TEST(Gravity, TorquesEqualTheOracles) {
  const Robot robot = read_robot(kRobotFile).robot;
  const auto arm = armtrue_oracle::read_arm(kRobotFile);
  for (const JointVector& q : sample_joint_space(robot.chain, 30)) {
    const auto moment = armtrue_oracle::moment_of(arm, {q[0], q[1], q[2], q[3], q[4], q[5]});
    for (int j = 0; j < kJoints; ++j)
      EXPECT_NEAR(load(robot, link_parameter(j, LinkParameter::theta), q),
                  moment.torque[static_cast<size_t>(j)], 1e-8);
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(load(robot, kFirstBaseParameter + 3 + i, q), moment.overturning[i], 1e-8);
  }
}

const std::string kPositionerFile = ARMTRUE_CONFIG "/robots/kr360-dkp400.yaml";

// The arm stands on the floor: whatever its positioner does, its joints carry what they carry
// without one.
TEST(Gravity, PositionerDoesNotChangeTheLoadOfTheArm) {
  const Robot robot = read_robot(kPositionerFile).robot;
  const Robot alone = read_robot(ARMTRUE_CONFIG "/robots/kr360.yaml").robot;
  const int first = *robot.ground_link + 1;
  for (const JointVector& q : sample_joint_space(robot.chain, 30))
    for (int j = 0; j < kJoints; ++j)
      EXPECT_NEAR(load(robot, link_parameter(first + j, LinkParameter::theta), q),
                  load(alone, link_parameter(j, LinkParameter::theta), q.tail(6)), 1e-9);
}

// Whatever the part weighs and wherever it is clamped, and whatever the cradle weighs: the basis of
// a joint holds the derivative of the potential energy by its encoder.
TEST(Gravity, BasisOfAPositionerHoldsTheTorquesOfAnyPart) {
  const Robot robot = read_robot(kPositionerFile).robot;
  const ChainEvaluator chain(robot.chain);
  const Eigen::Vector3d part(0.2, -0.1, 0.3), cradle(0.1, 0.25, -0.05);  // in R_0, in E2's frame
  const auto energy = [&](const JointVector& q) {
    const LinkFrames frames = chain.link_frames(q);
    const Pose ground_from_table = inverse(frames[static_cast<size_t>(*robot.ground_link)]);
    return 9.81 * (300 * (ground_from_table * part).z() +
                   120 * (ground_from_table * frames[0] * cradle).z());
  };
  const std::vector<JointVector> poses = sample_joint_space(robot.chain, 40);
  for (int joint : {0, 1}) {
    const GravityLoad gravity(robot, zero_offset(robot.chain, joint));
    ASSERT_GT(gravity.value_count(), 0);
    EXPECT_FALSE(gravity.is_by_masses());
    Eigen::MatrixXd basis = Eigen::MatrixXd::Ones(40, gravity.value_count() + 1);
    Eigen::VectorXd torque(40);
    for (int i = 0; i < 40; ++i) {
      Context context;
      context.q = poses[static_cast<size_t>(i)];
      std::vector<double> values(static_cast<size_t>(gravity.value_count()));
      gravity.values(context, chain.link_frames(context.q), values.data());
      for (int k = 0; k < gravity.value_count(); ++k) basis(i, k) = values[static_cast<size_t>(k)];
      constexpr double kStep = 1e-6;
      JointVector up = context.q, down = context.q;
      up[joint] += kStep;
      down[joint] -= kStep;
      torque[i] = -(energy(up) - energy(down)) / (2 * kStep);
    }
    const Eigen::VectorXd shares = basis.colPivHouseholderQr().solve(torque);
    EXPECT_GT(torque.cwiseAbs().maxCoeff(), 100) << joint;
    EXPECT_LT((basis * shares - torque).cwiseAbs().maxCoeff(), 1e-3) << joint;
  }
}

// The generalised force on any parameter is the fall of potential energy with it.
TEST(Gravity, LoadIsTheGradientOfPotentialEnergy) {
  const Robot robot = read_robot(kRobotFile).robot;
  const auto energy = [&](const KinematicChain& chain, const JointVector& q) {
    const ArmFrames frames = ChainEvaluator(chain).link_frames(q);
    double sum = 0;
    for (const Body& body : robot.bodies)
      sum -= body.mass_kg * robot.gravity.dot(frames[body.link] * body.centre);
    return sum;
  };
  const JointVector q = sample_joint_space(robot.chain, 5).back();
  for (int k = kFirstLinkParameter; k < kFirstToolParameter; ++k) {
    constexpr double kStep = 1e-6;
    KinematicChain up = robot.chain, down = robot.chain;
    move_parameter(up, k, kStep);
    move_parameter(down, k, -kStep);
    EXPECT_NEAR(load(robot, k, q), -(energy(up, q) - energy(down, q)) / (2 * kStep), 1e-4)
        << parameter_name(robot.chain, k);
  }
}

// The same where each link has a beta, which turns the axis of the next alpha and d.
TEST(Gravity, LoadIsTheGradientOfPotentialEnergyWithEveryBeta) {
  Robot robot = read_robot(kRobotFile).robot;
  for (int link = 0; link < link_count(robot.chain); ++link)
    robot.chain.links[link].beta = 0.2 + 0.1 * link;
  const JointVector q = sample_joint_space(robot.chain, 5).back();
  const auto energy = [&](int parameter, double change) {
    KinematicChain chain = robot.chain;
    move_parameter(chain, parameter, change);
    const ArmFrames frames = ChainEvaluator(chain).link_frames(q);
    double sum = 0;
    for (const Body& body : robot.bodies)
      sum -= body.mass_kg * robot.gravity.dot(frames[body.link] * body.centre);
    return sum;
  };
  constexpr double kStep = 1e-6;
  for (int k = kFirstLinkParameter; k < kFirstToolParameter; ++k)
    EXPECT_NEAR(load(robot, k, q), (energy(k, -kStep) - energy(k, kStep)) / (2 * kStep), 1e-4)
        << parameter_name(robot.chain, k);
}

// An arm that slides out of its turning shoulder: the mass at its end weighs by the travel, so that
// a constant first moment does not make the torque.
TEST(Gravity, GenericBasisOfATelescopeHasTheTravel) {
  Robot robot;
  robot.chain.links.resize(2);
  robot.chain.links[0] = {.name = "turn", .alpha = M_PI / 2, .min = -2, .max = 2};
  robot.chain.links[1] = {
      .name = "out", .alpha = M_PI / 2, .min = 0.2, .max = 1.5, .joint = JointKind::prismatic};
  const GravityLoad gravity(robot, link_parameter(0, LinkParameter::theta));
  const ChainEvaluator chain(robot.chain);
  constexpr double kMass = 7;
  const std::vector<JointVector> poses = sample_joint_space(robot.chain, 40);
  Eigen::MatrixXd basis = Eigen::MatrixXd::Ones(40, gravity.value_count() + 1);
  Eigen::VectorXd torque(40);
  for (int i = 0; i < 40; ++i) {
    const auto energy = [&](double turned) {
      JointVector q = poses[i];
      q[0] += turned;
      return kMass * 9.81 * chain.link_frames(q).back().translation.z();
    };
    constexpr double kStep = 1e-6;
    torque[i] = -(energy(kStep) - energy(-kStep)) / (2 * kStep);
    Context context;
    context.q = poses[i];
    Eigen::VectorXd values(gravity.value_count());
    gravity.values(context, chain.link_frames(context.q), values.data());
    basis.row(i).head(values.size()) = values.transpose();
  }
  const Eigen::VectorXd shares = basis.completeOrthogonalDecomposition().solve(torque);
  EXPECT_GT(torque.cwiseAbs().maxCoeff(), 50);
  EXPECT_LT((basis * shares - torque).cwiseAbs().maxCoeff(), 1e-4);
}

// Of a palletiser: the derivative of the potential energy by each encoder, whatever else moves with
// it. The bracket and the load on it only rise and fall, so their centres do not matter.
TEST(Gravity, LoadsOfAJointThatOthersFollow) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/irb460.yaml").robot;
  robot.bodies = {{1, 120, {0.4, 0.05, 0.02}}, {2, 90, {0.5, -0.1, 0}}, {3, 40, {0.1, 0.2, 0.3}}};
  robot.chain.tool.translation = {0.1, 0.2, 0.3};
  const ChainEvaluator evaluator(robot.chain);
  Context context;
  context.payload_kg = 60;
  const auto energy = [&](const JointVector& q) {
    const LinkFrames frames = evaluator.link_frames(q);
    double sum = 60 * robot.gravity.dot(frames.back() * robot.chain.tool.translation);
    for (const Body& body : robot.bodies)
      sum += body.mass_kg * robot.gravity.dot(frames[static_cast<size_t>(body.link)] * body.centre);
    return sum;
  };
  const auto torque = [&](const Robot& arm, int joint, const JointVector& q) {
    context.q = q;
    const GravityLoad gravity(arm, zero_offset(arm.chain, joint));
    double value = 0;
    gravity.values(context, evaluator.link_frames(q), &value);
    return value;
  };
  Robot elsewhere = robot;
  elsewhere.bodies[2].centre = {-0.3, 0.1, 0};
  elsewhere.chain.tool.translation = {-0.5, 0, 0.1};
  constexpr double kStep = 1e-5;
  for (const JointVector& q : sample_joint_space(robot.chain, 30))
    for (int j = 0; j < 4; ++j) {
      JointVector up = q, down = q;
      up[j] += kStep;
      down[j] -= kStep;
      EXPECT_NEAR(torque(robot, j, q), (energy(up) - energy(down)) / (2 * kStep), 1e-4) << j;
      if (j == 1 || j == 2) EXPECT_NEAR(torque(robot, j, q), torque(elsewhere, j, q), 1e-9);
    }
}

// Motor 3 holds the upper arm against the ground: the torque on joint 2 follows the angle of the
// lower arm alone, that on joint 3 the upper arm's. In an arm of the same lengths whose motor 3
// stands on the lower arm, joint 2 carries both.
TEST(Gravity, GenericBasisOfJointsThatOthersFollow) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/irb460.yaml").robot;
  EXPECT_EQ(GravityLoad(robot, zero_offset(robot.chain, 1)).value_count(), 2);
  EXPECT_EQ(GravityLoad(robot, zero_offset(robot.chain, 2)).value_count(), 2);
  std::erase_if(robot.chain.couplings, [](const Coupling& one) { return one.follower == 2; });
  EXPECT_EQ(GravityLoad(robot, zero_offset(robot.chain, 1)).value_count(), 4);
  robot.chain.couplings.clear();  // the bracket as another forearm that stands still on it
  EXPECT_EQ(GravityLoad(robot, zero_offset(robot.chain, 1)).value_count(), 4);
}

// Without masses the torque of any mass in arm and forearm lies in the span of the basis.
TEST(Gravity, GenericBasisSpansTheArmsTorque) {
  Robot robot = read_robot(kRobotFile).robot;
  robot.bodies = {{1, 400, {-0.5, 0.03, 0.02}}, {2, 300, {0.03, -0.3, 0.01}}};
  Robot massless = robot;
  massless.bodies.clear();
  const int parameter = link_parameter(1, LinkParameter::theta);
  const GravityLoad generic(massless, parameter);
  EXPECT_EQ(generic.value_count(), 4);  // sine and cosine of arm and forearm
  EXPECT_EQ(GravityLoad(massless, link_parameter(0, LinkParameter::theta)).value_count(), 0);
  const auto poses = sample_joint_space(robot.chain, 60);
  Eigen::MatrixXd basis(60, generic.value_count() + 1);
  Eigen::VectorXd torque(60);
  for (int i = 0; i < 60; ++i) {
    Context context;
    context.q = poses[i];
    Eigen::VectorXd values(generic.value_count());
    generic.values(context, ChainEvaluator(robot.chain).link_frames(poses[i]), values.data());
    basis.row(i) << values.transpose(), 1.0;
    torque[i] = load(robot, parameter, poses[i]);
  }
  const Eigen::VectorXd left =
      torque - basis * basis.completeOrthogonalDecomposition().solve(torque);
  EXPECT_LT(left.norm(), 1e-8 * torque.norm());
}

// R_A may be tilted against the foot in any way, and gravity pull at the foot in any direction.
TEST(Gravity, TheTurnsOfTheBaseShareOneBasisThatSpansEveryMoment) {
  Robot robot = read_robot(kRobotFile).robot;
  robot.bodies = {{1, 400, {-0.5, 0.03, 0.02}}, {2, 300, {0.03, -0.3, 0.01}}};
  constexpr int kPoses = 40, kTurns = 3;
  const auto poses = sample_joint_space(robot.chain, kPoses);
  std::srand(2);
  for (const double tilt : {0.0, 0.014, 0.035, 0.7, 1.5707963, 3.1415926})
    for (const Eigen::Vector3d& gravity :
         {Eigen::Vector3d(0, 0, -9.81), Eigen::Vector3d(0, 9.81, 0), Eigen::Vector3d(5, -4, 7.4)}) {
      robot.chain.base.rotation =
          rotation_exp(tilt * Eigen::Vector3d::Random().normalized());
      robot.gravity = gravity;
      Robot massless = robot;
      massless.bodies.clear();
      const BoundEffect floor({"floor compliance", "base", *parse_driver("moment"), Shape{}, {}},
                              massless);
      const int size = floor.coefficient_count();
      for (int turn = 3; turn < 6; ++turn)
        EXPECT_EQ(GravityLoad(massless, kFirstBaseParameter + turn).value_count(), size);
      Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(kTurns * kPoses, size + kTurns);
      Eigen::VectorXd moment(kTurns * kPoses);
      for (int i = 0; i < kPoses; ++i) {
        Context context;
        context.q = poses[i];
        const ArmFrames frames = ChainEvaluator(robot.chain).link_frames(poses[i]);
        for (int turn = 0; turn < kTurns; ++turn) {
          const int parameter = kFirstBaseParameter + 3 + turn, row = kTurns * i + turn;
          Eigen::VectorXd values(size);
          GravityLoad(massless, parameter).values(context, frames, values.data());
          basis.row(row).head(size) = values.transpose();
          basis(row, size + turn) = 1;
          moment[row] = load(robot, parameter, poses[i]);
        }
      }
      const Eigen::VectorXd left =
          moment - basis * basis.completeOrthogonalDecomposition().solve(moment);
      EXPECT_LT(left.norm(), 1e-2 * moment.norm()) << tilt;
    }
}

// Axes that are built parallel or upright are some mrad off after a calibration, and every fit
// moves them. What only such an angle makes is no load: its coefficient would be large, and what it
// moves would change with the angle.
TEST(Gravity, AnIdentifiedGeometryHasTheBasisOfTheNominalOne) {
  Robot nominal = read_robot(kRobotFile).robot;
  nominal.bodies.clear();
  std::srand(1);
  for (int arm = 0; arm < 20; ++arm) {
    Robot identified = nominal;
    const Eigen::VectorXd off = 0.003 * Eigen::VectorXd::Random(3 * link_count(nominal.chain) + 2);
    move_parameter(identified.chain, kFirstBaseParameter + 3, off[0]);
    move_parameter(identified.chain, kFirstBaseParameter + 4, off[1]);
    for (int j = 0, k = 2; j < link_count(nominal.chain); ++j)
      for (const LinkParameter angle :
           {LinkParameter::alpha, LinkParameter::beta, LinkParameter::theta})
        move_parameter(identified.chain, link_parameter(j, angle), off[k++]);
    for (int parameter = 0; parameter < ParameterLayout(link_count(nominal.chain)).tool;
         ++parameter)
      EXPECT_EQ(GravityLoad(identified, parameter).value_count(),
                GravityLoad(nominal, parameter).value_count())
          << parameter_name(nominal.chain, parameter) << " of arm " << arm;
  }
}

TEST(RobotModel, AnEffectMovesItsParameter) {
  Robot robot = read_robot(kRobotFile).robot;
  Effect coupling{
      "wrist coupling", "A5.theta", *parse_driver("joint-angle 4"), *parse_shape("linear"), {}};
  coupling.coefficients.push_back({"c", 0.01, 0, {0, 0}});
  Robot with = robot;
  with.effects.push_back(coupling);
  Context context;
  context.q = pose_of_test();
  move_parameter(robot.chain, link_parameter(4, LinkParameter::theta), 0.01 * 0.9);
  const Pose expected = RobotModel(robot).pose(context), got = RobotModel(with).pose(context);
  EXPECT_LT((expected.translation - got.translation).norm(), 1e-14);
  EXPECT_LT((expected.rotation - got.rotation).norm(), 1e-14);
}

// A force does work on each member of a group by that member's own motion, as in the oracle, which
// moves its base.
TEST(RobotModel, AGroupFollowsTheForceOnEachOfItsMembers) {
  const Robot robot = read_robot(kRobotFile).robot;
  const auto arm = armtrue_oracle::read_arm(kRobotFile);
  const std::array<double, 6> q{0.1, -1.2, 0.7, 0.9, 0.4, -0.3};
  const KDL::Vector force(300, -200, 500);
  Context context;
  context.q = pose_of_test();
  context.force_n = {300, -200, 500};
  const BoundEffect bound({"gives way", "base", *parse_driver("force"), *parse_shape("linear"), {}},
                          robot);
  ASSERT_EQ(bound.coefficient_count(), 6);
  PoseJacobian jacobian;
  ChainEvaluator(robot.chain).pose(context.q, jacobian);
  std::vector<double> values(static_cast<size_t>(bound.value_count()));
  bound.values(context, nullptr, &jacobian, values.data());
  for (int k = 0; k < 6; ++k) {
    constexpr double kStep = 1e-6;
    KDL::Twist twist = KDL::Twist::Zero();
    twist[k] = kStep;
    auto moved = arm;
    moved.base = KDL::addDelta(arm.base, twist);
    const double work = KDL::dot(force, (forward(moved, q).p - forward(arm, q).p) / kStep);
    const BoundEffect::Term& term = bound.terms().at(static_cast<size_t>(k));
    EXPECT_EQ(term.coefficient, k);
    EXPECT_NEAR(values.at(static_cast<size_t>(term.value)), work, 0.01) << k;
  }
}

// The torque on one joint, times the force on each member of a group.
TEST(RobotModel, AGroupSharesTheTorqueThatAForceMultiplies) {
  Robot massless = read_robot(kRobotFile).robot;
  const Robot robot = massless;
  massless.bodies.clear();
  Context context;
  context.q = pose_of_test();
  context.force_n = {300, -200, 500};
  for (const Robot& arm : {robot, massless}) {
    const ArmFrames frames = ChainEvaluator(arm.chain).link_frames(context.q);
    PoseJacobian jacobian;
    ChainEvaluator(arm.chain).pose(context.q, jacobian);
    const GravityLoad gravity(arm, link_parameter(1, LinkParameter::theta));
    std::vector<double> torque(static_cast<size_t>(gravity.value_count()));
    gravity.values(context, frames, torque.data());
    for (const auto& [group, first] :
         {std::pair{"base", kFirstBaseParameter}, std::pair{"tool", kFirstToolParameter}}) {
      const BoundEffect bound(
          {"gives way", group, *parse_driver("gravity-torque 2 * force"), Shape{}, {}}, arm);
      ASSERT_EQ(bound.coefficient_count(), 6 * gravity.value_count());
      std::vector<double> values(static_cast<size_t>(bound.value_count()));
      bound.values(context, &frames, &jacobian, values.data());
      for (const BoundEffect::Term& term : bound.terms()) {
        const double force = jacobian.col(term.parameter).head<3>().dot(context.force_n);
        const auto which = static_cast<size_t>(term.coefficient % gravity.value_count());
        EXPECT_EQ(term.parameter, first + term.coefficient / gravity.value_count());
        EXPECT_DOUBLE_EQ(values.at(static_cast<size_t>(term.value)), torque.at(which) * force)
            << group << " " << term.coefficient;
      }
    }
  }
}

TEST(RobotModel, ADriverThatCannotMoveAParameterIsAnError) {
  const Robot robot = read_robot(kRobotFile).robot;
  for (const auto& [parameter, driver] :
       {std::pair{"arm.scale", "force"}, std::pair{"arm.scale", "moment"},
        std::pair{"instrument.scale", "force"}, std::pair{"instrument.scale", "moment"},
        std::pair{"instrument.scale", "time * force"}, std::pair{"A2.d", "position"},
        std::pair{"base", "position * payload"}, std::pair{"A2.d", "joint-angle 2,4"}})
    EXPECT_THROW(BoundEffect({"e", parameter, *parse_driver(driver), Shape{}, {}}, robot),
                 std::invalid_argument)
        << parameter << " by " << driver;
}

// The part turns R_A, and with it the axes in which gravity is given: those of the ground.
TEST(RobotModel, AToolHangsByTheGravityOfTheGround) {
  Robot robot = read_robot(kPositionerFile).robot;
  robot.gravity = {1, -2, -9};
  Context context;
  context.q = sample_joint_space(robot.chain, 5).back();
  const LinkFrames frames = ChainEvaluator(robot.chain).link_frames(context.q);
  const auto ground = static_cast<size_t>(*robot.ground_link);
  const Pose ground_from_last = inverse(frames[ground]) * frames.back();
  const Eigen::Vector3d expected =
      ground_from_last.rotation.transpose() * robot.gravity / robot.gravity.norm();
  const BoundEffect bound({"hangs", "tool.x", *parse_driver("gravity-direction"), Shape{}, {}},
                          robot);
  Eigen::Vector3d direction;
  ASSERT_EQ(bound.value_count(), 3);
  bound.values(context, &frames, nullptr, direction.data());
  EXPECT_LT((direction - expected).norm(), 1e-14);
}

// 1 kg at the measured frame, whatever the payload is.
TEST(RobotModel, ToolWeightIsThatOfAKilogram) {
  Robot robot = read_robot(kRobotFile).robot;
  const BoundEffect bound({"e", "A2.theta", *parse_driver("tool-weight 2"), Shape{}, {}}, robot);
  const ChainEvaluator chain(robot.chain);
  Context context;
  context.q = pose_of_test();
  context.payload_kg = 150;
  const LinkFrames frames = chain.link_frames(context.q);
  double value = 0;
  bound.values(context, &frames, nullptr, &value);
  const auto height = [&](double turned) {
    JointVector q = context.q;
    q[1] += turned;
    return (chain.link_frames(q).back() * robot.chain.tool.translation).z();
  };
  constexpr double kStep = 1e-6;
  EXPECT_NEAR(value, -9.81 * (height(kStep) - height(-kStep)) / (2 * kStep), 1e-6);
}

// The foot gives way under a load, however the load changes with time.
TEST(RobotModel, AFootThatALoadMovesIsOfTheArm) {
  for (const auto& [driver, is_of_arm] : {std::pair{"time", false},
                                          {"time * tool-weight 2", true},
                                          {"time * temperature air", false},
                                          {"payload", true}}) {
    Effect effect;
    effect.parameter = "base.z";
    effect.driver = *parse_driver(driver);
    EXPECT_EQ(moves_program(effect, true), is_of_arm) << driver;
  }
}

// The base is turned by 30 deg about y; gravity is that of R_0.
TEST(Robot, UpwardsIsAgainstGravityInTheInstrumentsFrame) {
  Robot robot = read_robot(kRobotFile).robot;
  robot.gravity = {0, 0, -9.81};
  robot.chain.base.rotation = rotation_exp({0, M_PI / 6, 0});
  EXPECT_LT((upwards(robot) - Eigen::Vector3d(0.5, 0, std::sqrt(0.75))).norm(), 1e-14);
}

// A plate that is bolted to the last axis of the positioner stands still against the ground, too.
TEST(Robot, AFixedLinkBehindThePositionerPlacesIt) {
  Robot robot = read_robot(kPositionerFile).robot;
  const int ground = *robot.ground_link;
  robot.chain.links[static_cast<size_t>(ground)].joint = JointKind::fixed;
  const int axis = ground - 1;
  EXPECT_TRUE(places_positioner(robot, link_parameter(ground, LinkParameter::alpha)));
  EXPECT_TRUE(places_positioner(robot, link_parameter(axis, LinkParameter::theta)));
  EXPECT_TRUE(places_positioner(robot, link_parameter(axis, LinkParameter::r)));
  EXPECT_FALSE(places_positioner(robot, link_parameter(axis, LinkParameter::alpha)));
}

TEST(RobotModel, AFactorMultipliesTheShape) {
  Robot robot = read_robot(kRobotFile).robot;
  Robot with = robot;
  with.effects.push_back({"course",
                          "A3.theta",
                          *parse_driver("joint-angle 2 * temperature air"),
                          *parse_shape("harmonic 1.5"),
                          {{"sin", 1e-5, 0, {0, 0}}, {"cos", 2e-5, 0, {0, 0}}}});
  Context context;
  context.q = pose_of_test();
  context.temperature_c[0] = 27;
  move_parameter(robot.chain, link_parameter(2, LinkParameter::theta),
                 7 * (1e-5 * std::sin(-1.8) + 2e-5 * std::cos(-1.8)));
  const Pose expected = RobotModel(robot).pose(context),
             got = RobotModel(with, {"air"}).pose(context);
  EXPECT_LT((expected.translation - got.translation).norm(), 1e-14);
  EXPECT_LT((expected.rotation - got.rotation).norm(), 1e-14);
}

// A step between sessions stands from one of them on, and in sessions that came after all of them.
// 1 - exp(-x / tau) would be -1.7 a time constant before the begin, and -22025 ten of them.
TEST(RobotModel, AWarmUpIsNothingBeforeItsBegin) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  Effect& warm = robot.effects.emplace_back();
  warm = {"warm-up", "A2.theta", *parse_driver("time"), exponential_shape(100), {{"c", 4e-4}}};
  warm.shape.at = 5000;
  const RobotModel model(robot);
  const int parameter = *find_parameter(robot.chain, "A2.theta");
  Context context;
  const auto offset_at = [&](double time_s) {
    context.time_s = time_s;
    return model.offsets(context)[parameter];
  };
  EXPECT_EQ(offset_at(4000), 0);
  EXPECT_EQ(offset_at(4900), 0);
  EXPECT_NEAR(offset_at(5000 + 100 * std::log(2.0)), 2e-4, 1e-15);
}

TEST(RobotModel, AStepBetweenSessionsStandsSinceOne) {
  Robot robot = read_robot(kRobotFile).robot;
  Effect step{"re-mastered joint", "A2.theta", *parse_driver("session"), step_shape(0.5), {{"c", 1e-3}}};
  step.driver.sessions = {"winter", "spring", "summer"};
  robot.effects = {step};
  const RobotModel model(robot);
  const int moved = *find_parameter(robot.chain, "A2.theta");
  Campaign campaign;
  campaign.session_names = {"summer", "winter", "later", "spring"};
  campaign.q.push_back(pose_of_test());
  for (const auto& [session, expected] :
       {std::pair(1, 0.0), std::pair(3, 1e-3), std::pair(0, 1e-3), std::pair(2, 1e-3)}) {
    campaign.session = {session};
    EXPECT_EQ(model.offsets(campaign.context(0))[moved], expected)
        << campaign.session_names[static_cast<size_t>(session)];
  }
  campaign.session.clear();
  EXPECT_EQ(model.offsets(campaign.context(0))[moved], 1e-3);
}

// The spherical coordinates of the measured point about the instrument, by the closed form.
TEST(RobotModel, AnEffectFollowsTheLineOfSight) {
  Robot robot = read_robot(kRobotFile).robot;
  robot.instrument = {0.4, -0.9, 0.2};
  robot.chain.base = {Eigen::Matrix3d::Identity(), {3, 1, -0.5}};
  Context context;
  context.q = pose_of_test();
  const Pose measured = RobotModel(robot).pose(context);
  const Eigen::Vector3d sight = measured.translation - *robot.instrument;
  const double incidence = std::acos(-sight.normalized().dot(measured.rotation.col(2)));
  for (const auto& [driver, expected] :
       {std::pair("range", sight.norm()), std::pair("azimuth", std::atan2(sight.y(), sight.x())),
        std::pair("elevation", std::asin(sight.z() / sight.norm())),
        std::pair("incidence", incidence)}) {
    const BoundEffect bound({"e", "instrument.elevation", *parse_driver(driver), Shape{}, {}},
                            robot);
    double value = 0;
    const LinkFrames frames = ChainEvaluator(robot.chain).link_frames(context.q);
    bound.values(context, &frames, nullptr, &value);
    EXPECT_NEAR(value, expected, 1e-12) << driver;
  }
}

// R_A turns with a positioner: no place in it is that of an instrument at rest.
TEST(Instrument, IsKnownWhereItIsStatedOrCanStand) {
  Robot robot = read_robot(kRobotFile).robot;
  robot.instrument.reset();
  robot.chain.base.translation = {0.3, 0, 0};  // within reach of the arm
  EXPECT_FALSE(knows_instrument(robot));
  robot.chain.base.translation = {9, 0, 0};
  EXPECT_TRUE(knows_instrument(robot));
  robot.chain.base.translation.setZero();
  robot.instrument = Eigen::Vector3d(4, 0, 1);
  EXPECT_TRUE(knows_instrument(robot));
  Robot turned = read_robot(kPositionerFile).robot;
  turned.instrument = robot.instrument;
  EXPECT_FALSE(knows_instrument(turned));
}

// The length of a wire counts from its own anchor.
TEST(RobotModel, AWireReadsInProportionToItsLength) {
  Robot robot = read_robot(kRobotFile).robot;
  robot.chain.anchors = {{"1", {2.5, 1.5, 0.1}}, {"2", {2.5, -1.5, 0.3}, 2e-3}};
  Context context;
  context.q = pose_of_test();
  const double first = RobotModel(robot).distance(context, -1, 0),
               second = RobotModel(robot).distance(context, -1, 1);
  robot.effects = {
      {"wire scale", "anchor 2.zero", *parse_driver("range"), Shape{}, {{"c", 3e-4}}}};
  EXPECT_NEAR(RobotModel(robot).distance(context, -1, 0), first, 1e-15);
  EXPECT_NEAR(RobotModel(robot).distance(context, -1, 1), second + 3e-4 * (second - 2e-3), 1e-14);
}

TEST(RobotModel, InstrumentScaleStretchesEveryReading) {
  Robot robot = read_robot(kRobotFile).robot;
  robot.chain.targets.push_back({"1", {0.1, 0.2, 0.3}});
  Context context;
  context.q = pose_of_test();
  const Eigen::Vector3d before = RobotModel(robot).point(context, 0);
  robot.effects.push_back({"scale",
                           "instrument.scale",
                           *parse_driver("position"),
                           *parse_shape("linear"),
                           {{"c", 1e-4, 0, {0, 0}}}});
  EXPECT_LT((RobotModel(robot).point(context, 0) - before * 1.0001).norm(), 1e-14);
}

// An arm whose lengths are written 200 ppm longer, and one that has grown so much. Neither a rail,
// base and tool grow with it, nor the zero of a linear axis.
TEST(RobotModel, ArmScaleStretchesEveryLengthOfTheArm) {
  for (const char* name : {"kr360-spindle", "kr360-rail", "ur10e"}) {
    Robot robot = read_robot(ARMTRUE_CONFIG "/robots/" + std::string(name) + ".yaml").robot;
    robot.chain.base.translation = {3, 0.5, 0.2};
    robot.chain.tool.translation = {0.1, 0.2, 0.3};
    robot.chain.links.front().d += 0.4;
    robot.chain.links[3].joint = JointKind::prismatic;
    Robot grown = robot, written = robot;
    grown.effects.push_back({"thermal growth",
                             "arm.scale",
                             *parse_driver("time"),
                             exponential_shape(100),
                             {{"c", 4e-4, 0, {0, 0}}}});
    for (Link& link : written.chain.links) {
      if (link.name == "E1") continue;
      link.d *= 1 + 2e-4;
      if (link.joint != JointKind::prismatic) link.r *= 1 + 2e-4;
    }
    Context context;
    context.q = JointVector::LinSpaced(joint_count(robot.chain), 0.2, 1.3);
    context.time_s = 100 * std::log(2.0);
    const Pose expected = RobotModel(written).pose(context), got = RobotModel(grown).pose(context);
    EXPECT_LT((expected.translation - got.translation).norm(), 1e-14) << name;
    EXPECT_LT((expected.rotation - got.rotation).norm(), 1e-14) << name;
    EXPECT_GT((got.translation - RobotModel(robot).pose(context).translation).norm(), 5e-5) << name;

    // What may be the instrument's goes, and its mean stays in the lengths.
    grown.effects.front().may_be_instrument = true;
    grown.effects.front().mean = 2e-4;
    for (const char* parameter : {"arm.scale", "instrument.scale"}) {
      grown.effects.front().parameter = parameter;
      const Robot alone = without_station_effects(grown, true);
      EXPECT_TRUE(alone.effects.empty());
      EXPECT_LT((expected.translation - RobotModel(alone).pose(context).translation).norm(), 1e-14);
    }
  }
}

TEST(RobotModel, ArmScaleLeavesThePositionerAsItIs) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-dkp400.yaml").robot;
  for (int k : lengths_of_arm(robot)) EXPECT_FALSE(is_of_positioner(robot, k)) << k;
  EXPECT_EQ(std::ssize(lengths_of_arm(robot)), 2 * 7);  // six axes and the spindle
}

TEST(RobotModel, WhatItLacksIsNamed) {
  Robot robot = read_robot(kRobotFile).robot;
  robot.effects.push_back({"growth",
                           "A2.d",
                           *parse_driver("temperature air"),
                           *parse_shape("linear"),
                           {{"c", 1e-5, 0, {0, 0}}}});
  try {
    const RobotModel model(robot);
    FAIL() << "a missing temperature went unseen";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("temp_air_c"), std::string::npos) << error.what();
  }
  robot.effects[0].driver = *parse_driver("time");
  robot.effects[0].coefficients.clear();
  EXPECT_THROW(RobotModel{robot}, std::invalid_argument);
}

TEST(CurveOfAnAngle, KeepsItsEndsBeyondItsCalibration) {
  Robot robot = read_robot(kRobotFile).robot;
  const Shape curve = series_shape(SeriesBasis::cosine, 3, -2, 2);
  robot.effects = {{"unexplained",
                    "A2.theta",
                    *parse_driver("joint-angle 1"),
                    curve,
                    {{"c1", 1e-3}, {"c2", 2e-3}, {"c3", -1e-3}}}};
  const auto moved = [&](double angle) {
    Context context;
    context.q = pose_of_test();
    context.q[0] = angle;
    return RobotModel(robot).offsets(context)[link_parameter(1, LinkParameter::theta)];
  };
  const double inside = moved(0.3), end = moved(0.8), beyond = moved(1.5);
  robot.effects[0].driver_range = {-0.5, 0.8};
  EXPECT_EQ(moved(0.3), inside);
  EXPECT_EQ(moved(1.5), end);
  EXPECT_EQ(moved(-1.9), moved(-0.5));
  EXPECT_NE(end, beyond);
}

}  // namespace
}  // namespace armtrue::effects_test
