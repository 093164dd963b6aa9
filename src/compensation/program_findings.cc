#include "armtrue/compensation/program_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <utility>

#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/programs/corrected_already.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "compensation/joint_correction.h"
#include "compensation/program_arm.h"

namespace armtrue {
namespace {

constexpr size_t kMostNames = 5;  // in one sentence

// Largest distance of the flanges of two arms at postures all over the travel. Their feet may be
// half a turn about the vertical apart: base and base_link of a URDF.
double distance_of_flanges(const KinematicChain& a, const KinematicChain& b,
                           const ProgramJoints& of_b) {
  constexpr double kTravel = 2.6;  // rad, to both sides
  const ChainEvaluator first(a), second(b);
  double straight = 0, turned = 0;
  for (int k = 0; k < 32; ++k) {
    JointVector q(kProgramAxes);
    for (int j = 0; j < kProgramAxes; ++j)
      q[j] = kTravel * std::sin(1.0 + 7.0 * k + 2.3 * j * (k + 1));
    const Eigen::Vector3d at = first.pose(q).translation;
    const Eigen::Vector3d other =
        second.pose(of_b.whole(q, JointVector::Zero(of_b.count()))).translation;
    straight = std::max(straight, (at - other).norm());
    turned = std::max(turned, (Eigen::Vector3d(-at.x(), -at.y(), at.z()) - other).norm());
  }
  return std::min(straight, turned);
}

// KR 210 R2700: 210 and 2700; 0: not stated.
std::array<int, 2> numbers_of_kuka(const std::string& name) {
  static const std::regex kModel("KR[ _-]*([0-9]{1,4})(?:[ _-]*R[ _-]*([0-9]{3,4}))?",
                                 std::regex::icase);
  std::smatch found;
  if (!std::regex_search(name, found, kModel)) return {};
  const auto number = [&](size_t group) {
    return found[group].matched ? static_cast<int>(read_number(found.str(group)).value_or(0)) : 0;
  };
  return {number(1), number(2)};
}

// Why the place of a target is not known; empty if it is.
std::string why_no_place(const RobotProgram& program, const ProgramTarget& target,
                         const ProgramJoints& joints) {
  for (const auto& [index, what] :
       {std::pair(target.base, "frame"), std::pair(target.tool, "tool")})
    if (target.kind == TargetKind::cartesian && index >= 0 && !program.frames[index].is_known)
      return fmt::format(
          "its {0} is '{1}', and the program does not say where that is; give it: --frame "
          "'{1}=x,y,z,a,b,c'",
          what, program.frames[index].name);
  for (size_t i = 0; i < joints.external.size(); ++i)
    if (joints.external[i].joint >= 0 &&
        (i >= target.external.size() || std::isnan(target.external[i])))
      return fmt::format(
          "neither it nor those before it state where the external axis E{} stands; state it in "
          "the program",
          i + 1);
  return "";
}

bool has_angle(const RobotProgram& program, const ProgramTarget& target, int axis) {
  return target.kind == TargetKind::joints && program.points[target.point].numbers[axis].end > 0;
}

// Whether poses in one frame tilt the tool against one another: no arm of four axes does.
bool tilts(const RobotProgram& program) {
  const ProgramTarget* first = nullptr;
  for (const ProgramTarget& target : program.targets) {
    if (target.kind != TargetKind::cartesian || !target.has_orientation) continue;
    if (!first) first = &target;
    if (target.base != first->base || target.tool != first->tool) continue;
    const Eigen::Vector3d axis = target.pose.rotation.col(2), other = first->pose.rotation.col(2);
    if (axis.cross(other).norm() > std::sin(kBesideAxes) || axis.dot(other) < 0) return true;
  }
  return false;
}

// Why joint angles cannot be corrected, which lack an axis that the program has otherwise; empty if
// they can. If it has the axis nowhere, it is one of another arm.
std::string why_no_angles(const RobotProgram& program, const ProgramTarget& target,
                          const ProgramJoints& joints) {
  for (int j = 0; j < kProgramAxes; ++j)
    if (target.kind == TargetKind::joints && joints.arm[j] >= 0 && !has_angle(program, target, j) &&
        (tilts(program) || std::ranges::any_of(program.targets, [&](const ProgramTarget& other) {
           return has_angle(program, other, j);
         })))
      return fmt::format("its point has no angle of axis {}; state it in the program", j + 1);
  return "";
}

}  // namespace

std::string doubt_of_arm_name(const RobotProgram& program, const Robot& controller,
                              const std::string& name) {
  const std::array<int, 2> here = numbers_of_kuka(program.arm_name),
                           model = numbers_of_kuka(controller.name);
  bool is_other = false;
  for (size_t i = 0; i < here.size(); ++i)
    is_other |= here[i] > 0 && model[i] > 0 && here[i] != model[i];
  if (!is_other) return "";
  return fmt::format(
      "{}:{}: the arm of this controller is '{}', and {} is '{}'; is it the model of this arm?",
      program.texts[program.arm_name_text].name, program.arm_name_line, program.arm_name, name,
      controller.name);
}

ProgramJoints joints_of_program(const RobotProgram& program, const Robot& controller,
                                const std::string& name) {
  const DialectFacts& facts = program.dialect->facts();
  const std::optional<ProgramJoints> joints =
      program_joints(controller.chain, facts.counts_axis_3_from_arm);
  if (joints && (facts.has_external_axes || !joints->has_external())) return *joints;
  throw InputError(
      fmt::format("{}: {} is about an arm of six revolute axes{}, or of fewer whose links are "
                  "named by them, such "
                  "as A1, A2, A3 and A6, and {} has the joints {}; give its targets as a table "
                  "(pose,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg and the joints as a hint)",
                  program.texts[0].name,
                  facts.has_external_axes ? fmt::format("a {} program", facts.maker)
                                          : std::string("a program of this controller"),
                  facts.has_external_axes ? " and external axes E1 to E6" : "", name,
                  encoder_columns(controller.chain)));
}

std::string doubt_of_stated_arm(const RobotProgram& program, const Robot& controller,
                                const ProgramJoints& joints, const std::string& name) {
  constexpr double kSameTable = 0.1 * kMillimetre;    // rows may be printed with four decimals
  constexpr double kOtherLengths = 20 * kMillimetre;  // no arm is calibrated by so much
  KinematicChain model = controller.chain;
  model.base = model.tool = Pose{};
  for (const StatedArm& arm : program.stated_arms) {
    const double apart = distance_of_flanges(arm.chain, model, joints);
    if (apart < kSameTable) continue;
    const std::string found = fmt::format(
        "{}:{}: the arm that the program states here (kinematics) and {} are up to "
        "{:.3g} mm apart at the same joint angles",
        program.texts[0].name, arm.line, name, apart / kMillimetre);
    if (apart > kOtherLengths)
      throw InputError(found +
                       ": they are different arms; give the model of this one as "
                       "--controller");
    return found +
           ": the poses of its joint angles are those of another table, and the corrections may be "
           "wrong by as much. Give the table of the controller that runs it as --controller "
           "(convert-robot calibration.conf), or save the program on this robot";
  }
  return "";
}

void refuse_two_tools(const RobotProgram& program, bool tool_is_measured) {
  for (const ProgramTarget& target : program.targets)
    if (tool_is_measured && target.tool >= 0)
      throw InputError(fmt::format(
          "{}:{}: the program names the tool '{}', and --tool-is-measured is given; leave it out",
          program.texts[0].name, target.line, program.frames[target.tool].name));
}

void leave_what_has_no_place(RobotProgram& program, const ProgramJoints& joints) {
  std::map<size_t, std::string> why;
  std::set<size_t> left;  // an arc goes with either of its points
  bool is_any_known = false, is_pose_left = false;
  for (size_t k = 0; k < program.targets.size(); ++k) {
    std::string reason = why_no_place(program, program.targets[k], joints);
    if (reason.empty()) reason = why_no_angles(program, program.targets[k], joints);
    if (reason.empty()) continue;
    why[k] = reason;
    is_pose_left |= program.targets[k].kind == TargetKind::cartesian;
    for (const size_t of_move : targets_of_move(program, k)) left.insert(of_move);
  }
  for (size_t k = 0; k < program.targets.size(); ++k)
    is_any_known |=
        !left.contains(k) && (!is_pose_left || program.targets[k].kind == TargetKind::cartesian);
  if (!why.empty() && is_any_known) leave_alone(program, why);
}

std::optional<JointVector> common_posture(const Robot& controller,
                                          const CompensationOptions& options,
                                          const ProgramJoints& joints,
                                          const std::vector<JointVector>& postures) {
  std::optional<JointVector> first;
  std::optional<Branch> branch;
  const ProgramArm arm(controller, options, Pose{}, {});
  for (const JointVector& posture : postures) {
    const JointVector q = joints.whole(posture, JointVector::Zero(joints.count()));
    const Branch own = arm.branch_at(q);
    if (!first) {
      first = q;
      branch = own;
    } else if (own.shoulder != branch->shoulder || own.elbow != branch->elbow ||
               own.wrist != branch->wrist) {
      return std::nullopt;
    }
  }
  return first;
}

bool leave_what_is_out_of_reach(const UnreachableTarget& error, RobotProgram& program) {
  std::set<size_t> left;  // an arc goes with either of its points
  for (const auto& [row, reason] : error.out_of_reach)
    for (const size_t of_move : targets_of_move(program, row)) left.insert(of_move);
  bool is_any_reached = left.empty();  // all out of reach: the frames are wrong
  for (size_t k = 0; k < program.targets.size(); ++k)
    is_any_reached |= program.targets[k].kind == TargetKind::cartesian && !left.contains(k);
  std::map<size_t, std::string> why;
  for (const auto& [row, reason] : error.in_doubt) {
    why[row] = reason;
    for (const size_t of_move : targets_of_move(program, row)) left.insert(of_move);
  }
  if (left.empty() || left.size() == program.targets.size() || !is_any_reached) return false;
  for (const auto& [row, reason] : error.out_of_reach) {
    const ProgramTarget& target = program.targets[row];
    const auto name = [&](int frame) {
      return frame < 0 ? std::string("of this command") : program.frames[frame].name;
    };
    why[row] = fmt::format("{} (frame {}, tool {})", reason, name(target.base), name(target.tool));
  }
  leave_alone(program, why);
  return true;
}

std::vector<std::string> sentences_of_notes(const std::vector<CorrectedTarget>& targets,
                                            const Campaign& visits, const std::string& source) {
  std::vector<std::string> sentences;
  for (const CommandNote note : command_notes()) {
    std::string names;
    size_t count = 0;
    for (size_t row = 0; row < targets.size(); ++row) {
      if (!targets[row].has(note)) continue;
      if (count++ < kMostNames) names += (names.empty() ? "" : ", ") + visits.pose_ids[row];
    }
    if (count == 0) continue;
    sentences.push_back(fmt::format("{}: {} of {} targets: {} ({}{})", source, count,
                                    targets.size(), to_string(note), names,
                                    count > kMostNames ? ", ..." : ""));
  }
  return sentences;
}

std::vector<std::string> sentences_of_moves(const BetweenPoints& between, const Campaign& visits,
                                            const std::string& source) {
  struct Cause {
    std::string lines;
    size_t count = 0;
    double largest = 0;
  };
  std::map<std::string, Cause> causes;
  for (const MoveBetweenPoints& move : between.moves) {
    if (move.why.empty()) continue;
    Cause& cause = causes[move.why];
    if (cause.count++ < kMostNames)
      cause.lines += fmt::format("{}{}", cause.lines.empty() ? "" : ", ", visits.line[move.target]);
    cause.largest = std::max(cause.largest, move.after);
  }
  std::vector<std::string> sentences;
  for (const auto& [why, cause] : causes)
    sentences.push_back(fmt::format(
        "{}: predicted error between points up to {:.3g} mm in {} of {} moves: {} (line {}{})",
        source, cause.largest / kMillimetre, cause.count, between.moves.size(), why, cause.lines,
        cause.count > kMostNames ? ", ..." : ""));
  if (between.unknown > 0)
    sentences.push_back(
        fmt::format("{}: nothing is predicted between the points of {} straight or "
                    "circular moves: where they begin or end, or how the tool turns, is not known, "
                    "or an end stays as "
                    "programmed",
                    source, between.unknown));
  return sentences;
}

std::string why_corrected_before(const RoundWhereReached& found, const Campaign& visits,
                                 const std::string& source, const std::string& arm) {
  const int decimals = std::max(0, found.decimals);
  return fmt::format(
      "{}:{}: its targets are corrected already: {} of {} numbers that are longer as they are "
      "written have at most {} decimals where the arm of {} takes them ({} is {:.{}f} there); "
      "corrected twice, they would be wrong: {}",
      source, visits.line[found.target], found.round, found.numbers, decimals, arm,
      number_text(found.written), found.reached, decimals + 2,
      instead_of_corrected(Corrector::compensate));
}

}  // namespace armtrue
