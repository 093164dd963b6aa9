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
        zeros_.push_back(zero_offset(robot_.chain, joint));
      }
    const ParameterLayout layout = layout_of(robot_.chain);
    std::vector<int> parameters;
    for (int k = kFirstLinkParameter; k < layout.tool; ++k) parameters.push_back(k);
    equations_ = fit_equations(fit, parameters);
  }

  bool by_masses() const { return !robot_.bodies.empty(); }
  const FitEquations& equations() const { return equations_; }

  // With gravity along this unit vector.
  Sag along(const Vector3d& direction) const {
    const Eigen::MatrixXd columns = columns_along(direction);
    return best_of(columns, columns.cols());
  }

  // The largest share of the squared residual that gravity along any one vector can explain:
  // torques are linear in gravity, so those along three axes together explain no less.
  double most_of_any() const {
    Eigen::MatrixXd columns(equations_.residual.size(), 0);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::MatrixXd own = columns_along(Vector3d::Unit(axis));
      columns.conservativeResize(Eigen::NoChange, columns.cols() + own.cols());
      columns.rightCols(own.cols()) = own;
    }
    return fit_beside(columns, equations_).share;
  }

  // The largest fall of BIC by gravity along this unit vector, by harmonics of the angle of one
  // joint on a parameter of its link or the next one, and by both.
  double best_rival(const Vector3d& direction) const {
    const Eigen::MatrixXd sags = columns_along(direction);
    double best = std::max(0.0, best_of(sags, sags.cols()).score);
    for (const int joint : joints_) {
      const int first = link_of_joint(robot_.chain, joint);
      const int last = std::min(first + 1, link_count(robot_.chain) - 1);
      const Eigen::MatrixXd all = harmonics_of(joint);
      for (int k = link_parameter(first, LinkParameter::alpha);
           k <= link_parameter(last, LinkParameter::beta); ++k)
        for (const int harmonics : {1, 2}) {
          Eigen::MatrixXd columns(equations_.residual.size(), 0);
          append(columns, k, all.leftCols(2 * harmonics));
          best = std::max(best, best_of(columns, 0).score);
          Eigen::MatrixXd both(sags.rows(), sags.cols() + columns.cols());
          both << sags, columns;
          best = std::max(best, best_of(std::move(both), sags.cols()).score);
        }
    }
    return best;
  }

 private:
  Eigen::MatrixXd columns_along(const Vector3d& direction) const {
    Robot robot = robot_;
    robot.gravity = direction * robot_.gravity.norm();
    Eigen::MatrixXd columns(equations_.residual.size(), 0);
    for (const int zero : zeros_) {
      const GravityLoad load(robot, zero);
      Eigen::MatrixXd values(fit_.readings.rows(), load.value_count());
      std::vector<double> of_row(static_cast<size_t>(load.value_count()));
      for (int row = 0; row < fit_.readings.rows(); ++row) {
        load.values(fit_.readings.context(row), frames_[static_cast<size_t>(row)], of_row.data());
        for (size_t i = 0; i < of_row.size(); ++i)
          values(row, static_cast<Eigen::Index>(i)) = of_row[i];
      }
      append(columns, zero, values);
    }
    return columns;
  }

  void append(Eigen::MatrixXd& columns, int parameter, const Eigen::MatrixXd& values) const {
    for (const auto& value : values.colwise()) {
      if ((value.array() - value.mean()).matrix().norm() < 1e-9 * robot_.gravity.norm()) continue;
      columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
      columns.rightCols<1>() =
          times_of_rows(equations_.columns.col(parameter - kFirstLinkParameter), value);
    }
  }

  Eigen::MatrixXd harmonics_of(int joint) const {
    Eigen::MatrixXd values(fit_.readings.rows(), 4);
    for (int row = 0; row < fit_.readings.rows(); ++row) {
      const double q = fit_.readings.q[row][joint];
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
  std::vector<int> joints_, zeros_;
  FitEquations equations_;
};

}  // namespace

std::optional<Suspicion> find_direction_of_gravity(const PlainFit& fit) {
  constexpr int kDirections = 100;  // some 20 deg apart
  constexpr double kShareThatMatters = 0.5, kLeastAngle = 15 * kDegree;
  const Robot& robot = fit.result.robot;
  if (fit.readings.rows() == 0 || robot.gravity.norm() == 0 || robot.ground_link)
    return std::nullopt;
  const Sags sags(fit);
  if (sags.by_masses() && sags.most_of_any() < kShareThatMatters) return std::nullopt;
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
  const double score =
      found.score - sags.best_rival(of_file) - 2 * std::log(std::max(1.0, freedom));
  if (score < kClearFall) return std::nullopt;
  const Vector3d g = best * robot.gravity.norm();
  return Suspicion{
      score,
      fmt::format(
          "the sags of the joints fit gravity along ({:.2f}, {:.2f}, {:.2f}) of R_0, {:.0f} "
          "deg from that of the robot file, and explain {:.0f} % of the squared error so: is "
          "the arm on a wall, at a ceiling or tilted? Then state gravity_m_s2: [{:.2f}, "
          "{:.2f}, {:.2f}]{}",
          best.x(), best.y(), best.z(), angle / kDegree, 100 * found.share, g.x(), g.y(), g.z(),
          sags.by_masses() ? "" : " or its opposite")};
}

}  // namespace armtrue
