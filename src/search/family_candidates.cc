#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "armtrue/campaign/selection.h"
#include "armtrue/effects/sampling.h"
#include "linear_algebra/decompositions.h"
#include "search/candidates.h"

namespace armtrue {
namespace {

constexpr int kPosesForLoads = 256;
constexpr long kReadingsForTypical = 4096;  // tell an RMS to two digits
constexpr double kMinTorque = 1.0;          // N m, RMS: gravity does not turn such a joint
constexpr double kLeverOfWrist = 1.0 / 3;   // of the longest lever

std::vector<int> all_rows(const Campaign& campaign) {
  std::vector<int> rows(campaign.q.size());
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

// A candidate of a family alone.
struct Single {
  const Candidate& candidate;
  BoundEffect bound;
  double typical = 0;  // RMS of its values, of their norm if it has several

  DriverKind driver() const { return candidate.effect.driver.kind; }
  bool is_of_gravity() const {
    return driver() == DriverKind::gravity_torque || driver() == DriverKind::moment;
  }
};

// Over the travel of the joints where gravity drives it, over the readings otherwise. What a place
// costs is paid once for all of them.
void set_typical(std::vector<Single>& singles, const Robot& robot, const Campaign& campaign) {
  const ChainEvaluator chain(robot.chain);
  const auto set = [&](bool of_gravity, const auto& places, const auto& context_at) {
    std::vector<Single*> own;
    for (Single& single : singles)
      if (single.is_of_gravity() == of_gravity) own.push_back(&single);
    const bool needs_frames =
        std::ranges::any_of(own, [](const Single* single) { return single->bound.needs_frames(); });
    const bool needs_jacobian = std::ranges::any_of(
        own, [](const Single* single) { return single->bound.needs_jacobian(); });
    if (own.empty()) return;
    for (const auto& place : places) {
      const Context context = context_at(place);
      ArmFrames frames;
      PoseJacobian jacobian;
      if (needs_frames) frames = chain.link_frames(context.q);
      if (needs_jacobian) chain.pose(context.q, jacobian);
      for (Single* single : own) {
        Eigen::VectorXd values(single->bound.value_count());
        single->bound.values(context, &frames, &jacobian, values.data());
        single->typical += values.squaredNorm();
      }
    }
    for (Single* single : own)
      single->typical = std::sqrt(single->typical / static_cast<double>(places.size()));
  };
  set(true, sample_joint_space(robot.chain, kPosesForLoads), [&](const JointVector& q) {
    Context context = campaign.context(0);
    context.q = q;
    return context;
  });
  set(false, evenly_chosen(all_rows(campaign), kReadingsForTypical),
      [&](int row) { return campaign.context(row); });
}

// Motion of the measured frame by each joint, RMS over the travel [m per rad or per m].
std::vector<double> levers(const Robot& robot) {
  const ChainEvaluator chain(robot.chain);
  std::vector<double> squares(joint_count(robot.chain));
  for (const JointVector& q : sample_joint_space(robot.chain, kPosesForLoads)) {
    PoseJacobian jacobian;
    chain.pose(q, jacobian);
    for (size_t j = 0; j < squares.size(); ++j)
      squares[j] +=
          joint_column(robot.chain, jacobian, static_cast<int>(j)).head<3>().squaredNorm();
  }
  for (double& square : squares) square = std::sqrt(square / kPosesForLoads);
  return squares;
}

// Joint whose load drives an effect; -1: none does.
int loaded_joint(const Driver& driver) {
  if (driver.kind == DriverKind::gravity_torque || driver.kind == DriverKind::tool_weight)
    return driver.joint;
  return driver.factor == DriverKind::gravity_torque || driver.factor == DriverKind::tool_weight
             ? driver.second_joint
             : -1;
}

// Converts the typical size of what each member adds to its parameter into that of its
// coefficients. A joint is as stiff as its load demands, or the load that it passes on: its
// reference is the largest torque from it, or the joint before the last, to the tip.
void set_typical_coefficients(std::vector<Effect>& members, std::vector<double> values,
                              int joints) {
  std::vector<double> reference = values;
  for (size_t m = 0; m < members.size(); ++m)
    if (const int joint = loaded_joint(members[m].driver); joint >= 0)
      for (size_t other = 0; other < members.size(); ++other)
        if (loaded_joint(members[other].driver) >= std::min(joint, joints - 2))
          reference[m] = std::max(reference[m], values[other]);
  for (size_t m = 0; m < members.size(); ++m) members[m].family->typical /= reference[m];
}

// Whether the members of an event move what is behind them as a further one does. Six motions bend
// a link: a shift along the axis before it is another one than that along the next axis, unless
// both axes are parallel; then the turns about both are two.
bool is_moved_by(const std::vector<Effect>& members, const Candidate& further,
                 const KinematicChain& chain, const PoseJacobian& jacobian) {
  constexpr double kSame = 0.02;  // of its length: axes as parallel as they are built
  const Driver& driver = further.effect.driver;
  if (members.empty() || !further.only_together || !driver.follows_course() || driver.factor)
    return false;
  Eigen::MatrixXd columns(6, std::ssize(members) + 1);
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const Effect& effect = k < std::ssize(members) ? members[k] : further.effect;
    const std::optional<int> parameter = find_parameter(chain, effect.parameter);
    if (!parameter || *parameter >= jacobian.cols()) return false;
    columns.col(k) = jacobian.col(*parameter).normalized();
  }
  const Eigen::MatrixXd moved = columns.leftCols(std::ssize(members));
  const Eigen::VectorXd own = columns.rightCols<1>();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(moved);
  qr.setThreshold(kSame);
  return (moved * qr.solve(own) - own).norm() < kSame;
}

}  // namespace

std::vector<Candidate> family_candidates(const std::vector<Candidate>& singles, const Robot& robot,
                                         const Campaign& campaign) {
  std::vector<Candidate> families;
  std::vector<std::vector<double>> values;  // typical, of each member
  const std::vector<double> lever = levers(robot);
  // Without masses the loads have no scale. Those of a wrist are small beside those of the arm.
  const auto is_of_wrist = [&](const Driver& driver) {
    return robot.bodies.empty() && driver.kind == DriverKind::gravity_torque &&
           lever[driver.joint] < kLeverOfWrist * std::ranges::max(lever);
  };
  const auto same_family = [](const Candidate& family, const Candidate& single) {
    const Effect& first = family.effect.members.front();
    return first.family->name == single.effect.family->name &&
           first.driver.kind == single.effect.driver.kind &&
           first.driver.where == single.effect.driver.where && first.shape == single.effect.shape;
  };
  std::vector<Single> alone;
  for (const Candidate& single : singles) {
    if (!single.effect.family || is_of_wrist(single.effect.driver)) continue;
    // Nothing says how the load of a positioner compares with those of the arm.
    if (const int joint = loaded_joint(single.effect.driver);
        joint >= 0 && is_of_positioner(robot, zero_offset(robot.chain, joint)))
      continue;
    alone.push_back({single, BoundEffect(single.effect, robot, campaign.temperature_names)});
  }
  set_typical(alone, robot, campaign);
  PoseJacobian jacobian;
  ChainEvaluator(robot.chain).pose(campaign.q[0], jacobian);
  for (const auto& [single, bound, value] : alone) {
    const bool by_torque = single.effect.driver.kind == DriverKind::gravity_torque;
    if (value < (by_torque ? kMinTorque : 1e-12)) continue;
    auto family = std::ranges::find_if(
        families, [&](const Candidate& other) { return same_family(other, single); });
    if (family == families.end()) {
      family = families.insert(families.end(), single);
      family->effect.name = single.effect.family->name;
      family->effect.parameter = {Owner::several, single.effect.family->name, Parameter::kWhole};
      family->log_choices = single.log_choices;
      values.emplace_back();
    }
    if (is_moved_by(family->effect.members, single, robot.chain, jacobian)) continue;
    values[family - families.begin()].push_back(value);
    Effect& member = family->effect.members.emplace_back(single.effect);
    member.coefficients.resize(bound.coefficient_count());
    for (size_t k = 0; k < member.coefficients.size(); ++k)
      member.coefficients[k].name = bound.coefficient_names()[k];
  }
  for (size_t f = 0; f < families.size(); ++f)
    set_typical_coefficients(families[f].effect.members, values[f], joint_count(robot.chain));
  std::erase_if(families, [](const Candidate& family) { return family.effect.members.size() < 2; });
  return families;
}

}  // namespace armtrue
