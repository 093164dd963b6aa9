#include "armtrue/compensation/compensation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include "armtrue/effects/arrival.h"
#include "armtrue/kinematics/inverse.h"
#include "armtrue/kinematics/units.h"
#include "compensation/branch.h"
#include "compensation/coverage.h"
#include "compensation/joint_correction.h"
#include "compensation/posture_search.h"
#include "compensation/program_arm.h"

namespace armtrue {
namespace {

constexpr double kWholeTurn = 2 * std::numbers::pi;
constexpr int kMostTries = 20;         // for the motion to be that of the command
constexpr double kSameStroke = 1e-12;  // [rad]

bool follows_motion(const Effect& effect) {
  return effect.driver.involves(DriverKind::arrival) || effect.driver.involves(DriverKind::stroke);
}

bool follows_motion(const Robot& robot) {
  for (const Effect& effect : robot.effects)
    if (follows_motion(effect)) return true;
  return false;
}

bool changes_turn(const JointVector& a, const JointVector& b) {
  for (int j = 0; j < kJoints; ++j)
    if ((a[j] < 0) != (b[j] < 0)) return true;
  return false;
}

// What the effects follow must be stated; only the motion of the joints follows from the sequence,
// unless its directions are stated: then so must be the strokes.
void require_context(const Robot& robot, const Campaign& visits, bool tool_is_measured) {
  for (const Effect& effect : robot.effects) {
    const bool from_sequence = follows_motion(effect) && visits.arrival.empty();
    if (moves_program(effect, tool_is_measured) && !from_sequence &&
        !effect.driver.involves(DriverKind::motor_torque))
      require_drivers(visits, effect);
  }
}

// Both models with one tool.
struct Arms {
  Arms(const Robot& of_identified, const Robot& of_controller, const ProgramSetUp& set_up,
       const CompensationOptions& options, const std::vector<std::string>& temperature_names)
      : base(set_up.base),
        identified(of_identified, options, set_up.tool, temperature_names),
        controller(of_controller, options, set_up.tool, temperature_names) {}

  Pose base;
  ProgramArm identified, controller;
};

std::vector<ProgramSetUp> set_ups_of(const Program& program, const CompensationOptions& options) {
  if (program.set_ups.empty()) return {{options.base, options.tool}};
  return program.set_ups;
}

// Goes through the rows of one program.
class Compensation {
 public:
  Compensation(const Robot& identified, const Robot& controller, const Program& program,
               const CompensationOptions& options)
      : program_(program),
        options_(options),
        visits_(program.visits),
        states_arrival_(!visits_.arrival.empty()),
        states_stroke_(!visits_.stroke.empty()) {
    for (const ProgramSetUp& set_up : set_ups_of(program, options))
      arms_.emplace_back(identified, controller, set_up, options, visits_.temperature_names);
    motion_matters_ =
        follows_motion(arms_[0].identified.robot()) || follows_motion(arms_[0].controller.robot());
    for (size_t row = 0; row < visits_.force_n.size(); ++row)
      visits_.force_n[row] = arms(row).base.rotation * visits_.force_n[row];
    visits_.arrival.resize(visits_.q.size(), Direction{});
    visits_.stroke.resize(visits_.q.size(), JointVector::Zero());
  }

  std::vector<CorrectedTarget> run(const Robot& identified) {
    for (int row = 0; row < program_.rows(); ++row) targets_.push_back(target_at(row));
    for (int row = 0; row < program_.rows(); ++row)
      visits_.q[static_cast<size_t>(row)] = targets_[static_cast<size_t>(row)].programmed;
    if (identified.uncertainty)
      for (size_t k = 0; k < arms_.size(); ++k) cover_rows_of(k, identified);
    for (CorrectedTarget& target : targets_) {
      if (target.is_corrected && changes_turn(target.programmed, target.q))
        target.notes.push_back(CommandNote::turn);
      std::ranges::sort(target.notes);
    }
    return std::move(targets_);
  }

 private:
  const Arms& arms(size_t row) const {
    return arms_[program_.set_up.empty() ? 0 : static_cast<size_t>(program_.set_up[row])];
  }

  CorrectedTarget target_at(int row) {
    arms_now_ = &arms(static_cast<size_t>(row));
    Context context = visits_.context(row);
    CorrectedTarget target;
    target.programmed = programmed_at(row, context);
    target.q = target.programmed;
    arrive(context, target.q);
    context.q = target.programmed;
    const Pose intended = program_.is_cartesian(static_cast<size_t>(row))
                              ? arms_now_->base * program_.poses[static_cast<size_t>(row)]
                              : controller().pose(context);
    settle(target, context, intended);
    (arrival_ ? *arrival_ : arrival_.emplace(target.q)).go_to(target.q);
    visits_.arrival[static_cast<size_t>(row)] = context.arrival;
    visits_.stroke[static_cast<size_t>(row)] = context.stroke;
    finish(target, context, intended);
    return target;
  }

  const ProgramArm& arm() const { return arms_now_->identified; }
  const ProgramArm& controller() const { return arms_now_->controller; }

  // The arm drives from command to command: these tell its motion, not the program.
  void settle(CorrectedTarget& target, Context& context, const Pose& intended) const {
    correct(target, context, intended);
    if (!motion_matters_) return;
    for (int k = 0; k < kMostTries; ++k) {
      const Context assumed = context;
      arrive(context, target.q);
      if (context.arrival == assumed.arrival &&
          (context.stroke - assumed.stroke).cwiseAbs().maxCoeff() < kSameStroke)
        return;
      correct(target, context, intended);
    }
    target.notes.push_back(CommandNote::arrival);
  }

  // The motion by which the joints come to `q` from the command before.
  void arrive(Context& context, const JointVector& q) const {
    Arrival next = arrival_.value_or(Arrival(q));
    next.go_to(q);
    if (!states_arrival_) context.arrival = next.direction();
    if (!states_stroke_) context.stroke = next.stroke();
  }

  void correct(CorrectedTarget& target, const Context& context, const Pose& intended) const {
    target.notes.clear();
    target.q = target.programmed;
    target.is_corrected = false;
    Context here = context;
    here.q = target.programmed;
    target.before = difference(intended, arm().pose(here));
    const JointCorrection correction =
        correct_joints(arm(), context, intended, target.programmed, controller().chain());
    const KinematicChain& travel = controller().robot().chain;
    // The controller's own inverse kinematics is singular there too.
    const double bend = std::min(wrist_sine(arm().chain(), target.programmed),
                                 wrist_sine(controller().chain(), target.programmed));
    if (correction.is_damped || bend < std::sin(kStretchedWrist))
      target.notes.push_back(CommandNote::singular);
    if (!correction.is_reached) {
      target.notes.push_back(CommandNote::unreachable);
    } else if (joint_beyond_travel(travel, correction.q) >= 0 ||
               joint_beyond_travel(travel, target.programmed) >= 0) {
      target.notes.push_back(CommandNote::limit);
    } else if (target.before.position > options_.max_correction) {
      target.notes.push_back(CommandNote::beyond_max);
    } else {
      target.q = correction.q;
      target.is_corrected = true;
    }
  }

  // What follows from the command.
  void finish(CorrectedTarget& target, Context context, const Pose& intended) const {
    const Pose program_from_foot = inverse(arms_now_->base);
    target.intended = program_from_foot * intended;
    context.q = target.programmed;
    target.before = difference(intended, arm().pose(context));
    context.q = target.q;
    target.after = difference(intended, arm().pose(context));
    target.pose =
        target.is_corrected ? program_from_foot * controller().pose(context) : target.intended;
  }

  // Rows with the tool of one set-up.
  void cover_rows_of(size_t set_up, const Robot& identified) {
    std::vector<int> rows;
    for (int row = 0; row < program_.rows(); ++row)
      if (&arms(static_cast<size_t>(row)) == &arms_[set_up]) rows.push_back(row);
    if (rows.empty()) return;
    CompensationOptions options = options_;
    options.tool = set_ups_of(program_, options_)[set_up].tool;
    const Coverage known = coverage(identified, options, visits_.select(rows));
    for (size_t k = 0; k < rows.size(); ++k)
      cover(static_cast<size_t>(rows[k]), known.deviation[k], known.leverage[k]);
  }

  void cover(size_t row, double deviation, double leverage) {
    CorrectedTarget& target = targets_[row];
    target.deviation = deviation;
    target.leverage = leverage;
    if (leverage > 1) target.notes.push_back(CommandNote::outside_readings);
    if (deviation > target.before.position) target.notes.push_back(CommandNote::below_std);
    const bool covered = leverage <= 1 && deviation <= target.before.position;
    if (covered || options_.correct_uncovered || !target.is_corrected) return;
    target.q = target.programmed;
    target.pose = target.intended;
    target.after = target.before;
    target.is_corrected = false;
  }

  JointVector programmed_at(int row, Context context) const {
    const auto r = static_cast<size_t>(row);
    if (!program_.is_cartesian(r)) {
      check_turn(row, visits_.q[r]);
      return visits_.q[r];
    }
    if (!program_.configurations.empty() && !program_.hinted[r])
      if (const Configuration& stated = program_.configurations[r];
          stated.is_stated() && !(stated.continues && !targets_.empty()))
        return stated_at(row, context, stated);
    if (!program_.hinted[r] && targets_.empty() && !options_.start)
      throw UnreachableTarget(row,
                              "nothing says on which branch the first target lies; add columns "
                              "q1_deg to q6_deg with joint angles near it, or --start");
    const JointVector hint = program_.hinted[r] ? visits_.q[r]
                             : targets_.empty() ? *options_.start
                                                : targets_.back().programmed;
    arrive(context, hint);
    return in_turn(row, on_branch_of(row, context, hint));
  }

  // The posture that the target states.
  JointVector stated_at(int row, Context context, const Configuration& stated) const {
    const std::optional<JointVector> before =
        targets_.empty() ? options_.start : std::optional(targets_.back().programmed);
    arrive(context, before.value_or(stated.reference));
    const Pose wanted = arms_now_->base * program_.poses[static_cast<size_t>(row)];
    const PostureSearch search(controller(), context, wanted, stated, before);
    if (const auto q = search.find()) return *q;
    throw UnreachableTarget(
        row, search.is_reached()
                 ? "the controller's model reaches it, but not in the configuration that the "
                   "program states (KUKA S and T, ABB confdata, FANUC CONFIG); check the frames, "
                   "the tool and --controller"
                 : "the controller's model does not reach it; check the frames, the tool and "
                   "--controller");
  }

  JointVector on_branch_of(int row, const Context& context, const JointVector& hint) const {
    const Pose wanted = arms_now_->base * program_.poses[static_cast<size_t>(row)];
    const Branch branch = branch_of(controller().chain(), hint);
    const auto found_from = [&](const JointVector& start) {
      return joints_of_pose(controller(), context, wanted, start);
    };
    JointCorrection found = found_from(hint);
    if (found.is_reached && is_same(branch, branch_of(controller().chain(), found.q)))
      return found.q;
    // The way from the hint may lead over a singular posture: begin beside it, in a fixed order.
    bool is_reached = found.is_reached;
    for (int k = 1; k <= 60; ++k) {
      JointVector start = hint;
      for (int j = 0; j < kJoints; ++j)
        start[j] += 0.8 * (1 - 2 * std::fmod(k * std::sqrt(2.0 + j) + 0.5 * j, 1.0));
      found = found_from(start);
      is_reached |= found.is_reached;
      if (!found.is_reached || (found.q - hint).cwiseAbs().maxCoeff() > kWholeTurn) continue;
      if (is_same(branch, branch_of(controller().chain(), found.q))) return found.q;
    }
    throw UnreachableTarget(
        row, is_reached ? "the controller's model reaches it only on another branch than that of "
                          "its hint; correct q1_deg to q6_deg, or add them"
                        : "the controller's model does not reach it; check its unit and frame, "
                          "--base and --tool");
  }

  void check_turn(int row, const JointVector& q) const {
    if (program_.turns.empty()) return;
    const int turn = program_.turns[static_cast<size_t>(row)];
    for (int j = 0; j < kJoints; ++j) {
      const bool below = (turn >> j) & 1;
      if ((q[j] < 0) != below)
        throw UnreachableTarget(
            row, fmt::format("its turn t = {} says that {} stands {} zero, and it stands at {:.6g} "
                             "deg; correct t, or rename the column if it is another",
                             turn, controller().robot().chain.links[static_cast<size_t>(j)].name,
                             below ? "below" : "above", q[j] / kDegree));
    }
  }

  // The same posture with the turns that the target states.
  JointVector in_turn(int row, JointVector q) const {
    if (program_.turns.empty()) return q;
    const KinematicChain& chain = controller().robot().chain;
    for (int j = 0; j < kJoints; ++j) {
      const bool below = (program_.turns[static_cast<size_t>(row)] >> j) & 1;
      if ((q[j] < 0) == below) continue;
      q[j] += below ? -kWholeTurn : kWholeTurn;
      const Link& link = chain.links[static_cast<size_t>(j)];
      if (q[j] < link.min || q[j] > link.max || (q[j] < 0) != below)
        throw UnreachableTarget(
            row, fmt::format("its turn says that {} stands {} zero, where it cannot; correct t",
                             link.name, below ? "below" : "above"));
    }
    return q;
  }

  const Program& program_;
  const CompensationOptions& options_;
  Campaign visits_;                 // forces in the axes of R_0
  std::deque<Arms> arms_;           // models refer to their robots: they must not move
  const Arms* arms_now_ = nullptr;  // of the row
  bool motion_matters_ = false, states_arrival_, states_stroke_;
  std::optional<Arrival> arrival_;  // at the last command
  std::vector<CorrectedTarget> targets_;
};

}  // namespace

bool states_calibration(const Robot& robot) {
  return robot.uncertainty || !robot.std.empty() || !robot.effects.empty();
}

std::vector<std::string> parameters_of_station(const Robot& robot) {
  std::vector<int> identified;
  if (robot.uncertainty)
    for (const std::string& name : robot.uncertainty->parameters)
      identified.push_back(find_parameter(robot.chain, name).value_or(-1));
  else
    for (const auto& [name, deviation] : robot.std)
      identified.push_back(find_parameter(robot.chain, name).value_or(-1));
  const auto lacks = [&](int first) {
    for (int k = 0; k < 6; ++k)
      if (std::ranges::count(identified, first + k) == 0) return true;
    return false;
  };
  const bool lacks_base = lacks(kBaseParameters), lacks_tool = lacks(kToolParameters);
  constexpr int kLastJoint = kJoints - 1;
  std::vector<std::string> names;
  for (int k : identified) {
    const bool follows_base =
        k >= kLinkParameters && k < link_parameter(1, LinkParameter::alpha) && lacks_base;
    const bool follows_tool =
        (k == link_parameter(kLastJoint, LinkParameter::theta) ||
         k == link_parameter(kLastJoint, LinkParameter::r) ||
         (k >= link_parameter(kJoints, LinkParameter::alpha) && k < kToolParameters)) &&
        lacks_tool;
    if (follows_base || follows_tool) names.push_back(parameter_name(robot.chain, k));
  }
  return names;
}

Robot in_session(Robot robot, const std::string& session) {
  std::string names;
  bool differ = false;
  for (const auto& [name, of] : robot.sessions) {
    names += (names.empty() ? "" : ", ") + name;
    differ |= !of.theta.empty();
  }
  if (session.empty()) {
    if (differ)
      throw std::invalid_argument("its sessions (" + names +
                                  ") have zero offsets of their own; say with --session which of "
                                  "them hold now");
    return robot;
  }
  const auto found = robot.sessions.find(session);
  if (found == robot.sessions.end())
    throw std::invalid_argument("has no session '" + session + "'" +
                                (names.empty() ? "" : "; it has " + names));
  for (const auto& [link, theta] : found->second.theta)
    robot.chain.links[static_cast<size_t>(link)].theta = theta;
  return robot;
}

std::vector<CorrectedTarget> compensate(const Robot& identified, const Robot& controller,
                                        const Program& program,
                                        const CompensationOptions& options) {
  for (const Robot* robot : {&identified, &controller})
    require_context(*robot, program.visits, options.tool_is_measured);
  CompensationOptions own = options;
  if (options.tool_is_measured) own.tool = identified.chain.tool;
  if (!options.tool_is_measured || program.set_ups.empty())
    return Compensation(identified, controller, program, own).run(identified);
  Program with_measured_tool = program;
  for (ProgramSetUp& set_up : with_measured_tool.set_ups) set_up.tool = own.tool;
  return Compensation(identified, controller, with_measured_tool, own).run(identified);
}

}  // namespace armtrue
