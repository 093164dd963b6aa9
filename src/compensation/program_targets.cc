#include "armtrue/compensation/program_targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include "armtrue/programs/dialect.h"
#include "armtrue/text/input_error.h"
#include "compensation/program_arm.h"

namespace armtrue {
namespace {

// The frame or tool that the program names.
const Pose& frame_of(const RobotProgram& program, int index) { return program.frames[index].pose; }

Pose base_of(const RobotProgram& program, const ProgramTarget& target, const Pose& base) {
  if (target.base < 0) return base;
  const Pose& frame = frame_of(program, target.base);
  return program.dialect->facts().has_frames_in_base ? base * frame : frame;
}

// Names all frames and tools whose values Cartesian targets lack, as the options to type.
void require_frames(const RobotProgram& program) {
  struct Missing {
    std::string name, what;
    int line = 0;
  };
  std::vector<Missing> all;
  const auto add = [&](const ProgramTarget& target, int index, const char* what) {
    if (index < 0 || target.kind == TargetKind::joints) return;
    const ProgramFrame& frame = program.frames[index];
    const auto is_it = [&](const Missing& other) { return other.name == frame.name; };
    if (!frame.is_known && std::ranges::none_of(all, is_it))
      all.push_back({frame.name, what, target.line});
  };
  for (const ProgramTarget& target : program.targets) {
    add(target, target.base, "frame");
    add(target, target.tool, "tool");
  }
  if (all.empty()) return;
  std::string names = fmt::format("the {} is '{}'", all[0].what, all[0].name), options;
  for (size_t i = 1; i < all.size(); ++i)
    names += fmt::format(", in line {} the {} is '{}'", all[i].line, all[i].what, all[i].name);
  for (const Missing& missing : all)
    options += fmt::format(" --frame '{}=x,y,z,a,b,c'", missing.name);
  throw InputError(fmt::format(
      "{}:{}: {}, and the program does not say where {}; give {}:{} in mm and deg",
      program.texts[0].name, all[0].line, names, all.size() > 1 ? "these are" : "that is",
      all.size() > 1 ? "them" : "it", options));
}

// The first part of a sentence on why a move is left alone.
std::string short_reason(const std::string& why) { return why.substr(0, why.find(';')); }

// One more move.
void leave(const std::string& why, CorrectedMoves& moves) {
  ++moves.all;
  auto& reasons = moves.reasons;
  const auto known = std::ranges::find(reasons, why, &std::pair<std::string, int>::first);
  if (known == reasons.end())
    reasons.emplace_back(why, 1);
  else
    ++known->second;
}

void finish(CorrectedMoves& moves) {
  std::ranges::stable_sort(moves.reasons, std::greater(), &std::pair<std::string, int>::second);
  moves.sentence = fmt::format("{} of {} moves are corrected", moves.corrected, moves.all);
  for (size_t i = 0; i < moves.reasons.size(); ++i)
    moves.sentence += fmt::format("{}{} ({})", i == 0 ? "; left alone: " : ", ",
                                  moves.reasons[i].second, moves.reasons[i].first);
  if (moves.never_run > 0)
    moves.sentence += fmt::format("; {} more never run, as no way leads to them", moves.never_run);
  moves.sentence += '.';
}

bool states_turn(const RobotProgram& program, size_t row) {
  const ProgramTarget& target = program.targets[row];
  return target.kind == TargetKind::cartesian &&
         program.dialect->states_turn(program.points[target.point]);
}

// The external axes of a target, in a vector of all joints.
JointVector external_axes(const RobotProgram& program, const ProgramTarget& target,
                          const ProgramJoints& joints) {
  JointVector q = JointVector::Zero(joints.count());
  for (size_t i = 0; i < joints.external.size(); ++i) {
    const ProgramJoints::External& axis = joints.external[i];
    if (axis.joint < 0) continue;
    if (i >= target.external.size() || std::isnan(target.external[i]))
      throw InputError(fmt::format(
          "{}:{}: the robot file has the external axis E{}, and neither this target nor those "
          "before it state where it stands; state it in the program, or give a robot file without",
          program.texts[0].name, target.line, i + 1));
    q[axis.joint] = target.external[i] * axis.si;
  }
  return q;
}

// The numbers of the arm's axes in a target [rad], where the robot file has an axis.
JointVector arm_numbers(const RobotProgram& program, const ProgramTarget& target,
                        const ProgramJoints& joints) {
  if (target.kind == TargetKind::cartesian)
    return target.near.value_or(JointVector::Zero(kProgramAxes));
  const std::vector<ProgramNumber>& numbers = program.points[target.point].numbers;
  for (int j = 0; j < kProgramAxes; ++j)
    if (joints.arm[j] >= 0 && numbers[j].end == 0)  // it has no place in the text
      throw InputError(fmt::format(
          "{}:{}: the robot file has axis {}, and the point of this move has no angle of it; give "
          "the model of the arm that the program is for",
          program.texts[0].name, target.line, j + 1));
  return target.q;
}

// Axes of the arm that the robot file does not have, and that move. Axis 5 of a palletiser moves
// with its rods.
void warn_of_axes_of_another_arm(const RobotProgram& program, const ProgramJoints& joints,
                                 std::vector<std::string>& warnings) {
  const ProgramTarget* first = nullptr;
  for (const ProgramTarget& target : program.targets) {
    if (target.kind != TargetKind::joints) continue;
    if (!first) first = &target;
    for (int j = 0; j < kProgramAxes; ++j) {
      const bool is_moved = joints.arm[j] < 0 && j != joints.passive &&
                            std::abs(target.q[j] - first->q[j]) > kRangeSlack;
      if (!is_moved) continue;
      warnings.push_back(fmt::format(
          "{}:{}: axis {} moves, and the robot file does not have it; is the program one of "
          "another arm?",
          program.texts[0].name, target.line, j + 1));
      return;
    }
  }
}

// External axes that the robot file does not have, and that move.
void warn_of_other_axes(const RobotProgram& program, const ProgramJoints& joints,
                        std::vector<std::string>& warnings) {
  std::map<std::string, double> first;
  for (const ProgramTarget& target : program.targets) {
    std::map<std::string, double> stated = target.other_axes;
    for (size_t i = 0; i < target.external.size(); ++i)
      if (joints.external[i].joint < 0 && !std::isnan(target.external[i]))
        stated[fmt::format("E{}", i + 1)] = target.external[i];
    for (const auto& [name, value] : stated) {
      if (first.try_emplace(name, value).first->second == value) continue;
      warnings.push_back(fmt::format(
          "{}:{}: {} moves, and the robot file does not have it; if it moves the robot or the "
          "part, --base and the frames hold for one place of it only",
          program.texts[0].name, target.line, name));
      return;
    }
  }
}

// Derivatives of the numbers of the arm's axes by the pose, as ProgramCommand::by_pose.
class JointsByPose {
 public:
  JointsByPose(const Program& rows, const ProgramJoints& joints, const Robot& controller,
               const CompensationOptions& options)
      : rows_(rows),
        joints_(joints),
        flange_(controller, options, Pose{}, rows.visits.temperature_names) {}

  // `pose`: of the TCP at the joint angles `q` of a row, in the frame of the program.
  Eigen::Matrix<double, kProgramAxes, 6> at(size_t row, const JointVector& q,
                                            const Pose& pose) const {
    Context context = rows_.visits.context(static_cast<int>(row));
    context.q = q;
    JointJacobian jacobian;
    const Pose flange = flange_.pose(context, jacobian);
    const Pose& base = rows_.set_ups[rows_.set_up[row]].base;
    const Eigen::Vector3d to_tcp = (base * pose).translation - flange.translation;
    const Eigen::Matrix3d turn = base.rotation.transpose();
    for (Eigen::Index j = 0; j < jacobian.cols(); ++j) {
      const Eigen::Vector3d axis = jacobian.col(j).tail<3>();
      jacobian.col(j).head<3>() = turn * (jacobian.col(j).head<3>() + axis.cross(to_tcp));
      jacobian.col(j).tail<3>() = turn * axis;
    }
    const Eigen::MatrixXd by_pose =
        Eigen::MatrixXd(jacobian).completeOrthogonalDecomposition().pseudoInverse();
    Eigen::Matrix<double, kProgramAxes, 6> of_arm;
    for (int k = 0; k < 6; ++k)
      of_arm.col(k) = joints_.arm_of(q + by_pose.col(k)) - joints_.arm_of(q);
    return of_arm;
  }

 private:
  const Program& rows_;
  const ProgramJoints& joints_;
  const ProgramArm flange_;
};

// Whether the joints of a command leave the turns that a point states, wherever rounding of its
// numbers takes them if it is the point of a joint move. A joint that the correction takes farther
// into its range stays in it.
bool may_leave_turns(const Configuration& stated, MotionKind motion, const ProgramCommand& command,
                     const Dialect& dialect) {
  if (motion != MotionKind::joint || stated.continues || stated.is_weak)
    return !is_in_ranges(stated, command.q);
  const DialectFacts& facts = dialect.facts();
  const auto rounding = [&](size_t component) {
    return 0.5 * std::pow(10.0, -dialect.decimals(TargetKind::cartesian, component)) +
           dialect.moved_by_check(TargetKind::cartesian, component);
  };
  Eigen::Matrix<double, 6, 1> rounded;  // each angle turns about any axis
  rounded << Eigen::Vector3d::Constant(rounding(0) * facts.length),
      Eigen::Vector3d::Constant(3 * rounding(3) * facts.angle);
  const Eigen::VectorXd moved = command.by_pose->cwiseAbs() * rounded;
  for (int j = 0; j < kProgramAxes; ++j) {
    const double before = beyond(stated.low[j], stated.high[j], command.programmed[j]);
    const double now = beyond(stated.low[j], stated.high[j], command.q[j]);
    if (now > before && now + moved[j] > 0) return true;
  }
  return false;
}

}  // namespace

Program program_targets(const RobotProgram& program, const CompensationOptions& options,
                        const ProgramJoints& joints) {
  Program result;
  result.states_external = joints.has_external();
  Campaign& visits = result.visits;
  visits.source = program.texts[0].name;
  const bool is_cartesian = std::ranges::any_of(program.targets, [](const ProgramTarget& target) {
    return target.kind == TargetKind::cartesian;
  });
  require_frames(program);
  result.ways = program.ways;
  std::map<std::pair<int, int>, int> set_ups;
  for (const ProgramTarget& target : program.targets) {
    const bool is_joints = target.kind == TargetKind::joints;
    result.node.push_back(target.node);
    visits.pose.push_back(visits.rows());
    visits.pose_ids.push_back(fmt::format("line {}", target.line));
    visits.line.push_back(target.line);
    visits.q.push_back(
        joints.whole(arm_numbers(program, target, joints), external_axes(program, target, joints)));
    const ProgramSetUp set_up{
        base_of(program, target, options.base),
        target.tool < 0 ? options.tool : options.flange * frame_of(program, target.tool)};
    const auto [place, is_new] =
        set_ups.try_emplace({target.base, target.tool}, result.set_ups.size());
    if (is_new) result.set_ups.push_back(set_up);
    result.set_up.push_back(place->second);
    result.motions.push_back({target.motion, target.turning});
    if (!is_cartesian) continue;
    result.poses.push_back(target.pose);
    result.joints.push_back(is_joints);
    result.hinted.push_back(target.near.has_value());
    result.configurations.push_back(target.configuration);
  }
  return result;
}

ProgramCommands program_commands(const RobotProgram& program, const Program& rows,
                                 std::vector<CorrectedTarget>& targets, const ProgramJoints& joints,
                                 const Robot& controller, const CompensationOptions& options) {
  ProgramCommands commands;
  warn_of_other_axes(program, joints, commands.warnings);
  warn_of_axes_of_another_arm(program, joints, commands.warnings);
  const DialectFacts& facts = program.dialect->facts();
  if (program.own_model_line > 0)
    commands.warnings.push_back(
        fmt::format("{}:{}: {}: where absolute accuracy is active, the controller runs the "
                    "model that {} measured, and that is --controller",
                    program.texts[program.own_model_text].name, program.own_model_line,
                    facts.own_model, facts.maker));
  const JointsByPose by_pose(rows, joints, controller, options);
  for (size_t row = 0; row < targets.size(); ++row) {
    CorrectedTarget& target = targets[row];
    const ProgramTarget& of_program = program.targets[row];
    if (!states_turn(program, row)) std::erase(target.notes, CommandNote::turn);
    ProgramCommand command{target.is_corrected,
                           joints.arm_of(target.programmed, of_program.q),
                           joints.arm_of(target.q, of_program.q),
                           target.pose,
                           joints.external_numbers(target.q, of_program.external),
                           {}};
    if (target.is_corrected && of_program.kind == TargetKind::cartesian &&
        of_program.configuration.is_stated())
      command.by_pose = by_pose.at(row, target.q, target.pose);
    if (!facts.fixed_turns.empty() && command.by_pose &&
        may_leave_turns(of_program.configuration, of_program.motion, command, *program.dialect)) {
      target.is_corrected = false;
      target.q = target.programmed;
      target.pose = target.intended;
      target.after = target.before;
      command = {false,
                 command.programmed,
                 command.programmed,
                 target.pose,
                 joints.external_numbers(target.q, of_program.external),
                 {}};
      commands.warnings.push_back(
          fmt::format("{}:{}: left as programmed: the correction would change the turn of a joint, "
                      "which {} states; teach the point with another turn",
                      program.texts[0].name, of_program.line, facts.fixed_turns));
    }
    commands.list.push_back(std::move(command));
  }
  return commands;
}

CorrectedMoves moves_left_alone(const std::vector<std::string>& why) {
  CorrectedMoves moves;
  for (const std::string& of_move : why) leave(short_reason(of_move), moves);
  finish(moves);
  return moves;
}

CorrectedMoves moves_left_alone(const RobotProgram& program, const std::string& why) {
  CorrectedMoves moves = moves_left_alone(program.why_left_alone);
  moves.never_run = program.never_run;
  for (const ProgramTarget& target : program.targets)
    if (target.motion != MotionKind::via && !target.never_runs) leave(why, moves);
  finish(moves);
  return moves;
}

CorrectedMoves corrected_moves(const RobotProgram& program,
                               const std::vector<CorrectedTarget>& targets) {
  CorrectedMoves moves = moves_left_alone(program.why_left_alone);
  moves.never_run = program.never_run;
  std::string why;  // the move, with the auxiliary point of an arc
  for (size_t k = 0; k < targets.size(); ++k) {
    if (program.targets[k].never_runs) {
      moves.never_run += program.targets[k].motion != MotionKind::via;
      continue;
    }
    if (!targets[k].is_corrected)
      why = targets[k].notes.empty() ? "another turn" : to_string(targets[k].notes.front());
    if (program.targets[k].motion == MotionKind::via) continue;
    if (why.empty()) {
      ++moves.all;
      ++moves.corrected;
    } else {
      leave(why, moves);
    }
    why.clear();
  }
  finish(moves);
  return moves;
}

}  // namespace armtrue
