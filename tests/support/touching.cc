#include "touching.h"

#include <Eigen/Dense>
#include <cmath>
#include <optional>
#include <sstream>

namespace armtrue_oracle {
namespace {

// How far the arm is off the fixture, and how that changes with its point. A touch reads all three
// numbers of a point, and of a plane or a sphere the first.
struct Miss {
  Eigen::VectorXd values;
  Eigen::Matrix<double, Eigen::Dynamic, 3> slope;
};
Miss miss(const OracleArm& arm, const std::array<double, 6>& q, const Fixture& fixture,
          const Eigen::Vector3d& noise) {
  const KDL::Vector off = forward(arm, q).p - fixture.place;
  if (fixture.kind == Fixture::Kind::point)
    return {Eigen::Vector3d(off.x(), off.y(), off.z()) - noise, Eigen::Matrix3d::Identity()};
  const bool is_plane = fixture.kind == Fixture::Kind::plane;
  const KDL::Vector& across = is_plane ? fixture.normal : off;
  const KDL::Vector unit = across / across.Norm();
  const double distance = KDL::dot(off, unit) - (is_plane ? 0 : fixture.radius);
  return {Eigen::VectorXd::Constant(1, distance - noise[0]),
          Eigen::RowVector3d(unit.x(), unit.y(), unit.z())};
}

// From a random configuration by Newton's steps; nothing if they do not arrive.
std::optional<std::array<double, 6>> approach(const OracleArm& arm, const Fixture& fixture,
                                              const Eigen::Vector3d& noise, Dice& dice) {
  std::array<double, 6> q = random_joints(arm, dice);
  for (int round = 0; round < 50; ++round) {
    const Miss here = miss(arm, q, fixture, noise);
    if (here.values.norm() < 1e-11) return within_travel(arm, q) ? std::optional(q) : std::nullopt;
    Eigen::Matrix<double, 3, 6> of_point;
    const std::array<KDL::Twist, 6> twists = slopes(arm, q);
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 3; ++i) of_point(i, j) = twists[static_cast<size_t>(j)].vel[i];
    const Eigen::MatrixXd jacobian = here.slope * of_point;
    Eigen::VectorXd change = -jacobian.completeOrthogonalDecomposition().solve(here.values);
    if (change.norm() > 0.5) change *= 0.5 / change.norm();
    for (size_t j = 0; j < 6; ++j) q[j] += change[static_cast<Eigen::Index>(j)];
  }
  return std::nullopt;
}

std::string row_start(size_t pose, const std::array<double, 6>& q) {
  std::ostringstream text;
  text.precision(16);
  text << pose + 1;
  for (double angle : q) text << ',' << angle / KDL::deg2rad;
  return text.str();
}

}  // namespace

OracleArm with_errors(OracleArm arm, double length, double angle, int scale, Dice& dice) {
  for (size_t j = 0; j < arm.links.size(); ++j) {
    OracleLink& link = arm.links[j];
    for (double* value : {&link.alpha, &link.theta, &link.beta}) *value += angle * dice.normal();
    const double d = length * dice.normal();
    if (static_cast<int>(j) != scale) link.d += d;
    link.r += length * dice.normal();
  }
  return arm;
}

std::vector<TouchedPose> touch(const OracleArm& arm, const std::vector<Fixture>& fixtures,
                               int poses, double noise, Dice& dice) {
  std::vector<TouchedPose> all;
  while (static_cast<int>(all.size()) < poses) {
    const size_t fixture = all.size() % fixtures.size();
    Eigen::Vector3d off;
    for (int axis : {2, 1, 0}) off[axis] = noise * dice.normal();
    for (bool there = false; !there;)
      if (const auto q = approach(arm, fixtures[fixture], off, dice)) {
        all.push_back({*q, fixture});
        there = true;
      }
  }
  return all;
}

std::string touches_csv(const std::vector<TouchedPose>& poses,
                        const std::vector<Fixture>& fixtures) {
  std::string text = "pose,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,contact\n";
  for (size_t k = 0; k < poses.size(); ++k)
    text += row_start(k, poses[k].q) + "," + fixtures[poses[k].fixture].name + "\n";
  return text;
}

std::vector<LaserPose> read_laser(const OracleArm& arm, const Laser& laser,
                                  const std::vector<Fixture>& planes, int poses, double noise,
                                  Dice& dice) {
  constexpr double kNearest = 0.05, kFarthest = 0.6, kLeastCosine = 0.5;
  std::vector<LaserPose> all;
  while (static_cast<int>(all.size()) < poses) {
    const size_t number = all.size() % planes.size();
    const Fixture& plane = planes[number];
    const KDL::Vector normal = plane.normal / plane.normal.Norm();
    const std::array<double, 6> q = random_joints(arm, dice);
    const KDL::Frame tool = forward(arm, q);
    const KDL::Vector along = tool.M * laser.along / laser.along.Norm();
    const double cosine = KDL::dot(normal, along);
    const double length = KDL::dot(normal, plane.place - tool * laser.origin) / cosine;
    if (std::abs(cosine) > kLeastCosine && length > kNearest && length < kFarthest)
      all.push_back({q, number, length + noise * dice.normal()});
  }
  return all;
}

std::string laser_csv(const std::vector<LaserPose>& poses, const Laser& laser,
                      const std::vector<Fixture>& planes) {
  std::ostringstream text;
  text.precision(16);
  text << "pose,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,beam,contact,l_mm\n";
  for (size_t k = 0; k < poses.size(); ++k)
    text << row_start(k, poses[k].q) << ',' << laser.name << ',' << planes[poses[k].plane].name
         << ',' << 1000 * poses[k].length << '\n';
  return text.str();
}

namespace {

// How far along the unit direction the fixture is; negative if the ray meets it too obliquely.
double length_of_ray(const Fixture& fixture, const KDL::Vector& origin, const KDL::Vector& along) {
  constexpr double kLeastCosine = 0.5;
  const KDL::Vector away = fixture.place - origin;
  if (fixture.kind == Fixture::Kind::plane) {
    const double cosine = KDL::dot(fixture.normal, along) / fixture.normal.Norm();
    if (std::abs(cosine) < kLeastCosine) return -1;
    return KDL::dot(fixture.normal, away) / fixture.normal.Norm() / cosine;
  }
  const double middle = KDL::dot(away, along), r = fixture.radius;
  const double half = r * r - (KDL::dot(away, away) - middle * middle);
  return half < std::pow(kLeastCosine * r, 2) ? -1 : middle - std::sqrt(half);
}

}  // namespace

std::vector<ProfilePose> read_profiles(const OracleArm& arm, const KDL::Frame& sensor,
                                       const std::vector<Fixture>& fixtures, int poses, int rays,
                                       double noise, Dice& dice) {
  constexpr double kNearest = 0.08, kFarthest = 0.4, kHalfWidth = 0.3;
  const double fan = 15 * KDL::deg2rad;
  std::vector<ProfilePose> all;
  while (static_cast<int>(all.size()) < poses) {
    const size_t number = all.size() % fixtures.size();
    const Fixture& fixture = fixtures[number];
    const double spread = fixture.kind == Fixture::Kind::plane ? kHalfWidth : 0;
    // The place is brought before the sensor, which is then anywhere about it.
    Fixture goal{"", Fixture::Kind::point, fixture.place};
    for (int i = 0; i < 3; ++i) goal.place(i) += spread * dice.uniform(-1, 1);
    OracleArm to_goal = arm;
    to_goal.tool = arm.tool * sensor * KDL::Frame({0, 0, fixture.radius + dice.uniform(0.12, 0.3)});
    const auto q = approach(to_goal, goal, {0, 0, 0}, dice);
    if (!q) continue;
    const KDL::Frame place = forward(arm, *q) * sensor;
    ProfilePose pose{*q, number, {}};
    for (int k = 0; k < rays; ++k) {
      const double angle = rays == 1 ? 0 : fan * (2.0 * k / (rays - 1) - 1);
      const KDL::Vector along(0, std::sin(angle), std::cos(angle));
      const double length = length_of_ray(fixture, place.p, place.M * along);
      if (length < kNearest || length > kFarthest) break;
      pose.points.push_back({length * along.y(), length * along.z() + noise * dice.normal()});
    }
    if (static_cast<int>(pose.points.size()) == rays) all.push_back(std::move(pose));
  }
  return all;
}

std::string profiles_csv(const std::vector<ProfilePose>& poses,
                         const std::vector<Fixture>& fixtures) {
  std::ostringstream text;
  text.precision(16);
  text << "pose,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,contact,profile_y_mm,profile_z_mm\n";
  for (size_t k = 0; k < poses.size(); ++k)
    for (const auto& [y, z] : poses[k].points)
      text << row_start(k, poses[k].q) << ',' << fixtures[poses[k].fixture].name << ',' << 1000 * y
           << ',' << 1000 * z << '\n';
  return text.str();
}

std::string points_csv(const OracleArm& arm, const std::vector<TouchedPose>& poses, double noise,
                       Dice& dice) {
  std::ostringstream text;
  text.precision(12);
  text << "pose,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,x_mm,y_mm,z_mm\n";
  for (size_t k = 0; k < poses.size(); ++k) {
    text << row_start(k, poses[k].q);
    const KDL::Vector point = forward(arm, poses[k].q).p;
    for (int i = 0; i < 3; ++i) text << ',' << 1000 * (point[i] + noise * dice.normal());
    text << '\n';
  }
  return text.str();
}

}  // namespace armtrue_oracle
