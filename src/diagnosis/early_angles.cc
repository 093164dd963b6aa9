#include "diagnosis/early_angles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

// What each joint still had to go, in units of c: rows x joints.
Eigen::MatrixXd by_arrival(const Campaign& readings, Eigen::Index joints) {
  Eigen::MatrixXd signs(readings.rows(), joints);
  for (int row = 0; row < readings.rows(); ++row)
    for (Eigen::Index j = 0; j < joints; ++j) signs(row, j) = readings.arrival[row][j];
  return signs;
}

// Motions of all visits that led to the readings, some of them, by line of the file.
std::map<int, JointVector> last_motions(const Campaign& all, const Campaign& readings) {
  std::vector<int> order(all.q.size());
  std::iota(order.begin(), order.end(), 0);
  if (!all.time_s.empty())
    std::ranges::stable_sort(order, {}, [&](int row) { return all.time_s[row]; });
  const std::set<int> lines(readings.line.begin(), readings.line.end());
  std::map<int, JointVector> motions;
  std::optional<JointVector> last;
  for (size_t k = 1; k < order.size(); ++k) {
    const int before = order[k - 1], row = order[k];
    if (!all.session.empty() && all.session[row] != all.session[before])
      last.reset();
    else if (all.q[row] != all.q[before])
      last = all.q[row] - all.q[before];
    if (last && lines.contains(all.line[row])) motions[all.line[row]] = *last;
  }
  return motions;
}

Eigen::MatrixXd by_last_motion(const Campaign& readings, const Campaign& all, Eigen::Index joints) {
  const std::map<int, JointVector> motions = last_motions(all, readings);
  Eigen::MatrixXd ways = Eigen::MatrixXd::Zero(readings.rows(), joints);
  for (int row = 0; row < readings.rows(); ++row)
    if (const auto found = motions.find(readings.line[row]); found != motions.end())
      ways.row(row) = found->second.transpose();
  return ways;
}

// Joints that arrive together: at one moment before, the way left is as the whole way over its
// time, and the joint that moves most gives the time.
Eigen::MatrixXd by_speed(Eigen::MatrixXd motions) {
  for (auto motion : motions.rowwise())
    if (const double most = motion.cwiseAbs().maxCoeff(); most > 0) motion /= most;
  return motions;
}

// Sag of each joint under weights that the links beyond it carry: torques about the joint of a
// weight at x and at y of its own frame and of the next, whose masses are free.
Eigen::MatrixXd sag_columns(const FitEquations& equations, const Robot& robot,
                            const Campaign& readings) {
  constexpr double kNoTorque = 1e-9;  // m: a vertical axis has none
  const ChainEvaluator chain(robot.chain);
  const Eigen::Vector3d down = robot.gravity.normalized();
  const int joints = joint_count(robot.chain);
  std::vector<Eigen::VectorXd> columns;
  for (int joint = 0; joint < joints; ++joint)
    for (int carrier = joint; carrier < std::min(joint + 2, joints); ++carrier)
      for (const int axis : {0, 1}) {
        Eigen::VectorXd torques(readings.rows());
        for (int row = 0; row < readings.rows(); ++row) {
          const LinkFrames frames = chain.link_frames(readings.q[row]);
          const auto frame = [&](int j) -> const Eigen::Matrix3d& {
            return frames[link_of_joint(robot.chain, j)].rotation;
          };
          torques[row] = frame(joint).col(2).dot(frame(carrier).col(axis).cross(down));
        }
        if ((torques.array() - torques.mean()).abs().maxCoeff() > kNoTorque)
          columns.push_back(times_of_rows(equations.columns.col(joint), torques));
      }
  Eigen::MatrixXd all(equations.residual.size(), std::ssize(columns));
  for (size_t k = 0; k < columns.size(); ++k) all.col(k) = columns[k];
  return all;
}

// The equations with further columns among those that were fitted.
FitEquations beside(FitEquations equations, const Eigen::MatrixXd& columns) {
  constexpr double kIndependent = 1e-3;  // of the largest: weights whose torques are nearly equal
  if (columns.cols() == 0) return equations;
  Eigen::MatrixXd left = columns - equations.basis * (equations.basis.transpose() * columns);
  for (Eigen::Index k = 0; k < left.cols(); ++k)
    left.col(k) /= std::max(1e-300, columns.col(k).norm());
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(left.rows(), left.cols());
  qr.setThreshold(kIndependent);
  qr.compute(left);
  Eigen::MatrixXd basis = Eigen::MatrixXd::Identity(left.rows(), qr.rank());
  basis = product(qr.householderQ(), basis);
  Eigen::MatrixXd both(left.rows(), equations.basis.cols() + basis.cols());
  both << equations.basis, basis;
  equations.basis = both;
  equations.residual -= basis * (basis.transpose() * equations.residual);
  return equations;
}

// The equations of each joint's zero times its way to go.
Eigen::MatrixXd columns_of(const Eigen::MatrixXd& ways, const FitEquations& equations,
                           const KinematicChain& chain) {
  Eigen::MatrixXd each = equations.columns;
  for (int j = 0; j < each.cols(); ++j)
    each.col(j) = joint_link(chain, j).sign * times_of_rows(equations.columns.col(j), ways.col(j));
  return each;
}

struct Early {
  double score = 0, value = 0;  // fall of BIC; c
  long joints = 0;              // that show it
};

// Nothing if one c falls short of `rival`, the fall of BIC by a backlash of each joint.
Early explain(const Eigen::MatrixXd& each, const FitEquations& equations, double poses,
              double rival) {
  constexpr double kQuarter = 0.25, kDeviations = 3;
  const Eigen::MatrixXd common = each.rowwise().sum();
  const JointFit one = fit_beside(common, equations), own = fit_beside(each, equations);
  const double c = one.value[0];
  const double freedom = poses * equations.row_size - static_cast<double>(equations.basis.cols());
  const double score = fall_of_bic(one, equations, poses, 1);
  if (score < std::max({kClearFall, rival, fall_of_bic(own, equations, poses, 1)}) || freedom < 1)
    return {};

  // The scatter of the c_j: readings of one pose count as one.
  const Eigen::MatrixXd left = each - equations.basis * (equations.basis.transpose() * each);
  Eigen::MatrixXd gram = left.transpose() * left;
  gram.diagonal().array() += 1e-9 * gram.diagonal().maxCoeff();
  const double variance = equations.residual.squaredNorm() * (1 - own.share) / freedom;
  const Eigen::MatrixXd covariance =
      variance * Eigen::LDLT<Eigen::MatrixXd>(gram).solve(identity(gram.rows()));
  long alike = 0, unlike = 0;
  for (Eigen::Index j = 0; j < own.value.size(); ++j) {
    const double clear = kDeviations * std::sqrt(covariance(j, j));
    const double apart = std::abs(own.value[j] - c), near = kQuarter * std::abs(c);
    alike += apart < near && clear < near;
    unlike += apart > std::max(near, clear);
  }
  constexpr long kFewestJoints = 3;
  if (alike < kFewestJoints || 2 * alike <= own.value.size() || unlike > 0) return {};
  return {score, c, alike};
}

}  // namespace

std::optional<std::string> find_early_angles(const PlainFit& fit, const Campaign& all) {
  const Campaign& readings = fit.readings;
  const Robot& robot = fit.result.robot;
  const int joints = joint_count(robot.chain);
  if (readings.arrival.empty() || readings.has_touches() || robot.ground_link) return std::nullopt;
  std::vector<int> zeros;
  for (int j = 0; j < joints; ++j) {
    if (is_prismatic(joint_link(robot.chain, j))) return std::nullopt;
    zeros.push_back(zero_offset(robot.chain, j));
  }
  FitEquations equations = fit_equations(fit, zeros);
  const Eigen::MatrixXd sag = sag_columns(equations, robot, readings);
  equations = beside(std::move(equations), sag);
  const double poses = fit.poses();
  const Eigen::MatrixXd motions = by_last_motion(readings, all, joints);
  const Eigen::MatrixXd signs = columns_of(by_arrival(readings, joints), equations, robot.chain);
  const double backlash = fall_of_bic(fit_beside(signs, equations), equations, poses, 1);
  Early best;
  std::string much;
  const auto look = [&](const Eigen::MatrixXd& columns, double unit, std::string_view in_words) {
    const Early early = explain(columns, equations, poses, backlash);
    if (early.score <= best.score) return;
    best = early;
    much = fmt::format("{:.2g} {}", std::abs(early.value) / unit, in_words);
  };
  look(signs, kDegree, "deg");
  look(columns_of(motions, equations, robot.chain), 0.01, "% of their last motion");
  look(columns_of(by_speed(motions), equations, robot.chain), kDegree,
       "deg of the joint that moves most");
  if (best.score <= 0) return std::nullopt;
  return fmt::format(
      "the joint angles look as if they were not read at standstill: {} of {} joints {} the angles "
      "that are logged by {}, which no backlash does alike: read the angles when the arm stands",
      best.joints, joints, best.value > 0 ? "went on from" : "stay behind", much);
}

}  // namespace armtrue
