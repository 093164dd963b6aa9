#include "armtrue/observation/placement.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "armtrue/effects/robot_model.h"
#include "armtrue/observation/observation.h"
#include "armtrue/observation/registration.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

constexpr int kSpareEquations = 9;
constexpr int kMaxSteps = 60;
constexpr double kSmallestScale = 1e-9;  // m
constexpr double kTailFreedom = 4;       // of Student's t

// Poses of the last link in R_0 and what was measured there.
struct Links {
  std::vector<Pose> pose;
  std::vector<int> target;
  std::vector<Eigen::Vector3d> measured;
  int targets = 1;
};

Links links_of(Robot robot, const Campaign& campaign) {
  robot.effects.clear();
  robot.chain.base = robot.chain.tool = Pose{};
  const RobotModel model(robot);
  Links links;
  links.targets = campaign.targets();
  for (int row = 0; row < campaign.rows(); ++row) {
    links.pose.push_back(model.pose(campaign.context(row)));
    links.target.push_back(campaign.target.empty() ? 0 : campaign.target[row]);
    links.measured.push_back(campaign.position[row]);
  }
  return links;
}

struct State {
  Pose base;
  Eigen::Matrix3Xd targets;
};

std::vector<double> misses(const Links& links, const State& state) {
  std::vector<double> miss;
  for (size_t row = 0; row < links.pose.size(); ++row)
    miss.push_back(
        (links.measured[row] -
         state.base * (links.pose[row] * Eigen::Vector3d(state.targets.col(links.target[row]))))
            .norm());
  return miss;
}

double scale_of(const std::vector<double>& miss) {
  return std::max(kSmallestScale, median(miss) / kMedianOfNorm3);
}

double loss_of(const std::vector<double>& miss, double scale) {
  double loss = 0;
  for (double m : miss) loss += std::log1p(m * m / (kTailFreedom * scale * scale));
  return loss;
}

// Blocks of the normal equations of one target: its own, and those that it shares with the base.
struct TargetEquations {
  Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 6, 3> shared = Eigen::Matrix<double, 6, 3>::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

// Unknowns: the small turn of the base (unless it is held), its translation, the targets.
struct Equations {
  Eigen::Matrix<double, 6, 6> base = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  std::vector<TargetEquations> targets;
};

Equations equations_at(const Links& links, const State& state, double scale) {
  Equations all;
  all.targets.resize(state.targets.cols());
  Eigen::Matrix<double, 3, 6> of_base;
  for (size_t row = 0; row < links.pose.size(); ++row) {
    TargetEquations& target = all.targets[links.target[row]];
    const Eigen::Vector3d own =
        links.pose[row] * Eigen::Vector3d(state.targets.col(links.target[row]));
    const Eigen::Vector3d turned = state.base.rotation * own;
    const Eigen::Vector3d rest = links.measured[row] - state.base.translation - turned;
    const double weight = 1 / (kTailFreedom + rest.squaredNorm() / (scale * scale));
    const Eigen::Matrix3d of_target = state.base.rotation * links.pose[row].rotation;
    of_base << -cross_matrix(turned), Eigen::Matrix3d::Identity();
    all.base += weight * of_base.transpose() * of_base;
    all.gradient += weight * of_base.transpose() * rest;
    target.own += weight * of_target.transpose() * of_target;
    target.shared += weight * of_base.transpose() * of_target;
    target.gradient += weight * of_target.transpose() * rest;
  }
  return all;
}

// No equation has two targets, so each is eliminated alone.
Eigen::VectorXd step_of(Equations all, double damping, bool turns) {
  const int taken = turns ? 6 : 3;  // of the unknowns of the base, the last ones
  double most = all.base.diagonal().tail(taken).maxCoeff();
  for (const TargetEquations& target : all.targets)
    most = std::max(most, target.own.diagonal().maxCoeff());
  const auto damp = [&](auto& information) {
    information.diagonal() *= 1 + damping;
    information.diagonal().array() += 1e-9 * (1 + damping) * most;
  };
  damp(all.base);
  std::vector<Eigen::LDLT<Eigen::Matrix3d>> own;
  for (TargetEquations& target : all.targets) {
    damp(target.own);
    own.emplace_back(target.own);
    all.base -= target.shared * own.back().solve(target.shared.transpose());
    all.gradient -= target.shared * own.back().solve(target.gradient);
  }
  const Eigen::VectorXd of_all = Eigen::MatrixXd(all.base.bottomRightCorner(taken, taken))
                                     .ldlt()
                                     .solve(Eigen::VectorXd(all.gradient.tail(taken)));
  Eigen::VectorXd step(taken + 3 * std::ssize(all.targets));
  step.head(taken) = of_all;
  for (int t = 0; t < std::ssize(all.targets); ++t)
    step.segment<3>(taken + 3 * t) = own[t].solve(
        all.targets[t].gradient - all.targets[t].shared.bottomRows(taken).transpose() * of_all);
  return step;
}

void move(State& state, const Eigen::VectorXd& step, bool turns) {
  const int first = turns ? 3 : 0;
  if (turns) state.base.rotation = rotation_exp(step.head<3>()) * state.base.rotation;
  state.base.translation += step.segment<3>(first);
  state.targets +=
      Eigen::Map<const Eigen::Matrix3Xd>(step.data() + first + 3, 3, state.targets.cols());
}

// Levenberg and Marquardt's method. The scale of Student's t is estimated anew before each step.
void descend(const Links& links, State& state) {
  constexpr double kMostDamping = 1e6, kSettled = 1e-7;
  double damping = 1e-3;
  std::vector<double> before = misses(links, state);
  double scale = scale_of(before);
  Equations equations = equations_at(links, state, scale);
  for (int step = 0; step < kMaxSteps && damping < kMostDamping; ++step) {
    State next = state;
    const Eigen::VectorXd change = step_of(equations, damping, true);
    move(next, change, true);
    std::vector<double> after = misses(links, next);
    if (!(loss_of(after, scale) < loss_of(before, scale))) {
      damping = 10 * damping;
      continue;
    }
    damping = std::max(1e-9, 0.1 * damping);
    state = std::move(next);
    if (change.norm() < kSettled) return;
    before = std::move(after);
    scale = scale_of(before);
    equations = equations_at(links, state, scale);
  }
}

// The best of the starts about a rotation of the base.
State best_about(const Links& links, const State& first, double good) {
  State best = first;
  descend(links, best);
  double least = median(misses(links, best));
  constexpr size_t kStartsTaken = 6;
  std::vector<std::pair<double, State>> starts;
  for (const Eigen::Matrix3d& turn : turns_of_a_cube()) {
    if (least <= good) return best;
    State start = first;
    start.base.rotation = first.base.rotation * turn;
    for (int round = 0; round < 3; ++round)
      move(start, step_of(equations_at(links, start, scale_of(misses(links, start))), 0, false),
           false);
    starts.emplace_back(median(misses(links, start)), std::move(start));
  }
  std::ranges::stable_sort(starts, {}, &std::pair<double, State>::first);
  if (starts.size() > kStartsTaken) starts.resize(kStartsTaken);
  for (auto& [miss, start] : starts) {
    descend(links, start);
    if (const double found = median(misses(links, start)); found < least) {
      least = found;
      best = std::move(start);
    }
    if (least <= good) break;
  }
  return best;
}

double angle_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return rotation_log(a.transpose() * b).norm();
}

}  // namespace

std::vector<Eigen::Matrix3d> turns_of_a_cube() {
  std::vector<Eigen::Matrix3d> turns;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      for (double s : {1.0, -1.0})
        for (double t : {1.0, -1.0}) {
          if (a == b) continue;
          Eigen::Matrix3d& turn = turns.emplace_back();
          turn.col(0) = s * Eigen::Vector3d::Unit(a);
          turn.col(1) = t * Eigen::Vector3d::Unit(b);
          turn.col(2) = turn.col(0).cross(turn.col(1));
        }
  return turns;
}

std::optional<BaseAndTool> place_base_and_tool(const Robot& robot, const Campaign& campaign,
                                               double good) {
  if (campaign.reads_one_number() || campaign.position.empty()) return std::nullopt;
  const Links links = links_of(robot, campaign);
  if (3 * campaign.rows() < 6 + 3 * links.targets + kSpareEquations) return std::nullopt;
  State state{registered_base(robot, campaign), Eigen::Matrix3Xd(3, links.targets)};
  const std::vector<int> targets = match_targets(campaign, robot.chain);
  for (int t = 0; t < links.targets; ++t)
    state.targets.col(t) =
        robot.chain.tool * (targets.empty() ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                                            : robot.chain.targets[targets[t]].position);
  state = best_about(links, state, good);
  BaseAndTool placement{state.base, state.targets, misses(links, state), {}};
  for (int row = 0; campaign.has_orientation() && row < campaign.rows(); ++row)
    placement.turns.push_back((state.base.rotation * links.pose[row].rotation).transpose() *
                              campaign.orientation[row].toRotationMatrix());
  return placement;
}

std::pair<Eigen::Matrix3d, double> common_turn(const std::vector<Eigen::Matrix3d>& turns) {
  constexpr size_t kReferences = 9;
  const auto angles_to = [&](const Eigen::Matrix3d& reference) {
    std::vector<double> angles;
    for (const Eigen::Matrix3d& turn : turns) angles.push_back(angle_between(reference, turn));
    return angles;
  };
  Eigen::Matrix3d best = Eigen::Matrix3d::Identity();
  double least = std::numbers::pi;
  for (size_t k = 0; k < std::min(turns.size(), kReferences); ++k)
    if (const double angle = median(angles_to(turns[k])); angle < least) {
      least = angle;
      best = turns[k];
    }
  const std::vector<double> angles = angles_to(best);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int near = 0;
  for (size_t k = 0; k < turns.size(); ++k)
    if (angles[k] <= 2 * least) {
      sum += rotation_log(best.transpose() * turns[k]);
      ++near;
    }
  const Eigen::Matrix3d mean = best * rotation_exp(sum / std::max(1, near));
  const double angle = median(angles_to(mean));
  return angle < least ? std::pair(mean, angle) : std::pair(best, least);
}

Robot placed_robot(const Robot& robot, const Campaign& campaign, const BaseAndTool& placement) {
  Robot placed = robot;
  placed.chain.base = placement.base;
  const std::vector<int> targets = match_targets(campaign, robot.chain);
  const Eigen::Index count = placement.targets.cols();
  Eigen::Matrix3Xd own = Eigen::Matrix3Xd::Zero(3, count);
  for (Eigen::Index t = 0; t < count && !targets.empty(); ++t)
    own.col(t) = robot.chain.targets[targets[t]].position;
  Pose& tool = placed.chain.tool;
  constexpr Eigen::Index kTargetsThatShowATurn = 3;
  if (!placement.turns.empty())
    tool.rotation = common_turn(placement.turns).first;
  else if (count >= kTargetsThatShowATurn)
    tool.rotation = rigid_fit(own, placement.targets).rotation;
  tool.translation = (placement.targets - tool.rotation * own).rowwise().mean();
  return placed;
}

}  // namespace armtrue
