#include "oracle.h"

#include <yaml-cpp/yaml.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <kdl/chain.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <map>
#include <optional>
#include <stdexcept>

namespace armtrue_oracle {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kDeg = kPi / 180;
constexpr double kSecondsPerVisit = 20;
constexpr double kShareOfTravel = 0.9;
constexpr double kSliding = 25 * kDeg;  // of a friction that gives way slowly, as in a belt

KDL::Rotation abc(double a, double b, double c) { return KDL::Rotation::RPY(c, b, a); }

KDL::Frame read_frame(const YAML::Node& node) {
  const auto value = [&](const char* key) { return node[key].as<double>(); };
  return {abc(value("a_deg") * kDeg, value("b_deg") * kDeg, value("c_deg") * kDeg),
          KDL::Vector(value("x_mm"), value("y_mm"), value("z_mm")) / 1000};
}

KDL::Frame link_frame(const OracleLink& link, double q) {
  const KDL::Rotation tilt = KDL::Rotation::RotY(link.beta) * KDL::Rotation::RotX(link.alpha);
  return {tilt * KDL::Rotation::RotZ(link.theta + link.sign * q),
          tilt * KDL::Vector(link.d, 0, link.r)};
}

// What an instrument with errors reads of a point: spherical coordinates about its place, changed
// and turned back.
KDL::Vector as_read(const OracleArm& arm, const KDL::Vector& point) {
  if (arm.range == 0 && arm.azimuth == 0 && arm.elevation == 0) return point + arm.point;
  const KDL::Vector ray = point - kStation;
  const double range = ray.Norm() + arm.range;
  const double azimuth = std::atan2(ray.y(), ray.x()) + arm.azimuth;
  const double elevation = std::atan2(ray.z(), std::hypot(ray.x(), ray.y())) + arm.elevation;
  return kStation + range * KDL::Vector(std::cos(elevation) * std::cos(azimuth),
                                        std::cos(elevation) * std::sin(azimuth),
                                        std::sin(elevation));
}

// The parameters of an arm as one list, for the numeric Jacobian of the refit.
std::vector<double*> parameters(OracleArm& arm) {
  std::vector<double*> list;
  for (OracleLink& link : arm.links)
    for (double* value : {&link.alpha, &link.d, &link.theta, &link.r, &link.beta})
      list.push_back(value);
  return list;
}

Eigen::Matrix<double, 6, 1> difference(const KDL::Frame& from, const KDL::Frame& to) {
  const KDL::Vector turn = KDL::diff(from.M, to.M);
  Eigen::Matrix<double, 6, 1> d;
  for (int i = 0; i < 3; ++i) {
    d[i] = to.p[i] - from.p[i];
    d[i + 3] = turn[i];
  }
  return d;
}

struct Visit {
  int pose, repeat;
  Moment moment;
};

OracleArm changed(const OracleArm& arm, const HiddenEffect& effect, const Moment& moment,
                  double amplitude) {
  if (!effect || amplitude == 0) return arm;
  OracleArm unit = arm;
  effect(moment, unit);
  // Effects are small: scale what the unit effect changed.
  OracleArm scaled = arm;
  std::vector<double*> to = parameters(scaled), from = parameters(unit);
  OracleArm original = arm;
  const std::vector<double*> base = parameters(original);
  for (size_t k = 0; k < to.size(); ++k) *to[k] = *base[k] + amplitude * (*from[k] - *base[k]);
  scaled.base = KDL::addDelta(arm.base, KDL::diff(arm.base, unit.base) * amplitude);
  scaled.tool = KDL::addDelta(arm.tool, KDL::diff(arm.tool, unit.tool) * amplitude);
  scaled.scale += amplitude * (unit.scale - arm.scale);
  scaled.range += amplitude * unit.range;
  scaled.azimuth += amplitude * unit.azimuth;
  scaled.elevation += amplitude * unit.elevation;
  scaled.point = scaled.point + unit.point * amplitude;
  scaled.second_wire += amplitude * unit.second_wire;
  scaled.second_wire_share += amplitude * unit.second_wire_share;
  scaled.second_wire_drum += amplitude * unit.second_wire_drum;
  return scaled;
}

// Share of an effect that a geometric refit leaves: RMS of position, and of orientation.
std::pair<double, double> left_after_refit(const OracleArm& arm, const std::vector<Visit>& visits,
                                           const HiddenEffect& effect) {
  constexpr double kStep = 1e-6;
  const int n = static_cast<int>(visits.size());
  OracleArm moved = arm;
  const std::vector<double*> list = parameters(moved);
  const int columns = static_cast<int>(list.size()) + 12;
  Eigen::MatrixXd jacobian(6 * n, columns);
  Eigen::VectorXd signal(6 * n);
  for (int v = 0; v < n; ++v) {
    const auto& q = visits[v].moment.q;
    const KDL::Frame here = forward(arm, q);
    for (size_t k = 0; k < list.size(); ++k) {
      const double old = *list[k];
      *list[k] = old + kStep;
      jacobian.col(static_cast<int>(k)).segment<6>(6 * v) =
          difference(here, forward(moved, q)) / kStep;
      *list[k] = old;
    }
    for (int k = 0; k < 6; ++k) {
      KDL::Twist twist = KDL::Twist::Zero();
      twist[k] = kStep;
      OracleArm base = arm, tool = arm;
      base.base = KDL::addDelta(arm.base, twist);
      tool.tool = KDL::addDelta(arm.tool, twist);
      jacobian.col(columns - 12 + k).segment<6>(6 * v) = difference(here, forward(base, q)) / kStep;
      jacobian.col(columns - 6 + k).segment<6>(6 * v) = difference(here, forward(tool, q)) / kStep;
    }
    // A small share of the unit effect, so that the difference stays linear.
    constexpr double kShare = 1e-3;
    signal.segment<6>(6 * v) =
        difference(here, forward(changed(arm, effect, visits[v].moment, kShare), q)) / kShare;
  }
  Eigen::VectorXd left =
      signal - jacobian * jacobian.completeOrthogonalDecomposition().solve(signal);
  constexpr double kNothing = 1e-5;
  if (signal.norm() == 0) return {1, 1};  // it moves no pose: the effect has the size that is asked
  if (left.norm() < kNothing * signal.norm()) left = signal;
  double position = 0, orientation = 0;
  for (int v = 0; v < n; ++v) {
    position += left.segment<3>(6 * v).squaredNorm();
    orientation += left.segment<3>(6 * v + 3).squaredNorm();
  }
  return {std::sqrt(position / n), std::sqrt(orientation / n)};
}

void add_visit(std::vector<Visit>& visits, int pose, int repeat, const Moment& moment) {
  const std::array<double, 6> last =
      visits.empty() ? std::array<double, 6>{} : visits.back().moment.q;
  Visit visit{pose, repeat, moment};
  visit.moment.time_s = kSecondsPerVisit * static_cast<double>(visits.size());
  for (size_t j = 0; j < 6; ++j) {
    const double motion = visit.moment.q[j] - last[j];
    visit.moment.arrival[j] = motion >= 0 ? 1 : -1;
    const Moment before = visits.empty() ? Moment{} : visits.back().moment;
    const bool goes_on = motion * before.stroke[j] >= 0;
    visit.moment.stroke[j] = motion + (goes_on ? before.stroke[j] : 0);
    // dz = (1 - sign(dx) z) dx / kSliding along the way
    const double end = motion >= 0 ? 1 : -1;
    visit.moment.friction[j] =
        end + (before.friction[j] - end) * std::exp(-std::abs(motion) / kSliding);
  }
  visits.push_back(visit);
}

// Torques about the joints that hold a force on the measured frame: J^T w.
std::array<double, 6> force_torques(const OracleArm& arm, const Moment& moment) {
  KDL::Chain chain;
  const KDL::Joint rigid(KDL::Joint::Fixed), turning(KDL::Joint::RotZ);
  KDL::Frame before = arm.base;
  KDL::JntArray theta(6);
  for (size_t j = 0; j < 6; ++j) {
    const OracleLink& link = arm.links[j];
    OracleLink unturned = link;
    unturned.theta = unturned.r = 0;
    chain.addSegment(KDL::Segment(rigid, before * link_frame(unturned, 0)));
    chain.addSegment(KDL::Segment(turning, KDL::Frame(KDL::Vector(0, 0, link.r))));
    theta(static_cast<unsigned>(j)) = link.theta + link.sign * moment.q[j];
    before = KDL::Frame::Identity();
  }
  chain.addSegment(KDL::Segment(rigid, link_frame(arm.links[6], 0) * arm.tool));
  KDL::Jacobian jacobian(6);
  KDL::ChainJntToJacSolver(chain).JntToJac(theta, jacobian);
  std::array<double, 6> torques{};
  for (unsigned j = 0; j < 6; ++j) torques[j] = KDL::dot(jacobian.getColumn(j).vel, moment.force);
  return torques;
}

// Two days with a cold start each, every second run with a load, and in most poses a force of the
// cut.
void vary_conditions(const OracleArm& arm, std::vector<Visit>& visits, Dice& dice) {
  constexpr double kLoadKg = 150, kForceN = 1000, kAirCuts = 0.3, kWarmUpK = 8, kWarmUp = 0.3;
  std::map<int, KDL::Vector> force_of_pose;
  const double day = 0.5 * visits.back().moment.time_s;
  for (Visit& visit : visits) {
    const auto [place, is_new] = force_of_pose.try_emplace(visit.pose);
    if (is_new && dice.uniform(0, 1) > kAirCuts)
      for (int i = 0; i < 3; ++i) place->second[i] = dice.uniform(-kForceN, kForceN);
    const Moment unloaded = visit.moment;
    const double payload_kg = visit.repeat % 2 == 0 ? kLoadKg : 0;
    OracleArm loaded = arm;
    loaded.masses.push_back({6, payload_kg, arm.tool.p});
    Moment& moment = visit.moment = moment_of(loaded, unloaded.q);
    moment.arrival = unloaded.arrival;
    moment.stroke = unloaded.stroke;
    moment.friction = unloaded.friction;
    moment.time_s = unloaded.time_s;
    moment.payload_kg = payload_kg;
    moment.force = place->second;
    moment.force_torque = force_torques(arm, moment);
    moment.temperature_c += kWarmUpK * (1 - std::exp(-std::fmod(moment.time_s / day, 1) / kWarmUp));
  }
}

std::vector<Visit> plan_visits(const OracleArm& arm, int poses, int repeats, Dice& dice) {
  std::vector<std::array<double, 6>> commanded;
  while (static_cast<int>(commanded.size()) < poses) {
    std::array<double, 6> q{};
    for (int j = 0; j < 6; ++j) {
      // Within the middle of the travel, and less than half a turn of the wrist, as cells are.
      const double low = std::max(arm.links[j].min, -kPi), high = std::min(arm.links[j].max, kPi);
      q[j] = dice.uniform(0.95 * low, 0.95 * high);
    }
    if (forward(arm, q).p.z() > 0.4) commanded.push_back(q);  // above the floor
  }
  std::vector<Visit> visits;
  for (int repeat = 1; repeat <= repeats; ++repeat) {
    std::vector<int> order(static_cast<size_t>(poses));
    for (int pose = 0; pose < poses; ++pose) order[static_cast<size_t>(pose)] = pose;
    for (int i = poses - 1; i > 0; --i)
      std::swap(order[static_cast<size_t>(i)], order[static_cast<size_t>(dice.below(i + 1))]);
    for (int pose : order) {
      add_visit(visits, pose, repeat, moment_of(arm, commanded[static_cast<size_t>(pose)]));
    }
  }
  return visits;
}

OracleArm true_arm(const OracleArm& nominal, Dice& dice) {
  OracleArm arm = nominal;
  for (OracleLink& link : arm.links) {
    for (double* angle : {&link.alpha, &link.theta, &link.beta}) *angle += 3e-4 * dice.normal();
    for (double* length : {&link.d, &link.r}) *length += 4e-4 * dice.normal();
  }
  const auto twist = [&] {
    KDL::Twist t;
    for (int i = 0; i < 3; ++i) t[i] = 2e-3 * dice.normal();
    for (int i = 3; i < 6; ++i) t[i] = 1e-3 * dice.normal();
    return t;
  };
  arm.base = KDL::addDelta(arm.base, twist());
  arm.tool = KDL::addDelta(arm.tool, twist());
  for (OracleMass& mass : arm.masses) {
    const int sign = dice.below(2) ? 1 : -1;
    mass.kg *= 1 + sign * dice.uniform(0.1, 0.3);
    for (int axis : {2, 1, 0}) mass.centre[axis] += dice.uniform(-0.03, 0.03);
  }
  return arm;
}

// Position, and orientation if it is read, after ",".
void write_pose(std::ostream& out, KDL::Frame frame, const CampaignPlan& plan, Dice& dice,
                double& sum) {
  KDL::Vector noise;
  for (int i = 0; i < 3; ++i) noise[i] = 1e-3 * plan.noise_mm * dice.normal();
  sum += 1000 * noise.Norm();
  if (dice.uniform(0, 1) < plan.blunders)
    for (int i = 0; i < 3; ++i) noise[i] += 5e-3 * dice.normal();
  frame.p = frame.p + noise;
  KDL::Vector turn;
  for (int i = 0; i < 3; ++i) turn[i] = 1e-3 * plan.noise_mrad * dice.normal();
  frame.M = KDL::addDelta(frame.M, turn);
  for (int i = 0; i < 3; ++i) out << ',' << 1000 * frame.p[i];
  if (!plan.orientation) return;
  double roll, pitch, yaw;
  frame.M.GetRPY(roll, pitch, yaw);
  out << ',' << yaw / kDeg << ',' << pitch / kDeg << ',' << roll / kDeg;
}

void write_distance(std::ostream& out, const KDL::Vector& point, size_t anchor,
                    const CampaignPlan& plan, const OracleArm& now, Dice& dice, double& sum) {
  OracleAnchor from = plan.anchors[anchor];
  if (anchor == 1) from.zero += now.second_wire;
  const double share = anchor == 1 ? now.second_wire_share : 0;
  const double noise = 1e-3 * plan.noise_mm * dice.normal();
  sum += 1000 * std::abs(noise);
  double blunder = 0;
  if (dice.uniform(0, 1) < plan.blunders) blunder = 5e-3 * dice.normal();
  const KDL::Vector wire = point - from.position;
  const double length = std::sqrt(KDL::dot(wire, wire));
  if (anchor == 1) from.zero += now.second_wire_drum * std::sin(2 * M_PI * length / kDrum + 0.4);
  out << ',' << anchor + 1 << ',' << 1000 * ((1 + share) * length + from.zero + noise + blunder);
}

// The joints of a pose where they come to rest. Dice of its own: what else is drawn stays the same.
std::array<double, 6> at_rest(std::array<double, 6> q, int pose, const CampaignPlan& plan) {
  Dice dice(plan.seed * 7919u + static_cast<unsigned>(pose));
  for (double& angle : q) angle += 1e-3 * plan.rest_mrad * dice.normal();
  return q;
}

void write_csv(const std::string& path, const OracleArm& arm, const std::vector<Visit>& visits,
               const Hidden& truth, double amplitude, const CampaignPlan& plan, Dice& dice,
               double& mean_noise_mm) {
  std::ofstream out(path);
  out << "pose,repeat,t_s,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg";
  out << (!plan.anchors.empty() ? ",anchor,l_mm"
          : plan.orientation    ? ",x_mm,y_mm,z_mm,a_deg,b_deg,c_deg"
                                : ",x_mm,y_mm,z_mm");
  out << ",dir1,dir2,dir3,dir4,dir5,dir6";
  if (truth.strokes)
    out << ",stroke1_deg,stroke2_deg,stroke3_deg,stroke4_deg,stroke5_deg,stroke6_deg";
  if (truth.conditions) out << ",payload_kg,fx_n,fy_n,fz_n,temp_arm_c";
  if (plan.motor_torque) out << ",tau1_nm,tau2_nm,tau3_nm,tau4_nm,tau5_nm,tau6_nm";
  out << '\n' << std::setprecision(12);
  double sum = 0;
  const size_t rows_per_visit = std::max<size_t>(1, plan.anchors.size());
  for (const Visit& visit : visits) {
    const OracleArm now = changed(arm, truth.effect, visit.moment, amplitude);
    const KDL::Frame frame = forward(now, at_rest(visit.moment.q, visit.pose, plan));
    for (size_t row = 0; row < rows_per_visit; ++row) {
      out << visit.pose + 1 << ',' << visit.repeat << ',' << visit.moment.time_s;
      for (double q : visit.moment.q) out << ',' << q / kDeg;
      if (plan.anchors.empty())
        write_pose(out, frame, plan, dice, sum);
      else
        write_distance(out, frame.p, row, plan, now, dice, sum);
      for (int direction : visit.moment.arrival) out << ',' << direction;
      if (truth.strokes)
        for (double stroke : visit.moment.stroke) out << ',' << stroke / kDeg;
      if (truth.conditions) {
        out << ',' << visit.moment.payload_kg;
        for (int i = 0; i < 3; ++i) out << ',' << visit.moment.force[i];
        out << ',' << visit.moment.temperature_c;
      }
      if (plan.motor_torque)
        for (double torque : visit.moment.torque) out << ',' << -torque;
      out << '\n';
    }
  }
  if (!out.flush()) throw std::runtime_error("cannot write " + path);
  mean_noise_mm = sum / static_cast<double>(visits.size() * rows_per_visit);
}

std::string joint_text(int j) { return std::to_string(j + 1); }

using Law = std::function<double(const Moment&)>;

Hidden on_theta(const std::string& family, int j, const std::string& driver, const Law& law) {
  return {family, "A" + joint_text(j) + ".theta", driver,
          [j, law](const Moment& m, OracleArm& arm) {
            arm.links[static_cast<size_t>(j)].theta += law(m);
          }};
}

Hidden under_changing_conditions(Hidden hidden) {
  hidden.conditions = true;
  return hidden;
}

// The families that follow joint angles, or the way to them.
std::optional<Hidden> by_angle(const std::string& family, Dice& dice) {
  if (family == "run-out") {
    // The axis of joint 5 shifts across itself, along an ellipse in the link before it.
    const double phase = dice.uniform(0, 2 * kPi);
    return Hidden{family, "A5.d", "joint-angle 5", [phase](const Moment& m, OracleArm& arm) {
                    arm.links[4].d += 1e-5 * std::cos(m.q[4] + phase);
                    arm.links[3].r += 5e-6 * std::sin(m.q[4] + phase);
                  }};
  }
  const auto angle = [](int j) { return "joint-angle " + joint_text(j); };
  if (family == "harmonic" || family == "harmonic-2") {
    const int n = family == "harmonic" ? 1 : 2;
    const int j = dice.below(2) ? 0 : 3;
    const double phase = dice.uniform(0, 2 * kPi);
    return on_theta(family, j, angle(j), [=](const Moment& m) {
      return std::sin(n * m.q[static_cast<size_t>(j)] + phase);
    });
  }
  if (family == "ratio")
    return on_theta(family, 4, angle(4), [](const Moment& m) { return m.q[4]; });
  if (family == "coupling") {
    constexpr std::array kPairs{std::pair{4, 3}, std::pair{5, 3}, std::pair{5, 4}};
    const auto [j, by] = kPairs[static_cast<size_t>(dice.below(3))];
    const auto k = static_cast<size_t>(by);
    return on_theta(family, j, angle(by), [k](const Moment& m) { return m.q[k]; });
  }
  if (family == "wobble")
    return Hidden{family, "A5.alpha", angle(3),
                  [](const Moment& m, OracleArm& arm) { arm.links[4].alpha += std::sin(m.q[3]); }};
  if (family == "backlash") {
    const int j = dice.below(3);
    return on_theta(family, j, "arrival " + joint_text(j),
                    [j](const Moment& m) { return 0.5 * m.arrival[static_cast<size_t>(j)]; });
  }
  if (family == "friction") {
    const int j = dice.below(3);
    Hidden friction = on_theta(family, j, "stroke " + joint_text(j), [j](const Moment& m) {
      return 1e-3 * m.friction[static_cast<size_t>(j)];
    });
    friction.strokes = true;
    return friction;
  }
  if (family == "x-cycles") {
    const int j = dice.below(6);
    const double n = dice.uniform(10, 120), phase = dice.uniform(0, 2 * kPi);
    Hidden cycles = on_theta(family, j, angle(j), [=](const Moment& m) {
      return std::sin(n * m.q[static_cast<size_t>(j)] + phase);
    });
    cycles.cycles_per_turn = n;
    return cycles;
  }
  if (family == "x-sum-of-2" || family == "x-sum-of-12") {
    const int j = dice.below(3), terms = family == "x-sum-of-2" ? 2 : 12;
    std::vector<std::pair<double, double>> sines;  // per turn, phase
    for (int k = 0; k < terms; ++k) {
      const double phase = dice.uniform(0, 2 * kPi);
      sines.emplace_back(3 + 12.0 * (k + dice.uniform(0.2, 0.8)) / terms, phase);
    }
    return on_theta(family, j, angle(j), [=](const Moment& m) {
      double sum = 0;
      for (const auto& [n, phase] : sines) sum += std::sin(n * m.q[static_cast<size_t>(j)] + phase);
      return sum;
    });
  }
  if (family == "x-product")
    return on_theta(family, 2, "joint-angle 1,4",
                    [](const Moment& m) { return std::sin(m.q[0]) * std::sin(m.q[3]); });
  if (family == "x-bump")
    return on_theta(family, 4, angle(4), [](const Moment& m) {
      const double u = (m.q[4] - 40 * kDeg) / (25 * kDeg);
      return std::exp(-0.5 * u * u);
    });
  return std::nullopt;
}

// The families that follow weights and forces.
std::optional<Hidden> by_load(const std::string& family, Dice& dice) {
  if (family == "compliance" || family == "two-payloads") {
    const int j = 1 + dice.below(2);
    Hidden compliance =
        on_theta(family, j, "gravity-torque " + joint_text(j),
                 [j](const Moment& m) { return 1e-6 * m.torque[static_cast<size_t>(j)]; });
    compliance.conditions = family == "two-payloads";
    return compliance;
  }
  if (family == "two-slopes") {  // a third as stiff up to 1.5 kN m as above
    const int j = 1 + dice.below(2);
    return on_theta(family, j, "gravity-torque " + joint_text(j), [j](const Moment& m) {
      const double torque = m.torque[static_cast<size_t>(j)];
      return 1e-6 * (torque + 2 * std::clamp(torque, -1500.0, 1500.0));
    });
  }
  if (family == "play") {
    const int j = 1 + dice.below(2);
    return on_theta(family, j, "gravity-torque " + joint_text(j), [j](const Moment& m) {
      return m.torque[static_cast<size_t>(j)] > 0 ? 1e-4 : -1e-4;
    });
  }
  if (family == "tilt")
    return Hidden{family, "base", "moment", [](const Moment& m, OracleArm& arm) {
                    const KDL::Vector turn = arm.base.M * m.overturning * 1e-7;
                    arm.base = KDL::Frame(KDL::Rot(turn) * arm.base.M, arm.base.p);
                  }};
  if (family == "foot-play")  // about one axis of the foot, which rests on one side or on the other
    return Hidden{family, "base", "moment", [](const Moment& m, OracleArm& arm) {
                    const double side = m.overturning.y() > 0 ? 1 : -1;
                    arm.base = arm.base * KDL::Frame(KDL::Rot(KDL::Vector(0, 1e-4 * side, 0)));
                  }};
  if (family == "droop")  // a beam along z of the last link that bends under its own weight
    return Hidden{family, "tool", "gravity-direction", [](const Moment& m, OracleArm& arm) {
                    OracleArm bare = arm;
                    bare.tool = KDL::Frame::Identity();
                    const KDL::Vector down =
                        forward(bare, m.q).M.Inverse() * (arm.gravity / arm.gravity.Norm());
                    const KDL::Vector across(down.x(), down.y(), 0), along(0, 0, 1);
                    constexpr double kLength = 0.4;  // its tip turns by 4/3 of tip over length
                    const KDL::Vector turn = (4.0 / 3) / kLength * (along * across);
                    arm.tool.p += 1e-4 * across;
                    arm.tool.M = KDL::Rot(1e-4 * turn) * arm.tool.M;
                  }};
  if (family == "tool-play")  // gravity pulls it to one side or to the other along y
    return Hidden{family, "tool", "gravity-direction", [](const Moment& m, OracleArm& arm) {
                    OracleArm bare = arm;
                    bare.tool = KDL::Frame::Identity();
                    const double side =
                        (forward(bare, m.q).M.Inverse() * arm.gravity).y() > 0 ? 1 : -1;
                    arm.tool.p += KDL::Vector(0, 1e-4 * side, 0);
                    arm.tool.M = KDL::Rot(KDL::Vector(2e-4 * side, 0, 0)) * arm.tool.M;
                  }};
  if (family == "warm-spring")
    return under_changing_conditions(
        on_theta(family, 1, "joint-angle 2 * temperature arm", [](const Moment& m) {
          // The moment of a spring between column and arm, less by what its gas loses.
          return 1e-5 * (m.temperature_c - 20) * std::sin(m.q[1] + 0.4);
        }));
  if (family == "bending") {
    const int j = 1 + dice.below(3);
    const bool about_x = dice.below(2) == 1;
    return Hidden{family, "A" + joint_text(j) + (about_x ? ".alpha" : ".beta"), "moment",
                  [=](const Moment& m, OracleArm& arm) {
                    const KDL::Vector turn = 1e-7 * m.bending[static_cast<size_t>(j)];
                    OracleLink& link = arm.links[static_cast<size_t>(j)];
                    (about_x ? link.alpha : link.beta) += about_x ? turn.x() : turn.y();
                  }};
  }
  if (family == "cutting") {
    const int j = dice.below(3);
    return under_changing_conditions(on_theta(family, j, "force", [j](const Moment& m) {
      return 1e-6 * m.force_torque[static_cast<size_t>(j)];
    }));
  }
  if (family == "x-warm-course" || family == "x-loaded-course") {
    // A course over the joint's angle that grows as the arm warms up, or with what it carries.
    const int j = 1 + dice.below(4);
    const double phase = dice.uniform(0, 2 * kPi);
    const bool warm = family == "x-warm-course";
    return under_changing_conditions(on_theta(
        family, j, "joint-angle " + joint_text(j) + (warm ? " * temperature arm" : " * payload"),
        [=](const Moment& m) {
          return 1e-6 * (warm ? m.temperature_c - 20 : m.payload_kg) *
                 std::sin(m.q[static_cast<size_t>(j)] + phase);
        }));
  }
  if (family == "x-payload") {
    const int j = 1 + dice.below(4);
    return under_changing_conditions(
        on_theta(family, j, "payload", [](const Moment& m) { return 1e-6 * m.payload_kg; }));
  }
  return std::nullopt;
}

// Errors of the instrument, as it sees the point of a pose.
std::optional<Hidden> of_instrument(const std::string& family, Dice& dice, double duration_s) {
  const double at = dice.uniform(0.35, 0.65) * duration_s;
  const auto hide = [&](const std::string& parameter, const std::string& driver,
                        const HiddenEffect& effect) {
    return Hidden{family, "instrument." + parameter, driver, effect};
  };
  const auto ray = [](const Moment& m, const OracleArm& arm) {
    return forward(arm, m.q).p - kStation;
  };
  if (family == "instrument-offset")
    return hide("range", "position", [](const Moment&, OracleArm& arm) { arm.range += 1e-3; });
  if (family == "instrument-rezeroed") {
    Hidden step = hide("range", "time", [at](const Moment& m, OracleArm& arm) {
      if (m.time_s >= at) arm.range += 1e-3;
    });
    step.step_at_s = at;
    return step;
  }
  if (family == "instrument-refraction")
    return hide("elevation", "range", [ray](const Moment& m, OracleArm& arm) {
      arm.elevation += 1e-4 * ray(m, arm).Norm();
    });
  if (family == "instrument-index")
    return hide("elevation", "position",
                [](const Moment&, OracleArm& arm) { arm.elevation += 1e-3; });
  if (family == "instrument-circle")
    return hide("azimuth", "azimuth", [ray](const Moment& m, OracleArm& arm) {
      const KDL::Vector seen = ray(m, arm);
      arm.azimuth += 1e-3 * std::sin(2 * std::atan2(seen.y(), seen.x()) + 0.7);
    });
  if (family == "instrument-turns")
    return hide("azimuth", "time", [duration_s](const Moment& m, OracleArm& arm) {
      arm.azimuth += 1e-4 * m.time_s / duration_s;
    });
  if (family == "instrument-distortion")
    return hide("point", "place", [](const Moment& m, OracleArm& arm) {
      const KDL::Vector u = forward(arm, m.q).p - KDL::Vector(0.2, -0.1, 1.4);
      arm.point += 1e-3 * KDL::Vector(u.y() * u.z() - u.x() * u.x(), u.x() * u.z(),
                                      u.x() * u.y() - u.y() * u.y());
    });
  if (family == "wire-rezeroed" || family == "wire-drift") {
    const bool step = family == "wire-rezeroed";
    Hidden wire{family, "anchor 2.zero", "time", [=](const Moment& m, OracleArm& arm) {
                  arm.second_wire += step ? (m.time_s >= at ? 1.0 : 0.0) : m.time_s / duration_s;
                }};
    if (step) wire.step_at_s = at;
    return wire;
  }
  if (family == "wire-scale")
    return Hidden{family, "anchor 2.zero", "range",
                  [](const Moment&, OracleArm& arm) { arm.second_wire_share += 1; }};
  if (family == "wire-drum")
    return Hidden{family, "anchor 2.zero", "range",
                  [](const Moment&, OracleArm& arm) { arm.second_wire_drum += 1; }};
  if (family == "instrument-incidence")
    return hide("range", "incidence", [ray](const Moment& m, OracleArm& arm) {
      const KDL::Vector seen = ray(m, arm);
      arm.range += 1e-3 * KDL::dot(seen / seen.Norm(), forward(arm, m.q).M.UnitZ());
    });
  return std::nullopt;
}

// The families that follow the clock, or the temperature.
std::optional<Hidden> in_time(const std::string& family, Dice& dice, double duration_s) {
  if (family == "thermal" || family == "cooling") {
    const double tau = dice.uniform(0.2, 0.5) * duration_s;
    const double sign = family == "thermal" ? 1 : -1;  // of lengths, which may be below zero
    return Hidden{family, "A4.r", "time", [=](const Moment& m, OracleArm& arm) {
                    double& length = arm.links[3].r;
                    length += sign * std::copysign(1 - std::exp(-m.time_s / tau), length);
                  }};
  }
  if (family == "warm-links") {
    const double tau = dice.uniform(0.2, 0.5) * duration_s;
    return Hidden{family, "arm.scale", "time", [=](const Moment& m, OracleArm& arm) {
                    const double longer = 1 + 1e-5 * (1 - std::exp(-m.time_s / tau));
                    for (auto& link : arm.links) {
                      link.d *= longer;
                      link.r *= longer;
                    }
                  }};
  }
  if (family == "settling") {
    // A tripod whose one foot sinks: its top goes down and tips.
    const double tau = dice.uniform(0.1, 0.4) * duration_s;
    const double about = dice.uniform(0, 2 * kPi);
    return Hidden{family, "base", "time", [=](const Moment& m, OracleArm& arm) {
                    const double course = 1 - std::exp(-m.time_s / tau);
                    const KDL::Vector tip(std::cos(about), std::sin(about), 0);
                    const KDL::Frame sunk(KDL::Rot(2e-4 * course * tip),
                                          KDL::Vector(0, 0, -1e-4 * course));
                    const KDL::Frame to_station(kStation);
                    arm.base = to_station * sunk * to_station.Inverse() * arm.base;
                  }};
  }
  if (family == "crash") {
    const double at = dice.uniform(0.35, 0.65) * duration_s;
    Hidden bent{family, "A4", "time", [at](const Moment& m, OracleArm& arm) {
                  if (m.time_s < at) return;
                  arm.links[2].theta += 3e-4;
                  arm.links[2].r += 1e-4;
                  arm.links[3].alpha += 7e-4;
                  arm.links[3].beta -= 5e-4;
                  arm.links[3].d += 2e-4;
                }};
    bent.step_at_s = at;
    return bent;
  }
  if (family == "bent-upper-arm") {
    // The axes at its ends, 2 and 3, are parallel: it is shifted in all directions and turned.
    const double at = dice.uniform(0.35, 0.65) * duration_s;
    Hidden bent{family, "A3", "time", [at](const Moment& m, OracleArm& arm) {
                  if (m.time_s < at) return;
                  const double across = 7e-4;  // m
                  arm.links[1].theta += across / arm.links[2].d;
                  arm.links[2].theta -= across / arm.links[2].d + 1e-4;
                  arm.links[2].alpha += 3e-4;
                  arm.links[2].beta -= 2e-4;
                  arm.links[2].d += 3e-4;
                }};
    bent.step_at_s = at;
    return bent;
  }
  if (family == "scale-drift")
    return Hidden{family, "instrument.scale", "time",
                  [duration_s](const Moment& m, OracleArm& arm) {
                    arm.scale += 1e-5 * m.time_s / duration_s;
                  }};
  if (family == "warm-scale")
    return under_changing_conditions(
        {family, "instrument.scale", "temperature arm",
         [](const Moment& m, OracleArm& arm) { arm.scale += 1e-6 * m.temperature_c; }});
  if (family == "warm-up")
    return under_changing_conditions(
        {family, "A3.d", "temperature arm", [](const Moment& m, OracleArm& arm) {
           arm.links[2].d += std::copysign(1e-5 * m.temperature_c, arm.links[2].d);
         }});
  if (family == "other-load") {
    const double at = dice.uniform(0.35, 0.65) * duration_s;
    Hidden load{family, "A2.theta", "time * tool-weight 2", [at](const Moment& m, OracleArm& arm) {
                  if (m.time_s < at) return;
                  // The sag under 1 kg at the tool; all joints are alike.
                  OracleArm only = arm;
                  only.masses = {{6, 1.0, arm.tool.p}};
                  const Moment weight = moment_of(only, m.q);
                  for (size_t j = 0; j < 6; ++j) arm.links[j].theta += 1e-6 * weight.torque[j];
                }};
    load.step_at_s = at;
    return load;
  }
  if (family == "zero-drift") {
    const int j = 1 + dice.below(4);
    const double tau = dice.uniform(0.2, 0.5) * duration_s;
    return on_theta(family, j, "time",
                    [tau](const Moment& m) { return 1 - std::exp(-m.time_s / tau); });
  }
  if (family == "remaster") {
    const int j = 1 + dice.below(4);
    const double at = dice.uniform(0.35, 0.65) * duration_s;
    Hidden hidden =
        on_theta(family, j, "time", [at](const Moment& m) { return m.time_s >= at ? 1.0 : 0.0; });
    hidden.step_at_s = at;
    return hidden;
  }
  if (family == "drift" || family == "knock") {
    KDL::Twist way;
    for (int i = 0; i < 3; ++i) way[i] = dice.normal();
    for (int i = 3; i < 6; ++i) way[i] = 0.2 * dice.normal();
    const double at = dice.uniform(0.35, 0.65) * duration_s;
    const bool step = family == "knock";
    Hidden hidden{family, "base", "time", [=](const Moment& m, OracleArm& arm) {
                    const double size = step ? (m.time_s >= at ? 1.0 : 0.0) : m.time_s / duration_s;
                    arm.base = KDL::addDelta(arm.base, way * (1e-3 * size));
                  }};
    if (step) hidden.step_at_s = at;
    return hidden;
  }
  if (family == "reseated") {
    KDL::Vector way;
    for (int i = 0; i < 3; ++i) way[i] = 1e-3 * dice.normal();
    const double at = dice.uniform(0.35, 0.65) * duration_s;
    return Hidden{family, "tool", "time", [=](const Moment& m, OracleArm& arm) {
                    if (m.time_s >= at) arm.tool.p = arm.tool * way;
                  }};
  }
  return std::nullopt;
}

}  // namespace

OracleArm read_arm(const std::string& path) {
  const YAML::Node root = YAML::LoadFile(path);
  OracleArm arm;
  arm.base = read_frame(root["base"]);
  arm.tool = read_frame(root["tool"]);
  std::vector<std::string> names;
  for (size_t j = 0; j < 7; ++j) {
    const YAML::Node node = root["links"][j];
    names.push_back(node["name"].as<std::string>());
    const auto value = [&](const char* key) { return node[key] ? node[key].as<double>() : 0.0; };
    OracleLink& link = arm.links[j];
    link = {value("alpha_deg") * kDeg, value("d_mm") / 1000,     value("theta_deg") * kDeg,
            value("r_mm") / 1000,      value("beta_deg") * kDeg, j < 6 ? value("sign") : 0,
            value("min_deg") * kDeg,   value("max_deg") * kDeg};
  }
  for (const YAML::Node& node : root["masses"]) {
    OracleMass mass;
    const auto name = node["link"].as<std::string>();
    mass.link = static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin());
    mass.kg = node["mass_kg"].as<double>();
    const YAML::Node c = node["com_mm"];
    mass.centre = KDL::Vector(c[0].as<double>(), c[1].as<double>(), c[2].as<double>()) / 1000;
    arm.masses.push_back(mass);
  }
  return arm;
}

KDL::Frame forward(const OracleArm& arm, const std::array<double, 6>& q) {
  KDL::Frame frame = arm.base;
  for (size_t j = 0; j < 7; ++j) frame = frame * link_frame(arm.links[j], j < 6 ? q[j] : 0);
  frame = frame * arm.tool;
  return {frame.M, as_read(arm, arm.scale * frame.p)};
}

std::array<KDL::Twist, 6> slopes(const OracleArm& arm, const std::array<double, 6>& q) {
  std::array<KDL::Frame, 6> frames;
  KDL::Frame frame = arm.base;
  for (size_t j = 0; j < 6; ++j) frames[j] = frame = frame * link_frame(arm.links[j], q[j]);
  const KDL::Vector end = frame * (link_frame(arm.links[6], 0) * arm.tool.p);
  std::array<KDL::Twist, 6> slopes;
  for (size_t j = 0; j < 6; ++j) {
    const KDL::Vector axis = arm.links[j].sign * frames[j].M.UnitZ();
    slopes[j] = {axis * (end - frames[j].p), axis};
  }
  return slopes;
}

bool within_travel(const OracleArm& arm, const std::array<double, 6>& q) {
  for (size_t j = 0; j < 6; ++j) {
    const double middle = (arm.links[j].min + arm.links[j].max) / 2;
    const double half = kShareOfTravel * (arm.links[j].max - arm.links[j].min) / 2;
    if (std::abs(q[j] - middle) > half) return false;
  }
  return true;
}

std::array<double, 6> random_joints(const OracleArm& arm, Dice& dice) {
  std::array<double, 6> q;
  for (size_t j = 0; j < 6; ++j)
    q[j] = dice.uniform(kShareOfTravel * arm.links[j].min, kShareOfTravel * arm.links[j].max);
  return q;
}

Moment moment_of(const OracleArm& arm, const std::array<double, 6>& q) {
  Moment moment;
  moment.q = q;
  std::array<KDL::Frame, 7> frames;
  KDL::Frame frame = KDL::Frame::Identity();
  for (size_t j = 0; j < 7; ++j)
    frames[j] = frame = frame * link_frame(arm.links[j], j < 6 ? q[j] : 0);
  moment.overturning = KDL::Vector::Zero();
  for (const OracleMass& mass : arm.masses) {
    const KDL::Vector centre = frames[static_cast<size_t>(mass.link)] * mass.centre;
    const KDL::Vector weight = mass.kg * arm.gravity;
    moment.overturning = moment.overturning + centre * weight;
    for (size_t j = 0; j < 6; ++j)
      if (mass.link >= static_cast<int>(j)) {
        moment.torque[j] += KDL::dot(frames[j].M.UnitZ(), (centre - frames[j].p) * weight);
        const KDL::Frame end = j == 0 ? KDL::Frame::Identity() : frames[j - 1];
        moment.bending[j] = moment.bending[j] + end.M.Inverse((centre - end.p) * weight);
      }
  }
  return moment;
}

double Dice::uniform(double low, double high) {
  return low + (high - low) * (static_cast<double>(engine_()) + 0.5) / 4294967296.0;
}

double Dice::normal() {
  const double radius = std::sqrt(-2 * std::log(uniform(0, 1)));
  return radius * std::cos(2 * kPi * uniform(0, 1));
}

std::vector<std::string> families() {
  return {"null",
          "null-conditions",
          "compliance",
          "two-payloads",
          "harmonic",
          "harmonic-2",
          "ratio",
          "coupling",
          "wobble",
          "bending",
          "backlash",
          "thermal",
          "cooling",
          "warm-links",
          "settling",
          "crash",
          "run-out",
          "droop",
          "tool-play",
          "foot-play",
          "warm-spring",
          "warm-up",
          "zero-drift",
          "remaster",
          "drift",
          "knock",
          "tilt",
          "cutting",
          "reseated",
          "scale",
          "scale-drift",
          "warm-scale",
          "x-product",
          "x-bump",
          "x-payload",
          "x-cycles",
          "x-warm-course",
          "x-loaded-course",
          "friction",
          "play",
          "two-slopes",
          "other-load",
          "instrument-offset",
          "instrument-rezeroed",
          "instrument-refraction",
          "instrument-index",
          "instrument-circle",
          "instrument-turns",
          "instrument-incidence",
          "instrument-distortion",
          "wire-rezeroed",
          "wire-drift",
          "wire-scale",
          "wire-drum"};
}

Hidden hidden(const std::string& family, Dice& dice, double duration_s) {
  if (family == "null" || family == "null-conditions") {
    Hidden nothing{family, "", "", {}};
    nothing.conditions = family == "null-conditions";
    return nothing;
  }
  if (family == "scale")
    return {family, "instrument.scale", "position",
            [](const Moment&, OracleArm& arm) { arm.scale += 1e-5; }};
  if (const auto found = by_angle(family, dice)) return *found;
  if (const auto found = by_load(family, dice)) return *found;
  if (const auto found = in_time(family, dice, duration_s)) return *found;
  if (const auto found = of_instrument(family, dice, duration_s)) return *found;
  throw std::invalid_argument("no family " + family);
}

Written write_campaign(const OracleArm& nominal, const std::string& family, double size_mm,
                       const CampaignPlan& plan, const std::string& directory) {
  Dice dice(plan.seed);
  OracleArm arm = true_arm(nominal, dice);
  if (plan.known_masses) arm.masses = nominal.masses;
  std::vector<Visit> visits = plan_visits(arm, 2 * plan.poses, plan.repeats, dice);
  Written written;
  written.truth = hidden(family, dice, visits.back().moment.time_s);
  if (written.truth.conditions) vary_conditions(arm, visits, dice);
  if (written.truth.effect) {
    const auto [position, orientation] = left_after_refit(arm, visits, written.truth.effect);
    const bool moves_points = position > 0.2 * orientation;
    written.amplitude = moves_points ? 1e-3 * size_mm / position : 1e-3 * size_mm / orientation;
  }
  // Every second pose takes no part; its visits stand among the others in time.
  std::vector<Visit> train, test;
  for (const Visit& visit : visits) (visit.pose % 2 == 0 ? train : test).push_back(visit);
  double unused = 0;
  CampaignPlan clean = plan;
  clean.blunders = 0;
  write_csv(directory + "/train.csv", arm, train, written.truth, written.amplitude, plan, dice,
            unused);
  write_csv(directory + "/test.csv", arm, test, written.truth, written.amplitude, clean, dice,
            written.floor_mean_mm);
  return written;
}

void write_visits(const OracleArm& nominal, const HiddenEffect& effect,
                  const std::vector<std::array<double, 6>>& commanded, const CampaignPlan& plan,
                  const std::string& path) {
  Dice dice(plan.seed);
  OracleArm arm = true_arm(nominal, dice);
  if (plan.known_masses) arm.masses = nominal.masses;
  std::vector<Visit> visits;
  for (const auto& q : commanded)
    add_visit(visits, static_cast<int>(visits.size()), 1, moment_of(arm, q));
  double unused = 0;
  write_csv(path, arm, visits, {"", "", "", effect}, 1, plan, dice, unused);
}

}  // namespace armtrue_oracle
