#include "armtrue/calibration/constants_fit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <stdexcept>

#include "armtrue/effects/arrival.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/effects/sampling.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/parameters.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

// Of the travel: thirty for each of the parameters of six axes, so that no pose counts alone.
constexpr int kVisits = 1000;
// Of a sum of squares, of columns of unit length. Along a direction below it lengths and angles
// would move by metres to bring the pose nearer by micrometres.
constexpr double kLeastShown = 1e-6;
constexpr int kMostSteps = 30;
constexpr double kSettled = 1e-12;  // of the sum of squares: less is rounding

std::vector<std::string> temperatures_of(const Robot& robot) {
  std::set<std::string> names;
  for (const Effect& effect : robot.effects)
    if (effect.driver.involves(DriverKind::temperature)) names.insert(effect.driver.where);
  std::vector<std::string> all(names.begin(), names.end());
  all.resize(std::min<size_t>(all.size(), kMaxTemperatures));
  return all;
}

struct NormalEquations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  double squares = 0;  // [m^2]
};

class Fit {
 public:
  Fit(const Robot& arm, const std::vector<int>& free, const ConstantsVisits& visits)
      : free_(free), visits_(visits.contexts) {
    const RobotModel model(arm, visits.temperature_names);
    for (const Context& visit : visits_) wanted_.push_back(model.pose(visit));
  }

  NormalEquations at(const KinematicChain& chain) const {
    const ChainEvaluator evaluator(chain);
    const Eigen::Index n = free_.size();
    NormalEquations all{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), 0};
    PoseJacobian jacobian;
    Eigen::MatrixXd rows(6, n);
    for (size_t i = 0; i < visits_.size(); ++i) {
      const Pose pose = evaluator.pose(visits_[i].q, jacobian);
      Eigen::Matrix<double, 6, 1> missing;
      missing << wanted_[i].translation - pose.translation,
          kLengthOfTurn * rotation_log(wanted_[i].rotation * pose.rotation.transpose());
      for (Eigen::Index k = 0; k < n; ++k) {
        rows.col(k) = jacobian.col(free_[k]);
        rows.col(k).tail<3>() *= kLengthOfTurn;
      }
      all.matrix.noalias() += rows.transpose() * rows;
      all.right.noalias() += rows.transpose() * missing;
      all.squares += missing.squaredNorm();
    }
    return all;
  }

  // The shortest step among those that leave the same squares.
  Eigen::VectorXd step(const NormalEquations& equations) const {
    const Eigen::VectorXd length =
        equations.matrix.diagonal().cwiseSqrt().unaryExpr([](double l) { return l > 0 ? l : 1.0; });
    const Eigen::VectorXd by_length = length.cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> of(
        Eigen::MatrixXd(by_length.asDiagonal() * equations.matrix * by_length.asDiagonal()));
    Eigen::VectorXd along =
        of.eigenvectors().transpose() * by_length.asDiagonal() * equations.right;
    for (Eigen::Index k = 0; k < along.size(); ++k)
      along[k] = of.eigenvalues()[k] > kLeastShown * of.eigenvalues().maxCoeff()
                     ? along[k] / of.eigenvalues()[k]
                     : 0;
    return by_length.asDiagonal() * of.eigenvectors() * along;
  }

  KinematicChain moved(KinematicChain chain, const Eigen::VectorXd& step) const {
    for (size_t k = 0; k < free_.size(); ++k) move_parameter(chain, free_[k], step[k]);
    return chain;
  }

  ModelDistance distance(const KinematicChain& chain) const {
    const ChainEvaluator evaluator(chain);
    ModelDistance result;
    for (size_t i = 0; i < visits_.size(); ++i) {
      const double d = (evaluator.pose(visits_[i].q).translation - wanted_[i].translation).norm();
      result.mean += d / static_cast<double>(visits_.size());
      result.max = std::max(result.max, d);
    }
    return result;
  }

 private:
  const std::vector<int>& free_;
  const std::vector<Context>& visits_;
  std::vector<Pose> wanted_;
};

bool is_measured(const Effect& effect) { return effect.driver.involves(DriverKind::motor_torque); }

}  // namespace

ConstantsVisits visits_of_travel(const Robot& robot, const Context& conditions) {
  ConstantsVisits visits{{}, temperatures_of(robot)};
  int number = 0;
  for (const JointVector& q : sample_joint_space(robot.chain, kVisits)) {
    Context& visit = visits.contexts.emplace_back(conditions);
    visit.q = q;
    // Every combination of sides occurs as often, in another order than the angles.
    const int sides = kVisits - number++;
    for (int j = 0; j < q.size(); ++j) visit.arrival[j] = (sides >> j & 1) ? 1 : -1;
  }
  return visits;
}

ConstantsVisits visits_at(const Robot& robot, const std::vector<JointVector>& q,
                          const Context& conditions) {
  ConstantsVisits visits{{}, temperatures_of(robot)};
  if (q.empty()) return visits;
  Arrival arrival(q.front());
  for (const JointVector& at : q) {
    arrival.go_to(at);
    Context& visit = visits.contexts.emplace_back(conditions);
    visit.q = at;
    visit.arrival = arrival.direction();
    visit.stroke = arrival.stroke();
  }
  return visits;
}

ConstantsFit fit_constants(const Robot& arm, const KinematicChain& from,
                           const std::vector<int>& free, const ConstantsVisits& visits) {
  const auto same_kinds = [](const Link& a, const Link& b) {
    return a.joint == b.joint && a.has_encoder == b.has_encoder && a.sign == b.sign;
  };
  if (!std::ranges::equal(arm.chain.links, from.links, same_kinds))
    throw std::invalid_argument("the two chains have other joints");
  ConstantsFit result{from, {}, {}};
  result.chain.base = arm.chain.base;
  result.chain.tool = arm.chain.tool;
  const Fit fit(arm, free, visits);
  result.before = fit.distance(result.chain);
  NormalEquations here = fit.at(result.chain);
  for (int k = 0; k < kMostSteps; ++k) {
    const KinematicChain next = fit.moved(result.chain, fit.step(here));
    NormalEquations there = fit.at(next);
    if (there.squares >= here.squares * (1 - kSettled)) break;
    result.chain = next;
    here = std::move(there);
  }
  result.after = fit.distance(result.chain);
  return result;
}

std::vector<int> link_parameters(const KinematicChain& chain) {
  std::vector<int> all(layout_of(chain).tool - kFirstLinkParameter);
  std::iota(all.begin(), all.end(), kFirstLinkParameter);
  return all;
}

std::vector<int> zero_offsets(const KinematicChain& chain) {
  std::vector<int> all;
  for (int j = 0; j < joint_count(chain); ++j) all.push_back(zero_offset(chain, j));
  return all;
}

Robot arm_of_constants(const Robot& robot) {
  Robot arm = without_station_effects(robot, false);
  std::erase_if(arm.effects, is_measured);
  return arm;
}

std::vector<std::string> not_in_constants(const Robot& robot) {
  std::vector<std::string> of_others, measured, sentences;
  for (const Effect& effect : robot.effects) {
    if (!moves_program(effect, false))
      of_others.push_back(effect.name);
    else if (is_measured(effect))
      measured.push_back(effect.name);
  }
  if (!of_others.empty())
    sentences.push_back(
        fmt::format("effects of the instrument or the measured tool are not in the constants: {}",
                    fmt::join(of_others, ", ")));
  if (!measured.empty())
    sentences.push_back(fmt::format(
        "effects of measured motor torques, which are not known at other poses, are not "
        "in the constants: {}",
        fmt::join(measured, ", ")));
  return sentences;
}

std::string conditions_in_words(const Robot& robot, const Context& conditions) {
  std::string words;
  const auto add = [&](DriverKind kind, const std::string& value) {
    if (std::ranges::any_of(robot.effects,
                            [&](const Effect& effect) { return effect.driver.involves(kind); }))
      words += ", " + value;
  };
  add(DriverKind::payload, fmt::format("{:g} kg (--payload-kg)", conditions.payload_kg));
  add(DriverKind::time, fmt::format("{:g} s (--t-s)", conditions.time_s));
  add(DriverKind::temperature,
      fmt::format("{:g} deg C (--temp-c)", conditions.temperature_c.front()));
  return words;
}

}  // namespace armtrue
