#include "armtrue/diagnosis/pose_check.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "armtrue/kinematics/conventions.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

constexpr double kRight = std::numbers::pi / 2;
constexpr double kPartsPerLimit = 1e6;  // distances apart by less than a part are alike

// All conventions that may have been misread.
struct Reading {
  Robot robot;
  JointVector q;
  Vector3d place;                // [m]
  std::array<double, 3> angles;  // as typed [deg]
  Eigen::Matrix3d rotation;
};

struct PossibleMistake {
  std::string words;
  std::function<void(Reading&)> apply;
  int topic;           // two of one topic exclude each other
  bool alone = false;  // with another one it would explain too much
};

Eigen::Matrix3d by_abc(const std::array<double, 3>& deg) {
  return rotation_from_abc(deg[0] * kDegree, deg[1] * kDegree, deg[2] * kDegree);
}

Vector3d as_vector(const std::array<double, 3>& angles) {
  return {angles[0], angles[1], angles[2]};
}

void add_joint_mistakes(const Robot& robot, std::vector<PossibleMistake>& mistakes) {
  const std::vector<JointName> joints = joint_names(robot.chain);
  for (int j = 0; j < std::ssize(joints); ++j) {
    const std::string& name = joint_link(robot.chain, j).name;
    const std::string& axis = joints[j].axis;
    mistakes.push_back(
        {fmt::format("joint {} ({}) counts the other way: turn its sign", axis, name),
         [j](Reading& r) { r.q[j] = -r.q[j]; }, j});
    if (joints[j].is_length) continue;
    for (const double zero : {kRight, -kRight, 2 * kRight})
      mistakes.push_back(
          {fmt::format("the zero of joint {} ({}) differs by {:g} deg: add {:g} to its theta_deg",
                       axis, name, zero / kDegree, zero / kDegree),
           [j, zero](Reading& r) { r.q[j] += joint_link(r.robot.chain, j).sign * zero; }, j});
  }
  mistakes.push_back({"the joint angles are in rad",
                      [joints](Reading& r) {
                        for (size_t j = 0; j < joints.size(); ++j)
                          if (!joints[j].is_length) r.q[j] /= kDegree;
                      },
                      kMaxJoints});
  if (is_six_axis_arm(robot.chain) && robot.chain.couplings.empty())
    mistakes.push_back({"joint 3 is shown relative to the horizontal (FANUC): q3 = J3 + J2",
                        [](Reading& r) { r.q[2] += r.q[1]; }, 2});
}

// Height above R_0 for an arm whose first axis is upright [m]; 0 for others.
double height_of_second_axis(const KinematicChain& chain) {
  if (!is_six_axis_arm(chain)) return 0;
  KinematicChain shoulder;
  shoulder.links.assign(chain.links.begin(), chain.links.begin() + link_of_joint(chain, 1) + 1);
  const ChainEvaluator evaluator(shoulder);
  JointVector q = JointVector::Zero(2);
  const double height = evaluator.pose(q).translation.z();
  q[0] = kRight;
  return std::abs(evaluator.pose(q).translation.z() - height) < kMillimetre ? height : 0;
}

void add_other_mistakes(const Robot& robot, std::vector<PossibleMistake>& mistakes) {
  const bool has_beta =
      std::ranges::any_of(robot.chain.links, [](const Link& l) { return l.beta != 0; });
  if (!has_beta && !robot.ground_link)
    mistakes.push_back({"the table is in the standard convention: write convention: standard",
                        [](Reading& r) { r.robot.chain = from_standard(r.robot.chain); },
                        kMaxJoints + 1});
  if (const double height = height_of_second_axis(robot.chain); std::abs(height) > kMillimetre)
    mistakes.push_back(
        {fmt::format("the controller counts from the height of axis 2, {:.4g} mm above R_0, as "
                     "FANUC, Yaskawa and Staubli do; in a URDF this frame is often --base base",
                     height / kMillimetre),
         [height](Reading& r) { r.place.z() += height; }, kMaxJoints + 2});
  for (const double turn : {kRight, -kRight, 2 * kRight})
    mistakes.push_back({fmt::format("the foot is turned about z by {:g} deg", turn / kDegree),
                        [turn](Reading& r) {
                          const Eigen::Matrix3d z =
                              AngleAxisd(turn, Vector3d::UnitZ()).toRotationMatrix();
                          r.place = z.transpose() * r.place;
                          r.rotation = z.transpose() * r.rotation;
                        },
                        kMaxJoints + 2});
  mistakes.push_back({"the angles of the pose are W, P, R or roll, pitch, yaw (c, b, a)",
                      [](Reading& r) {
                        r.rotation = by_abc({r.angles[2], r.angles[1], r.angles[0]});
                      },
                      kMaxJoints + 3});
  mistakes.push_back(
      {"the angles of the pose turn about z, y, z (Doosan's A, B, C)",
       [](Reading& r) {
         r.rotation = by_abc({r.angles[0], r.angles[1], 0}) * by_abc({r.angles[2], 0, 0});
       },
       kMaxJoints + 3});
  mistakes.push_back({"the angles of the pose turn about x, y, z (Staubli's RX, RY, RZ)",
                      [](Reading& r) {
                        r.rotation = by_abc({0, 0, r.angles[0]}) * by_abc({0, r.angles[1], 0}) *
                                     by_abc({r.angles[2], 0, 0});
                      },
                      kMaxJoints + 3});
  mistakes.push_back({"the angles of the pose are a rotation vector in deg",
                      [](Reading& r) { r.rotation = rotation_exp(as_vector(r.angles) * kDegree); },
                      kMaxJoints + 3});
  mistakes.push_back({"the angles of the pose are a rotation vector in rad (UR)",
                      [](Reading& r) { r.rotation = rotation_exp(as_vector(r.angles)); },
                      kMaxJoints + 3});
  mistakes.push_back(
      {"the angles of the pose are in rad",
       [](Reading& r) { r.rotation = rotation_from_abc(r.angles[0], r.angles[1], r.angles[2]); },
       kMaxJoints + 3});
  mistakes.push_back(
      {"the place of the pose is in m", [](Reading& r) { r.place *= 1000; }, kMaxJoints + 4});
}

// A link of a URDF that stands where the flange does is often turned against it.
void add_turned_flanges(const Robot& robot, std::vector<PossibleMistake>& mistakes) {
  for (const double a : {0.0, kRight, 2 * kRight, -kRight})
    for (const double b : {0.0, kRight, -kRight})
      for (const double c : {0.0, kRight, 2 * kRight, -kRight}) {
        const bool is_no_turn = a == 0 && b == 0 && c == 0;
        // There only a - c or a + c counts.
        if (is_no_turn || (b != 0 && c != 0)) continue;
        const Eigen::Matrix3d turn = rotation_from_abc(a, b, c);
        mistakes.push_back(
            {fmt::format("the flange of the controller is turned by a {:g}, b {:g}, c {:g} deg "
                         "against R_{}: of a URDF, --tip names another link than that of the "
                         "flange, which is often tool0",
                         a / kDegree, b / kDegree, c / kDegree, link_count(robot.chain)),
             [turn](Reading& r) { r.rotation *= turn.transpose(); }, kMaxJoints + 5, true});
      }
}

Reading reading_of(const Robot& robot, const JointVector& q, const PendantPose& pose) {
  const std::array<double, 3> angles{pose[3], pose[4], pose[5]};
  return {robot, q, kMillimetre * Vector3d(pose[0], pose[1], pose[2]), angles, by_abc(angles)};
}

// With a tool or base of 0, but for rounding.
bool same_frame(const Pose& a, const Pose& b) {
  constexpr double kRounding = 1e-12;  // [m], of matrix entries
  return (a.translation - b.translation).cwiseAbs().maxCoeff() < kRounding &&
         (a.rotation - b.rotation).cwiseAbs().maxCoeff() < kRounding;
}

// Adds the agreements of one reading.
void compare(const Reading& reading, const std::vector<std::string>& changes, double distance,
             double angle, std::vector<Agreement>& found) {
  const std::vector<ShownFrame> frames = shown_frames(reading.robot, reading.q);
  for (auto frame = frames.begin(); frame != frames.end(); ++frame) {
    if (std::any_of(frames.begin(), frame,
                    [&](const ShownFrame& other) { return same_frame(other.pose, frame->pose); }))
      continue;
    Agreement agreement{
        changes, frame->name + ", " + frame->what, frame == frames.begin(),
        (frame->pose.translation - reading.place).norm(),
        AngleAxisd(Eigen::Matrix3d(frame->pose.rotation.transpose() * reading.rotation)).angle()};
    if (agreement.distance <= distance && agreement.angle <= angle)
      found.push_back(std::move(agreement));
  }
}

// What is before the ground: a positioner, or the other of two arms, by the names of its links.
std::string carrier_of_part(const Robot& robot) {
  if (robot.chain.links[*robot.ground_link].name == "foot")  // as part_to_foot() names it
    return "the positioner";
  std::vector<std::string> names;
  for (int link = 0; link < *robot.ground_link; ++link)
    if (is_driven(robot.chain.links[link])) names.push_back(robot.chain.links[link].name);
  return fmt::format("the arm of '{}' to '{}'", names.back(), names.front());
}

}  // namespace

std::vector<ShownFrame> shown_frames(const Robot& robot, const JointVector& q) {
  const KinematicChain& chain = robot.chain;
  const Pose tool_in_station = ChainEvaluator(chain).pose(q);
  Pose station_from_foot = chain.base;
  if (robot.ground_link)
    station_from_foot = chain.base * ChainEvaluator(chain).link_frames(q)[*robot.ground_link];
  const Pose tool_in_foot = inverse(station_from_foot) * tool_in_station;
  const std::string last = fmt::format("R_{}", link_count(chain));
  const std::string foot = robot.ground_link ? "the foot of the arm" : "R_0";
  const std::string with_tool = fmt::format("{} tool", last);
  std::vector<ShownFrame> frames{
      {"flange in foot", fmt::format("{} in {}", last, foot),
       "KUKA with $BASE and $TOOL 0, ABB tool0 in wobj0, FANUC UF 0 and UT 0, UR tool0 in base",
       tool_in_foot * inverse(chain.tool)},
      {"tool in foot", fmt::format("{} in {}", with_tool, foot),
       "the measured frame, which `tool` of the robot file places", tool_in_foot}};
  if (robot.ground_link) {
    frames.push_back({"part in foot", "R_A in " + foot,
                      "the frame of the part, which " + carrier_of_part(robot) + " carries",
                      inverse(station_from_foot)});
    frames.push_back({"tool in part", with_tool + " in R_A", "the measured frame in that of the part",
                      tool_in_station});
  } else {
    frames.push_back({"tool in base frame", fmt::format("base {} in R_A", with_tool),
                      "the measured frame, seen from where `base` of the robot file is counted",
                      tool_in_station});
  }
  return frames;
}

std::vector<Agreement> find_agreements(const Robot& robot, const JointVector& q,
                                       const PendantPose& pose, double distance, double angle) {
  const Reading typed = reading_of(robot, q, pose);
  std::vector<PossibleMistake> mistakes;
  add_joint_mistakes(robot, mistakes);
  add_other_mistakes(robot, mistakes);
  add_turned_flanges(robot, mistakes);
  std::vector<Agreement> found;
  compare(typed, {}, distance, angle, found);
  if (found.empty())
    for (const PossibleMistake& mistake : mistakes) {
      Reading reading = typed;
      mistake.apply(reading);
      compare(reading, {mistake.words}, distance, angle, found);
    }
  if (found.empty())
    for (size_t a = 0; a < mistakes.size(); ++a)
      for (size_t b = a + 1; b < mistakes.size(); ++b) {
        if (mistakes[a].topic == mistakes[b].topic || mistakes[a].alone || mistakes[b].alone)
          continue;
        Reading reading = typed;
        mistakes[b].apply(reading);  // units of angles before signs, the pose before the foot
        mistakes[a].apply(reading);
        compare(reading, {mistakes[a].words, mistakes[b].words}, distance, angle, found);
      }
  std::ranges::stable_sort(found, {}, [&](const Agreement& a) {
    return std::round(kPartsPerLimit * (a.distance / distance + a.angle / angle));
  });
  return found;
}

std::vector<std::string> find_unseen_signs(const Robot& robot, const JointVector& q,
                                           const PendantPose& pose, double distance, double angle) {
  const Reading typed = reading_of(robot, q, pose);
  std::vector<Agreement> found;
  compare(typed, {}, distance, angle, found);
  std::vector<std::string> unseen;
  if (found.empty()) return unseen;
  for (int joint = 0; joint < joint_count(robot.chain); ++joint) {
    Reading turned = typed;
    turned.q[joint] = -turned.q[joint];
    found.clear();
    compare(turned, {}, distance, angle, found);
    if (!found.empty()) unseen.push_back(joint_link(robot.chain, joint).name);
  }
  return unseen;
}

std::vector<std::string> joints_beyond_travel(const KinematicChain& chain, const JointVector& q) {
  std::vector<std::string> sentences;
  int joint = 0;
  for (const JointName& name : joint_names(chain)) {
    const Link& link = joint_link(chain, joint);
    const double value = q[joint++];
    if (value < link.min || value > link.max)
      sentences.push_back(
          fmt::format("{0} stands at {1:g} {4}, beyond its travel of {2:g} to {3:g} {4}", link.name,
                      value / name.si(), link.min / name.si(), link.max / name.si(), name.unit()));
  }
  return sentences;
}

}  // namespace armtrue
