#include "imaging.h"

#include <Eigen/Dense>
#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

#include "photograph.h"

namespace armtrue_oracle {
namespace {

// How the vector of a rotation R changes if R is turned further by a small vector before it.
Eigen::Matrix3d slope_of_turn(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  Eigen::Matrix3d cross;
  cross << 0, -turn.z(), turn.y(), turn.z(), 0, -turn.x(), -turn.y(), turn.x(), 0;
  const double bend =
      angle < 1e-3 ? 1.0 / 12 : (1 - angle / (2 * std::tan(angle / 2))) / (angle * angle);
  return Eigen::Matrix3d::Identity() + cross / 2 + bend * cross * cross;
}

// Newton's steps from a random configuration to a pose of the measured frame.
std::optional<std::array<double, 6>> go_to(const OracleArm& arm, const KDL::Frame& goal,
                                           Dice& dice) {
  std::array<double, 6> q = random_joints(arm, dice);
  const auto miss = [&](const std::array<double, 6>& at) {
    const KDL::Twist twist = KDL::diff(forward(arm, at), goal);
    Eigen::Matrix<double, 6, 1> values;
    for (int i = 0; i < 6; ++i) values[i] = twist[i];
    return values;
  };
  for (int round = 0; round < 60; ++round) {
    const Eigen::Matrix<double, 6, 1> here = miss(q);
    if (here.norm() < 1e-9) break;
    Eigen::Matrix<double, 6, 6> slope;
    const std::array<KDL::Twist, 6> twists = slopes(arm, q);
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 6; ++i) slope(i, j) = -twists[static_cast<size_t>(j)][i];
    slope.bottomRows<3>() = slope_of_turn(here.tail<3>()) * slope.bottomRows<3>();
    Eigen::VectorXd change = -slope.completeOrthogonalDecomposition().solve(here);
    if (change.norm() > 0.5) change *= 0.5 / change.norm();
    for (size_t j = 0; j < 6; ++j) q[j] += change[static_cast<Eigen::Index>(j)];
  }
  return miss(q).norm() < 1e-6 && within_travel(arm, q) ? std::optional(q) : std::nullopt;
}

KDL::Vector corner_of(const Grid& grid, int corner) {
  return {grid.pitch * (corner % grid.columns), grid.pitch * (corner / grid.columns), 0};
}

// A view of the board from the camera.
KDL::Frame view(const Grid& grid, const ImagingPlan& plan, Dice& dice) {
  const double turn = dice.uniform(-180 * KDL::deg2rad, 180 * KDL::deg2rad);
  const KDL::Rotation tilted = KDL::Rotation::RotX(dice.uniform(-plan.tilt, plan.tilt)) *
                               KDL::Rotation::RotY(dice.uniform(-plan.tilt, plan.tilt)) *
                               KDL::Rotation::RotZ(turn);
  const double depth = dice.uniform(plan.near, plan.far);
  const KDL::Vector middle(depth * dice.uniform(-0.35, 0.35), depth * dice.uniform(-0.25, 0.25),
                           depth);
  const KDL::Vector own(grid.pitch * (grid.columns - 1) / 2, grid.pitch * (grid.rows - 1) / 2, 0);
  return {tilted, middle - tilted * own};
}

bool shows_all(const Eye& eye, const Grid& grid, const KDL::Frame& seen) {
  for (int corner = 0; corner < grid.columns * grid.rows; ++corner) {
    const KDL::Vector point = seen * corner_of(grid, corner);
    if (point.z() < 0.05) return false;
    const auto [u, v] = pixel_of(eye, point);
    if (u < 0 || v < 0 || u > eye.width - 1 || v > eye.height - 1) return false;
  }
  return true;
}

}  // namespace

std::array<double, 2> pixel_of(const Eye& eye, const KDL::Vector& point) {
  const auto& k = eye.distortion;
  const double a = point.x() / point.z(), b = point.y() / point.z();
  const double square = a * a + b * b;
  if (eye.fisheye) {
    const double r = std::sqrt(square), angle = std::atan2(r, 1.0);
    double bent = angle;
    for (int power = 0; power < 4; ++power)
      bent += k[static_cast<size_t>(power)] * std::pow(angle, 2 * power + 3);
    const double factor = r > 1e-12 ? bent / r : 1.0;
    return {eye.fx * factor * a + eye.cx, eye.fy * factor * b + eye.cy};
  }
  const double radial = 1 + k[0] * square + k[1] * std::pow(square, 2) + k[4] * std::pow(square, 3);
  const double bent_a = a * radial + 2 * k[2] * a * b + k[3] * (square + 2 * a * a);
  const double bent_b = b * radial + k[2] * (square + 2 * b * b) + 2 * k[3] * a * b;
  return {eye.fx * bent_a + eye.cx, eye.fy * bent_b + eye.cy};
}

namespace {

// The next configuration of the plan.
Sight next_sight(const OracleArm& arm, const HiddenEffect& effect, const Eye& eye, const Grid& grid,
                 const ImagingPlan& plan, Dice& dice) {
  for (;;) {
    const KDL::Frame wanted = view(grid, plan, dice);
    const KDL::Frame goal = eye.on_arm ? grid.place * wanted.Inverse() * eye.place.Inverse()
                                       : eye.place * wanted * grid.place.Inverse();
    const auto q = go_to(arm, goal, dice);
    if (!q) continue;
    OracleArm there = arm;
    if (effect) effect(moment_of(arm, *q), there);
    const KDL::Frame measured = forward(there, *q);
    const KDL::Frame seen = eye.on_arm ? (measured * eye.place).Inverse() * grid.place
                                       : eye.place.Inverse() * measured * grid.place;
    if (shows_all(eye, grid, seen)) return {*q, seen};
  }
}

}  // namespace

std::vector<Sight> sights(const OracleArm& arm, const Eye& eye, const Grid& grid,
                          const ImagingPlan& plan, Dice& dice) {
  std::vector<Sight> all;
  for (int pose = 0; pose < plan.poses; ++pose)
    all.push_back(next_sight(arm, {}, eye, grid, plan, dice));
  return all;
}

std::string images_csv(const OracleArm& arm, const HiddenEffect& effect, const Eye& eye,
                       const Grid& grid, const ImagingPlan& plan, Dice& dice) {
  std::ostringstream text;
  text.precision(12);
  text << "pose,repeat,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,camera,board,corner,u_px,v_px\n";
  const int corners = grid.columns * grid.rows;
  for (int pose = 1; pose <= plan.poses; ++pose) {
    const auto [q, seen] = next_sight(arm, effect, eye, grid, plan, dice);
    for (int repeat = 1; repeat <= plan.repeats; ++repeat) {
      std::vector<int> ids;
      for (int corner = 0; corner < corners; ++corner) ids.push_back(corner);
      for (int corner = 0; corner < corners; ++corner)
        if (dice.uniform(0, 1) < plan.wrong_ids / 2)
          std::swap(ids[static_cast<size_t>(corner)],
                    ids[static_cast<size_t>(dice.below(corners))]);
      for (int corner = 0; corner < corners; ++corner) {
        const auto [u, v] = pixel_of(eye, seen * corner_of(grid, corner));
        const double du = plan.noise_px * dice.normal(), dv = plan.noise_px * dice.normal();
        text << pose << ',' << repeat;
        for (double angle : q) text << ',' << angle / KDL::deg2rad;
        text << ',' << eye.name << ',' << grid.name << ',' << ids[static_cast<size_t>(corner)]
             << ',' << u + du << ',' << v + dv << '\n';
      }
    }
  }
  return text.str();
}

}  // namespace armtrue_oracle
