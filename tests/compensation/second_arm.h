#pragma once

// The identified arm once more, in KDL: what the commands must make it do is computed here without
// any code of armtrue.

#include <array>
#include <cmath>
#include <functional>
#include <kdl/frames.hpp>
#include <string>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/units.h"
#include "kinematics/kdl_arm.h"
#include "kinematics/six_axes.h"
#include "support/oracle.h"
#include "support/random_chain.h"
#include "support/temporary_file.h"

namespace armtrue {

inline const std::string kNominalArm = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";

inline std::array<double, 6> angles(const JointVector& q) {
  return {q[0], q[1], q[2], q[3], q[4], q[5]};
}

inline armtrue_oracle::OracleArm second(const Robot& robot) {
  const TemporaryFile file(write_robot(robot));
  return armtrue_oracle::read_arm(file.path);
}

/// What a row states beside its joints.
struct Conditions {
  std::array<int, 6> arrival{};
  double time_s = 0, payload_kg = 0, temperature_c = 20;
  KDL::Vector force;  // axes of R_0 [N]
};

/// R_0 from the TCP, of an arm whose station stands wherever it stood.
inline KDL::Frame second_pose(const armtrue_oracle::OracleArm& arm,
                              const std::vector<armtrue_oracle::HiddenEffect>& effects,
                              const KDL::Frame& tcp, const JointVector& q, const Conditions& now) {
  armtrue_oracle::OracleArm own = arm;
  own.tool = tcp;
  armtrue_oracle::OracleArm loaded = own;
  loaded.masses.push_back({6, now.payload_kg, tcp.p});
  armtrue_oracle::Moment moment = armtrue_oracle::moment_of(loaded, angles(q));
  moment.arrival = now.arrival;
  moment.time_s = now.time_s;
  moment.payload_kg = now.payload_kg;
  moment.temperature_c = now.temperature_c;
  // The work of the force for a turn of each joint, by central differences.
  for (size_t j = 0; j < 6; ++j) {
    constexpr double kStep = 1e-5;
    std::array<double, 6> high = angles(q), low = high;
    high[j] += kStep;
    low[j] -= kStep;
    const KDL::Vector way =
        armtrue_oracle::forward(own, high).p - armtrue_oracle::forward(own, low).p;
    moment.force_torque[j] = KDL::dot(way / (2 * kStep), arm.base.M * now.force);
  }
  armtrue_oracle::OracleArm changed = own;
  for (const auto& effect : effects) effect(moment, changed);
  return arm.base.Inverse() * armtrue_oracle::forward(changed, angles(q));
}

// KDL's own norms and rotation vectors take what is below 1e-6 for nothing.
inline double length(const KDL::Vector& v) { return std::sqrt(KDL::dot(v, v)); }

inline double metres_between(const KDL::Frame& a, const KDL::Frame& b) { return length(a.p - b.p); }

inline double radians_between(const KDL::Frame& a, const KDL::Frame& b) {
  const KDL::Rotation r = a.M.Inverse() * b.M;
  const KDL::Vector twice_sine(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
  return std::asin(0.5 * length(twice_sine));
}

/// The nominal arm with other lengths and angles everywhere, in a station anywhere.
inline Robot random_arm(armtrue_oracle::Uniform& uniform) {
  Robot robot = read_robot(kNominalArm).robot;
  for (Link& link : robot.chain.links) {
    for (double* angle : {&link.alpha, &link.theta, &link.beta}) *angle += uniform(-1e-3, 1e-3);
    for (double* length : {&link.d, &link.r}) *length += uniform(-1e-3, 1e-3);
  }
  const auto pose = [&](double reach) {
    return Pose{rotation_from_abc(uniform(-3, 3), uniform(-1, 1), uniform(-3, 3)),
                Eigen::Vector3d(uniform(-reach, reach), uniform(-reach, reach), uniform(0, reach))};
  };
  robot.chain.base = pose(4);
  robot.chain.tool = pose(0.3);
  return robot;
}

/// Joint angles within the middle of the travel; the wrist bent by 5 deg or more, the arm not
/// stretched, the wrist not above axis 1.
inline JointVector random_target(const KinematicChain& chain, armtrue_oracle::Uniform& uniform) {
  constexpr double kStretched = -3.07 * kDegree;  // of A3: atan(55 / 1025)
  while (true) {
    JointVector q(6);
    for (int j = 0; j < kJoints; ++j) {
      const auto [low, high] = travel(chain.links[static_cast<size_t>(j)]);
      q[j] = 0.9 * uniform(low, high);
    }
    q[4] = (uniform(0, 1) < 0.5 ? -1 : 1) * uniform(5 * kDegree, 110 * kDegree);
    const Eigen::Vector3d wrist = ChainEvaluator(chain).link_frames(q)[4].translation;
    if (std::abs(q[2] - kStretched) > 12 * kDegree && wrist.head<2>().norm() > 0.4) return q;
  }
}

inline Program joint_program(const std::vector<JointVector>& targets) {
  Program program;
  program.visits.source = "targets.csv";
  for (const JointVector& q : targets) {
    program.visits.pose.push_back(program.visits.rows());
    program.visits.pose_ids.emplace_back("P").append(std::to_string(program.visits.rows() + 1));
    program.visits.line.push_back(program.visits.rows() + 2);
    program.visits.q.push_back(q);
  }
  return program;
}

inline Effect effect_on(const std::string& parameter, const std::string& driver,
                        const std::string& shape, const std::vector<double>& coefficients) {
  Effect effect{
      parameter + " by " + driver, parameter, *parse_driver(driver), *parse_shape(shape), {}};
  for (double value : coefficients) effect.coefficients.push_back({"c", value});
  return effect;
}

}  // namespace armtrue
