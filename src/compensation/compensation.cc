#include "armtrue/compensation/compensation.h"

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/inverse.h"
#include "compensation/branch.h"
#include "compensation/coverage.h"
#include "compensation/joint_correction.h"
#include "compensation/program_arm.h"
#include "compensation/programmed_joints.h"

namespace armtrue {
namespace {

constexpr int kMostTries = 20;         // for the motion to be that of the command
constexpr double kSameStroke = 1e-12;  // [rad]

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

// Goes through the rows of one program.
class Compensation {
 public:
  Compensation(const Robot& identified, const Robot& controller, const Program& program,
               const CompensationOptions& options)
      : program_(program),
        options_(options),
        visits_(program.visits),
        arm_(identified, options, options.tool, visits_.temperature_names),
        controller_(controller, options, options.tool, visits_.temperature_names),
        motion_matters_(follows_motion(arm_.robot()) || follows_motion(controller_.robot())),
        motion_(visits_),
        programmed_(program_, options_, controller_) {
    for (Eigen::Vector3d& force : visits_.force_n) force = options.base.rotation * force;
    visits_.arrival.resize(visits_.q.size(), Direction{});
    visits_.stroke.resize(visits_.q.size(), JointVector::Zero());
  }

  std::vector<CorrectedTarget> run(const Robot& identified) {
    for (int row = 0; row < program_.rows(); ++row) targets_.push_back(target_at(row));
    for (int row = 0; row < program_.rows(); ++row)
      visits_.q[static_cast<size_t>(row)] = targets_[static_cast<size_t>(row)].programmed;
    const Coverage known = coverage(identified, options_, visits_);
    for (size_t row = 0; row < known.deviation.size(); ++row)
      cover(row, known.deviation[row], known.leverage[row]);
    for (CorrectedTarget& target : targets_) {
      if (target.is_corrected && changes_turn(target.programmed, target.q))
        target.notes.push_back(CommandNote::turn);
      std::ranges::sort(target.notes);
    }
    return std::move(targets_);
  }

 private:
  CorrectedTarget target_at(int row) {
    Context context = visits_.context(row);
    CorrectedTarget target;
    target.programmed = programmed_at(row, context);
    target.q = target.programmed;
    motion_.arrive(context, target.q);
    context.q = target.programmed;
    const Pose intended = program_.is_cartesian()
                              ? options_.base * program_.poses[static_cast<size_t>(row)]
                              : controller_.pose(context);
    settle(target, context, intended);
    motion_.go_to(target.q);
    visits_.arrival[static_cast<size_t>(row)] = context.arrival;
    visits_.stroke[static_cast<size_t>(row)] = context.stroke;
    finish(target, context, intended);
    return target;
  }

  // The arm drives from command to command: these tell its motion, not the program.
  void settle(CorrectedTarget& target, Context& context, const Pose& intended) const {
    correct(target, context, intended);
    if (!motion_matters_) return;
    for (int k = 0; k < kMostTries; ++k) {
      const Context assumed = context;
      motion_.arrive(context, target.q);
      if (context.arrival == assumed.arrival &&
          (context.stroke - assumed.stroke).cwiseAbs().maxCoeff() < kSameStroke)
        return;
      correct(target, context, intended);
    }
    target.notes.push_back(CommandNote::arrival);
  }

  void correct(CorrectedTarget& target, const Context& context, const Pose& intended) const {
    target.notes.clear();
    target.q = target.programmed;
    target.is_corrected = false;
    Context here = context;
    here.q = target.programmed;
    target.before = difference(intended, arm_.pose(here));
    const JointCorrection correction =
        correct_joints(arm_, context, intended, target.programmed, controller_.chain());
    const KinematicChain& travel = controller_.robot().chain;
    // The controller's own inverse kinematics is singular there too.
    const double bend = std::min(wrist_sine(arm_.chain(), target.programmed),
                                 wrist_sine(controller_.chain(), target.programmed));
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

  JointVector programmed_at(int row, Context context) const {
    const JointVector hint = programmed_.hint(
        row, targets_.empty() ? std::nullopt : std::optional(targets_.back().programmed));
    motion_.arrive(context, hint);
    return programmed_.at(row, context, hint);
  }

  // What follows from the command.
  void finish(CorrectedTarget& target, Context context, const Pose& intended) const {
    const Pose program_from_foot = inverse(options_.base);
    target.intended = program_from_foot * intended;
    context.q = target.programmed;
    target.before = difference(intended, arm_.pose(context));
    context.q = target.q;
    target.after = difference(intended, arm_.pose(context));
    target.pose =
        target.is_corrected ? program_from_foot * controller_.pose(context) : target.intended;
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

  const Program& program_;
  const CompensationOptions& options_;
  Campaign visits_;  // forces in the axes of R_0
  ProgramArm arm_, controller_;
  bool motion_matters_;
  CommandedMotion motion_;
  ProgrammedJoints programmed_;
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
  return Compensation(identified, controller, program, own).run(identified);
}

}  // namespace armtrue
