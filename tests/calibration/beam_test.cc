// Artefacts with faces and balls, and a laser on the wrist: derivatives against automatic ones,
// what the readings show, and campaigns of an arm that KDL simulates.

#include <ceres/jet.h>
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/identifiability.h"
#include "armtrue/campaign/beam_sights.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/planning/planning.h"
#include "armtrue/statistics/distributions.h"
#include "kinematics/jet_chain.h"
#include "kinematics/six_axes.h"
#include "support/temporary_file.h"
#include "touching.h"

namespace armtrue::beam_test {
namespace {

using armtrue_oracle::Dice;
using armtrue_oracle::Fixture;
using armtrue_oracle::Laser;
using armtrue_oracle::OracleArm;
using Kind = Fixture::Kind;

const std::string kArm = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";

ArtefactPoint face(const std::string& name, const Eigen::Vector3d& position,
                   const Eigen::Vector3d& normal) {
  return {name, position, ContactKind::plane, normal};
}

Contact beam_contact(const Pose& place = {}) {
  Contact beam;
  beam.name = "laser";
  beam.kind = ContactKind::beam;
  beam.on_arm = true;
  beam.place = place;
  return beam;
}

Campaign read(const std::string& text, const Robot& robot) {
  Campaign campaign = read_campaign(TemporaryFile(text).path, robot.chain).campaign;
  bind_touches(campaign, robot.chain);
  return campaign;
}

// All derivatives of faces, balls and points of an artefact, and of a beam on a plane and on a
// face, against automatic ones.
TEST(Beam, JacobianEqualsAutomaticDerivatives) {
  constexpr int kOfChain = kGeometricParameters, kOfThing = 7;
  constexpr int kAll = kOfChain + 3 * kOfThing;
  using Jet = ceres::Jet<double, kAll>;
  using Frame = armtrue_oracle::Transform<Jet>;
  using Vector = Eigen::Matrix<Jet, 3, 1>;
  Robot robot = read_robot(kArm).robot;
  robot.chain.base = {rotation_exp({0.3, -0.2, 0.9}), {0.4, -0.3, 0.2}};
  const JointVector q = Eigen::VectorXd(Eigen::Vector<double, 6>(0.2, -0.9, 1.6, 0.4, 0.5, 0.7));
  const Pose measured = ChainEvaluator(robot.chain).pose(q);
  Contact plate;
  plate.name = "plate";
  plate.kind = ContactKind::artefact;
  plate.place = measured * Pose{rotation_exp({0.5, 0.4, -0.3}), {0.2, 0.3, 0.4}};
  plate.radius = 0.004;
  plate.points = {face("f", {0.1, 0.2, 0.05}, Eigen::Vector3d(0.3, -0.2, 1).normalized()),
                  {"b", {-0.1, 0.02, 0.3}, ContactKind::sphere},
                  {"p", {0.03, 0.07, -0.02}}};
  plate.points[1].radius = 0.015;
  Contact table;
  table.name = "table";
  table.kind = ContactKind::plane;
  table.place = measured * Pose{rotation_exp({0.4, 2.8, 0.3}), {0.1, -0.1, 0.5}};
  const Contact laser = beam_contact({rotation_exp({0.2, 0.4, -0.3}), {0.05, 0.02, 0.1}});
  robot.chain.contacts = {plate, table, laser};
  const std::string q_text = "1,0.2,-0.9,1.6,0.4,0.5,0.7,";
  std::string text = "pose,q1_rad,q2_rad,q3_rad,q4_rad,q5_rad,q6_rad,beam,contact,l_m,sigma_mm\n";
  for (const char* row : {",plate/f,0.01,1", ",plate/b,,1", ",plate/p,,1", "laser,table,0.4,1",
                          "laser,plate/f,0.3,1"})
    text += q_text + row + "\n";
  const Campaign campaign = read(text, robot);
  ASSERT_EQ(campaign.rows(), 7);  // three of the point
  const int first = first_contact_parameter(robot.chain);
  std::vector<int> parameters;
  for (int k = 0; k < kOfChain; ++k) parameters.push_back(k);
  for (int c = 0; c < 3; ++c)
    for (int k = 0; k < kOfThing; ++k) parameters.push_back(first + c * kParametersOfContact + k);
  const ObservationModel model(campaign, robot, parameters, {1.0, 1.0});
  const auto at = model.at(Eigen::VectorXd::Zero(kAll));
  Eigen::MatrixXd block(1, kAll + 1);

  const auto jets = jet_parameters<kAll>(robot.chain);
  const Frame arm = jet_frame<kAll>(robot.chain, jets, q);
  const auto moved = [&](const Contact& contact, int from) -> Frame {
    return homogeneous(contact.place).cast<Jet>() *
           armtrue_oracle::shift<Jet>(Jet(0.0, from), Jet(0.0, from + 1), Jet(0.0, from + 2)) *
           armtrue_oracle::turn<Jet>(0, Jet(0.0, from + 3)) *
           armtrue_oracle::turn<Jet>(1, Jet(0.0, from + 4)) *
           armtrue_oracle::turn<Jet>(2, Jet(0.0, from + 5));
  };
  const Frame of_plate = moved(plate, kOfChain), of_table = moved(table, kOfChain + kOfThing),
              of_laser = arm * moved(laser, kOfChain + 2 * kOfThing);
  const Jet radius(plate.radius, kOfChain + 6), of_plane(0.0, kOfChain + kOfThing + 6);
  const auto rotation = [](const Frame& f) { return f.template topLeftCorner<3, 3>().eval(); };
  const auto origin = [](const Frame& f) { return f.template topRightCorner<3, 1>().eval(); };
  // In the axes of the plate.
  const Vector tip = rotation(of_plate).transpose() * (origin(arm) - origin(of_plate));
  const auto along = [&](const Frame& surface, const Eigen::Vector3d& normal,
                         const Eigen::Vector3d& point) -> Jet {
    const Vector n = rotation(surface) * normal.cast<Jet>();
    const Vector p = rotation(surface) * point.cast<Jet>() + origin(surface);
    return n.dot(Vector(p - origin(of_laser))) / n.dot(Vector(rotation(of_laser).col(2)));
  };
  const ArtefactPoint &f = plate.points[0], &b = plate.points[1], &p = plate.points[2];
  const Vector from_ball = tip - b.position.cast<Jet>();
  std::vector<Jet> wanted{
      Vector(f.normal.cast<Jet>()).dot(Vector(tip - f.position.cast<Jet>())) - radius,
      sqrt(from_ball.dot(from_ball)) - Jet(b.radius) - radius};
  for (int axis = 0; axis < 3; ++axis) wanted.push_back(tip[axis] - Jet(p.position[axis]));
  wanted.push_back(along(of_table, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero()));
  wanted.push_back(along(of_plate, f.normal, f.position));
  for (int row = 0; row < campaign.rows(); ++row) {
    at.block(row, block);
    EXPECT_NEAR(at.residual(row)[0], campaign.distance[row] - wanted[row].a, 1e-12) << row;
    for (int k = 0; k < kAll; ++k)
      EXPECT_NEAR(block(0, k), wanted[row].v[k], 1e-9 * std::max(1.0, std::abs(wanted[row].v[k])))
          << parameter_name(robot.chain, parameters[k]) << " row " << row;
  }
}

const std::vector<Fixture> kPlates{{"a", Kind::plane, {1.9, 0.1, 0.6}, {0.2, 0.3, 1}},
                                   {"b", Kind::plane, {2.0, 0.0, 0.7}, {-1, 0.2, 0.1}},
                                   {"c", Kind::plane, {1.3, 1.2, 1.0}, {0.1, -1, 0.2}}};
const Laser kLaser{"laser", {0.03, -0.05, 0.08}, {0.3, -0.2, 1}};

Robot robot_with(std::vector<Contact> contacts) {
  Robot robot = read_robot(kArm).robot;
  robot.chain.contacts = std::move(contacts);
  for (Contact& contact : robot.chain.contacts) contact.is_placed = false;
  return robot;
}

Robot robot_with_laser(const std::vector<Fixture>& planes) {
  std::vector<Contact> contacts{beam_contact()};
  for (const Fixture& plane : planes) {
    contacts.emplace_back().name = plane.name;
    contacts.back().kind = ContactKind::plane;
  }
  return robot_with(contacts);
}

Campaign laser_campaign(const OracleArm& arm, const Robot& robot,
                        const std::vector<Fixture>& planes, int poses, double noise, Dice& dice) {
  return read(laser_csv(read_laser(arm, kLaser, planes, poses, noise, dice), kLaser, planes),
              robot);
}

// A pose of the measured frame shows 4 n + 6 parameters of an arm of n axes, its base and tool. A
// beam is a line with a point on it, which a turn about itself leaves: 4 n + 5. The world may move
// with base and planes (6), and readings are lengths, so nothing grows unseen. With 3 unknowns of a
// plane
//     rank = 4 n + 5 - 6 + 3 planes.
// A plane at a right angle to axis 1 does not see where that axis stands, two parameters.
TEST(Beam, RanksOfBeams) {
  constexpr size_t kShape = 4 * 6 + 5 - 6;
  const auto rank = [](const std::vector<Fixture>& planes) {
    const Robot robot = robot_with_laser(planes);
    Dice dice(7);
    const Campaign campaign =
        laser_campaign(armtrue_oracle::read_arm(kArm), robot, planes, 90, 0, dice);
    const IdentifiableSet set = choose_identifiable(robot, campaign);
    EXPECT_FALSE(length_of_scale(robot, campaign, set));
    return set.kept.size();
  };
  EXPECT_EQ(rank({kPlates[0]}), kShape + 3);
  EXPECT_EQ(rank(kPlates), kShape + 9);
  EXPECT_EQ(rank({{"table", Kind::plane, {0, 0, 0.6}, {0, 0, 1}}}), kShape + 3 - 2);
}

// An artefact, and where it truly is.
struct Placed {
  Contact contact;
  KDL::Frame place;
  double tip = 0;  // radius of what touches [m]

  std::vector<Fixture> fixtures() const {
    std::vector<Fixture> all;
    for (const ArtefactPoint& part : contact.points) {
      const KDL::Vector normal =
          place.M * KDL::Vector(part.normal[0], part.normal[1], part.normal[2]);
      const KDL::Vector at =
          place * KDL::Vector(part.position[0], part.position[1], part.position[2]);
      const std::string name = contact.name + "/" + part.name;
      if (part.kind == ContactKind::plane)
        all.push_back({name, Kind::plane, at + normal * tip, normal});
      else if (part.kind == ContactKind::sphere)
        all.push_back({name, Kind::sphere, at, {0, 0, 1}, part.radius + tip});
      else
        all.push_back({name, Kind::point, at});
    }
    return all;
  }
};

Placed placed(const std::string& yaml, double tip) {
  std::ifstream file(kArm);
  const std::string robot(std::istreambuf_iterator<char>(file), {});
  const TemporaryFile with(robot + "contacts: {thing: " + yaml + "}\n");
  Placed result;
  result.contact = read_robot(with.path).robot.chain.contacts.at(0);
  result.place = {KDL::Rotation::RPY(0.2, -0.3, 0.7), {1.7, 0.3, 0.9}};
  result.tip = tip;
  return result;
}

Campaign touches_of(const OracleArm& arm, const Robot& robot, const std::vector<Fixture>& fixtures,
                    int poses, double noise, Dice& dice) {
  return read(armtrue_oracle::touches_csv(armtrue_oracle::touch(arm, fixtures, poses, noise, dice),
                                          fixtures),
              robot);
}

// Points show 4 n + 3 parameters of an arm, a motion of everything (6) is not seen, and the size of
// the artefact shows the scale, unless the radius of what touches is unknown and imitates it:
//     rank = 4 n + 3 - 6 (- 1) + unknowns,
// six of a place and the radius. A cube alone does not tell a larger arm from a larger tip, a block
// of three different edges does. Steps that look one way show neither a shift along them nor a turn
// about their axis (3 of the place), nor the tip, whose radius is a shift.
TEST(Artefact, RanksOfCubesBlocksBallsAndSteps) {
  constexpr size_t kShape = 4 * 6 + 3 - 6;
  struct Case {
    std::string yaml;
    size_t unknowns;
    bool shows_scale = true;
  };
  for (const Case& one : std::vector<Case>{
           {"{kind: cube, edge_mm: 300, tip_radius_mm: 3}", 6},
           {"{kind: cube, edge_mm: 300}", 7, false},
           {"{kind: cube, edges_mm: [100, 200, 300]}", 7},
           {"{kind: step-gauge, steps_mm: [0, 100, 250, 400]}", 3},
           {"{kind: step-gauge, steps_mm: [0, 100], tip_radius_mm: 1}", 3},
           {"{kind: artefact, balls: {a: [0, 0, 0], b: [500, 0, 0], c: [0, 300, 0]}}", 7},
           {"{kind: artefact, balls: {a: [0, 0, 0], b: [500, 0, 0]}}", 6},
           {"{kind: artefact, balls: {a: [0, 0, 0]}}", 4, false},
           {"{kind: artefact, balls: {a: [0, 0, 0]}, ball_radius_mm: 40, tip_radius_mm: 2}", 3}}) {
    const Placed artefact = placed(one.yaml, 0.003);
    const Robot robot = robot_with({artefact.contact});
    Dice dice(5);
    const Campaign campaign =
        touches_of(armtrue_oracle::read_arm(kArm), robot, artefact.fixtures(), 120, 0, dice);
    const IdentifiableSet set = choose_identifiable(robot, campaign);
    EXPECT_EQ(set.kept.size(), kShape + one.unknowns - (one.shows_scale ? 0 : 1)) << one.yaml;
    EXPECT_EQ(length_of_scale(robot, campaign, set).has_value(), !one.shows_scale) << one.yaml;
  }
}

// What a study of many campaigns of one kind finds: 95 % intervals of links, and of contacts and
// beams, and RMS of what is left of exact readings [m].
struct Study {
  int inside = 0, intervals = 0, things_inside = 0, things = 0;
  double squares = 0;
  int campaigns = 0;

  double coverage() const { return static_cast<double>(inside) / intervals; }
  double of_things() const { return static_cast<double>(things_inside) / things; }
  double left() const { return std::sqrt(squares / campaigns); }
  void print(const char* what) const {
    std::printf("%s: coverage of links %.3f (%d), of contacts and beams %.3f (%d), left %.4f mm\n",
                what, coverage(), intervals, of_things(), things, 1e3 * left());
  }
};

constexpr double kNoise = 5e-5, kErrors = 3e-4;  // m, rad

// The truth, in the parameters that are identified, is a fit of links without priors to exact
// readings.
void add_campaign(Robot robot, const Campaign& campaign, const Campaign& fresh, Study& study) {
  robot.noise.position = kNoise;
  const CalibrationResult fit = calibrate(robot, campaign);
  study.squares += std::pow(summarize(evaluate(fit.robot, fresh).position).rms, 2);
  ++study.campaigns;
  robot.free_links = true;
  robot.chain.contacts = fit.robot.chain.contacts;  // a plane keeps the point about which it tilts
  const CalibrationResult exact = calibrate(robot, fresh, fit.set);
  const double bound = student_t_975(static_cast<int>(campaign.pose_ids.size()) - 1);
  for (size_t i = 0; i < fit.set.kept.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const int parameter = fit.set.kept[i];
    const bool is_of_link = kSixAxes.is_of_links(parameter);
    const double off = is_of_link
                           ? fit.change[k] - exact.change[k]
                           : *parameter_change(fit.robot.chain, exact.robot.chain, parameter);
    const bool is_inside = std::abs(off) <= bound * std::sqrt(fit.covariance(k, k));
    (is_of_link ? study.inside : study.things_inside) += is_inside;
    ++(is_of_link ? study.intervals : study.things);
  }
}

// Links off by 0.3 mm and 0.3 mrad, a noise of 0.05 mm, nothing known of where beam and planes are.
// Six hundred campaigns of 90 readings covered 94.6 % of the links and 94.7 % of beam and planes,
// three hundred of 180 readings 94.5 % and 94.4 %. The intervals of one campaign share its noise,
// so that its share of those covered has a deviation of 9 %: forty campaigns are good to 1.4 %, ten
// to 2.8 %.
TEST(Beam, IntervalsCoverArmBeamAndPlanes) {
  constexpr int kCampaigns = 10, kPoses = 180, kFresh = 180;
  Study study;
  for (unsigned seed = 1; seed <= kCampaigns; ++seed) {
    Dice dice(seed);
    const OracleArm truth =
        armtrue_oracle::with_errors(armtrue_oracle::read_arm(kArm), kErrors, kErrors, -1, dice);
    const Robot robot = robot_with_laser(kPlates);
    const Campaign campaign = laser_campaign(truth, robot, kPlates, kPoses, kNoise, dice);
    add_campaign(robot, campaign, laser_campaign(truth, robot, kPlates, kFresh, 0, dice), study);
  }
  study.print("a beam on three planes");
  EXPECT_GT(study.coverage(), 0.93);
  EXPECT_LT(study.coverage(), 0.97);
  EXPECT_GT(study.of_things(), 0.93);
  EXPECT_LT(study.of_things(), 0.98);
  EXPECT_LT(study.left(), 1e-4);
}

// Mean ratio of distances between places of the tool, less one.
double growth_of(const Robot& fitted, const OracleArm& truth) {
  Dice dice(99);
  const ChainEvaluator evaluator(fitted.chain);
  double own = 0, true_one = 0;
  KDL::Vector before;
  Eigen::Vector3d own_before;
  for (int k = 0; k < 200; ++k) {
    std::array<double, 6> q{};
    for (double& value : q) value = dice.uniform(-1, 1);
    q[1] -= 1.2;
    q[2] += 1.4;
    const KDL::Vector here = forward(truth, q).p;
    const Eigen::Vector3d own_here =
        evaluator.pose(Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(q.data(), 6))).translation;
    if (k > 0) {
      own += (own_here - own_before).norm();
      true_one += (here - before).Norm();
    }
    before = here;
    own_before = own_here;
  }
  return own / true_one - 1;
}

OracleArm enlarged(OracleArm arm, double ratio) {
  for (auto& link : arm.links) {
    link.d *= ratio;
    link.r *= ratio;
  }
  arm.tool.p = arm.tool.p * ratio;
  return arm;
}

// An arm that is 0.1 % larger than its file. Balls, a block with a tip of unknown radius, a cube
// with a known one and steps show it; balls and tip together are as large as they are.
TEST(Artefact, IntervalsCoverAndTheScaleIsRight) {
  constexpr int kCampaigns = 3, kPoses = 100, kFresh = 150;
  constexpr double kTip = 0.003;
  Study study;
  for (const std::string yaml :
       {"{kind: cube, edge_mm: 300, tip_radius_mm: 3}", "{kind: cube, edges_mm: [150, 250, 400]}",
        "{kind: artefact, ball_radius_mm: 20, balls: {a: [0, 0, 0], b: [500, 0, 0], c: [0, 300, "
        "100]}}",
        "{kind: artefact, faces: {a: [0, 0, 0, 1, 0, 0], b: [400, 0, 0, 1, 0, 0], c: [0, 0, 0, 0, "
        "1, "
        "0], d: [0, 0, 0, 0, 0, 1]}}"})
    for (unsigned seed = 1; seed <= kCampaigns; ++seed) {
      Dice dice(seed);
      const OracleArm truth = enlarged(
          armtrue_oracle::with_errors(armtrue_oracle::read_arm(kArm), kErrors, kErrors, -1, dice),
          1.001);
      const Placed artefact = placed(yaml, kTip);
      const Robot robot = robot_with({artefact.contact});
      const Campaign campaign = touches_of(truth, robot, artefact.fixtures(), kPoses, kNoise, dice);
      const Campaign fresh = touches_of(truth, robot, artefact.fixtures(), kFresh, 0, dice);
      add_campaign(robot, campaign, fresh, study);
      const CalibrationResult fit = calibrate(robot, campaign);
      std::printf("%s: growth %.6f, radius %.4f mm\n", yaml.c_str(), growth_of(fit.robot, truth),
                  1e3 * fit.robot.chain.contacts[0].radius);
      EXPECT_LT(std::abs(growth_of(fit.robot, truth)), 1.5e-4) << yaml;
      const bool shows_tip = yaml.find("faces") == std::string::npos;  // or a shift imitates it
      EXPECT_NEAR(fit.robot.chain.contacts[0].radius, shows_tip ? kTip : 0, 1e-4) << yaml;
    }
  study.print("artefacts");
  EXPECT_GT(study.coverage(), 0.93);
  EXPECT_LT(study.coverage(), 0.97);
  EXPECT_GT(study.of_things(), 0.93);
  EXPECT_LT(study.of_things(), 0.98);
  EXPECT_LT(study.left(), 1e-4);
}

// What simulate() makes of a robot against the simulator of tests/support, and plans.
TEST(Beam, SimulatedAndPlannedReadingsAreThoseOfTheOracle) {
  Robot robot = robot_with_laser(kPlates);
  Contact& beam = robot.chain.contacts[0];
  const Eigen::Vector3d along(kLaser.along.data), origin(kLaser.origin.data);
  beam.place = {shortest_rotation(Eigen::Vector3d::UnitZ(), along.normalized()), origin};
  beam.range = {0.05, 0.4};
  for (size_t k = 0; k < kPlates.size(); ++k) {
    Contact& plane = robot.chain.contacts[k + 1];
    plane.place.translation = Eigen::Vector3d(kPlates[k].place.data);
    plane.place.rotation = shortest_rotation(Eigen::Vector3d::UnitZ(),
                                             Eigen::Vector3d(kPlates[k].normal.data).normalized());
  }
  for (Contact& contact : robot.chain.contacts) contact.is_placed = true;
  const OracleArm arm = armtrue_oracle::read_arm(kArm);
  const auto check = [&](const JointVector& joints, const std::string& name, double length) {
    std::array<double, 6> q{};
    for (int j = 0; j < 6; ++j) q[static_cast<size_t>(j)] = joints[j];
    const KDL::Frame tool = forward(arm, q);
    const KDL::Vector end = tool * (kLaser.origin + kLaser.along / kLaser.along.Norm() * length);
    for (const Fixture& plane : kPlates) {
      if (plane.name != BeamName(name).contact) continue;
      EXPECT_NEAR(KDL::dot(end - plane.place, plane.normal), 0, 1e-9);
    }
    EXPECT_GE(length, 0.05);
    EXPECT_LE(length, 0.4);
  };
  SimulationOptions options;
  options.beams = true;
  options.poses = 30;
  const Campaign campaign = simulate(robot, robot, options);
  ASSERT_GE(campaign.rows(), 30);
  for (int row = 0; row < campaign.rows(); ++row)
    check(campaign.q[row], campaign.contact_names[campaign.touch[row].contact],
          campaign.distance[row]);
  PlanOptions planned;
  planned.beams = true;
  const PosePlanner planner(robot, planned);
  const std::vector<PlannedPose> poses = planner.plan(40);
  ASSERT_EQ(poses.size(), 40u);
  const std::vector<BeamSight> sights = beam_sights_of(robot.chain);
  const ChainEvaluator evaluator(robot.chain);
  for (const PlannedPose& pose : poses)
    for (const BeamSight& sight : sights)
      if (sight.name == pose.contact) {
        const auto length = beam_reading_at(robot.chain, sight, evaluator.pose(pose.q));
        ASSERT_TRUE(length);
        check(pose.q, pose.contact, *length);
      }
  EXPECT_LT(planner.quality(poses).cloud_deviation,
            planner.quality(planner.random(40, 5)).cloud_deviation);
}

}  // namespace
}  // namespace armtrue::beam_test
