#include "diagnosis/gravity_direction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "armtrue/effects/gravity.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

using Eigen::Vector3d;

struct Sag {
  double score = 0;  // fall of BIC
  double share = 0;
  Eigen::VectorXd explained;
};

// Directions at about equal distances (Fibonacci's lattice).
std::vector<Vector3d> directions(int count) {
  std::vector<Vector3d> all;
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int k = 0; k < count; ++k) {
    const double z = 1 - (2.0 * k + 1) / count, r = std::sqrt(1 - z * z);
    all.emplace_back(r * std::cos(turn * k), r * std::sin(turn * k), z);
  }
  return all;
}

// Directions on circles about one of them.
std::vector<Vector3d> about(const Vector3d& middle, double angle) {
  constexpr int kOfCircle = 8;
  const Vector3d side = middle.unitOrthogonal(), other = middle.cross(side);
  std::vector<Vector3d> all;
  for (const double off : {angle, angle / 2})
    for (int k = 0; k < kOfCircle; ++k) {
      const double around = 2 * std::numbers::pi * k / kOfCircle;
      all.push_back(std::cos(off) * middle +
                    std::sin(off) * (std::cos(around) * side + std::sin(around) * other));
    }
  return all;
}

class Sags {
 public:
  explicit Sags(const PlainFit& fit) : fit_(fit), robot_(fit.result.robot) {
    const ChainEvaluator chain(robot_.chain);
    for (int row = 0; row < fit.readings.rows(); ++row)
      frames_.push_back(chain.link_frames(fit.readings.q[row]));
    for (int joint = 0; joint < joint_count(robot_.chain); ++joint)
      if (!is_prismatic(joint_link(robot_.chain, joint))) {
        joints_.push_back(joint);
        parameters_.push_back(zero_offset(robot_.chain, joint));
      }
    equations_ = fit_equations(fit, parameters_);
  }

  bool by_masses() const { return !robot_.bodies.empty(); }
  const FitEquations& equations() const { return equations_; }

  // With gravity along this unit vector; `harmonics`: also those of this joint, -1 for none.
  Sag along(const Vector3d& direction, int harmonics = -1) const {
    Robot robot = robot_;
    robot.gravity = direction * robot_.gravity.norm();
    Eigen::MatrixXd columns(equations_.residual.size(), 0);
    for (size_t k = 0; k < parameters_.size(); ++k) {
      const GravityLoad load(robot, parameters_[k]);
      Eigen::MatrixXd values(fit_.readings.rows(), load.value_count());
      std::vector<double> of_row(static_cast<size_t>(load.value_count()));
      for (int row = 0; row < fit_.readings.rows(); ++row) {
        load.values(fit_.readings.context(row), frames_[static_cast<size_t>(row)], of_row.data());
        for (size_t i = 0; i < of_row.size(); ++i)
          values(row, static_cast<Eigen::Index>(i)) = of_row[i];
      }
      append(columns, static_cast<Eigen::Index>(k), values);
    }
    const Eigen::Index sags = columns.cols();
    if (harmonics >= 0) append(columns, harmonics, harmonics_of(harmonics));
    return best_of(std::move(columns), sags);
  }

  int joints() const { return static_cast<int>(joints_.size()); }

 private:
  void append(Eigen::MatrixXd& columns, Eigen::Index joint, const Eigen::MatrixXd& values) const {
    for (const auto& value : values.colwise()) {
      if ((value.array() - value.mean()).matrix().norm() < 1e-9 * robot_.gravity.norm()) continue;
      columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
      columns.rightCols<1>() = times_of_rows(equations_.columns.col(joint), value);
    }
  }

  Eigen::MatrixXd harmonics_of(int number) const {
    Eigen::MatrixXd values(fit_.readings.rows(), 4);
    for (int row = 0; row < fit_.readings.rows(); ++row) {
      const double q = fit_.readings.q[row][joints_[static_cast<size_t>(number)]];
      values.row(row) << std::cos(q), std::sin(q), std::cos(2 * q), std::sin(2 * q);
    }
    return values;
  }

  // No joint gives way against its torque: of the first `sags` columns those with masses have no
  // negative value.
  Sag best_of(Eigen::MatrixXd columns, Eigen::Index sags) const {
    for (;;) {
      if (columns.cols() == 0) return {};
      const JointFit joint = fit_beside(columns, equations_);
      Eigen::Index worst = -1;
      const Eigen::VectorXd size = columns.colwise().norm();
      if (by_masses())
        for (Eigen::Index k = 0; k < sags; ++k)
          if (joint.value[k] < 0 &&
              (worst < 0 || joint.value[k] * size[k] < joint.value[worst] * size[worst]))
            worst = k;
      if (worst < 0)
        return {fall_of_bic(joint, equations_, fit_.poses(), 1), joint.share,
                columns * joint.value};
      for (Eigen::Index k = worst; k + 1 < columns.cols(); ++k) columns.col(k) = columns.col(k + 1);
      columns.conservativeResize(Eigen::NoChange, columns.cols() - 1);
      --sags;
    }
  }

  const PlainFit& fit_;
  const Robot& robot_;
  std::vector<LinkFrames> frames_;
  std::vector<int> joints_, parameters_;
  FitEquations equations_;
};

}  // namespace

std::optional<Suspicion> find_direction_of_gravity(const PlainFit& fit) {
  constexpr int kDirections = 100;  // some 20 deg apart
  constexpr double kShareThatMatters = 0.25, kLeastAngle = 15 * kDegree;
  const Robot& robot = fit.result.robot;
  if (fit.readings.rows() == 0 || robot.gravity.norm() == 0 || robot.ground_link)
    return std::nullopt;
  const Sags sags(fit);
  const Vector3d of_file = robot.gravity.normalized();
  Vector3d best = of_file;
  Sag found;
  const auto attempt = [&](const std::vector<Vector3d>& all) {
    for (const Vector3d& direction : all)
      if (Sag sag = sags.along(direction); sag.score > found.score) {
        found = std::move(sag);
        best = direction;
      }
  };
  attempt(directions(kDirections));
  for (double angle = 12 * kDegree; angle > 0.5 * kDegree; angle /= 2) attempt(about(best, angle));
  double cosine = best.dot(of_file);
  if (!sags.by_masses() && cosine < 0) {
    cosine = -cosine;
    best = -best;
  }
  const double angle = std::acos(std::min(1.0, cosine));
  if (angle < kLeastAngle || found.share < kShareThatMatters ||
      !is_of_most(found.explained, sags.equations()))
    return std::nullopt;
  const double freedom =
      fit.poses() * sags.equations().row_size - static_cast<double>(sags.equations().basis.cols());
  double rival = std::max(0.0, sags.along(of_file).score);
  for (int joint = 0; joint < sags.joints(); ++joint)
    rival = std::max(rival, sags.along(of_file, joint).score);
  const double score = found.score - rival - 2 * std::log(std::max(1.0, freedom));
  if (score < kClearFall) return std::nullopt;
  const Vector3d g = best * robot.gravity.norm();
  return Suspicion{
      score,
      fmt::format("the sags of the joints fit gravity along ({:.2g}, {:.2g}, {:.2g}) of R_0, {:.0f} "
                  "deg from that of the robot file, and explain {:.0f} % of the squared error so: is "
                  "the arm on a wall, at a ceiling or tilted? Then state gravity_m_s2: [{:.2f}, "
                  "{:.2f}, {:.2f}]{}",
                  best.x(), best.y(), best.z(), angle / kDegree, 100 * found.share, g.x(), g.y(),
                  g.z(), sags.by_masses() ? "" : " or its opposite")};
}

}  // namespace armtrue
