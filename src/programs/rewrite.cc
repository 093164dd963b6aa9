#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/robot_program.h"
#include "programs/insertion.h"
#include "programs/program_values.h"
#include "programs/program_warnings.h"
#include "programs/text_edit.h"
#include "programs/written_number.h"

namespace armtrue {
namespace {

// What a point becomes by one of its targets: a text for each number, empty where it stays.
struct Wanted {
  std::vector<double> numbers;
  std::vector<std::string> texts, configuration;
};

class Rewriter {
 public:
  Rewriter(const RobotProgram& program, const std::vector<ProgramCommand>& commands,
           const std::vector<ProgramPointBetween>& between)
      : program_(program),
        commands_(commands),
        warnings_(program.texts[0].name),
        uses_(program.points.size()),
        is_changed_(program.points.size(), false),
        is_divided_(program.targets.size(), false) {
    for (size_t k = 0; k < program.targets.size(); ++k)
      uses_[static_cast<size_t>(program.targets[k].point)].push_back(k);
    for (const ProgramPointBetween& point : between)
      if (can_be_inserted(point)) between_.push_back(point);
    for (const ProgramPointBetween& point : between_) {
      is_divided_[point.target] = true;
      // The auxiliary point of a divided arc is written out in its move.
      if (point.motion == MotionKind::via)
        std::erase(uses_[static_cast<size_t>(program.targets[point.target].point)], point.target);
    }
  }

  RewrittenProgram write() {
    int before = -1;  // the point at which the move of the target begins
    for (size_t k = 0; k < program_.targets.size(); ++k) {
      const auto point = static_cast<size_t>(program_.targets[k].point);
      if (!uses_[point].empty() && uses_[point].front() == k)
        is_changed_[point] = write_point(
            point, is_divided_[k] || (before >= 0 && is_changed_[static_cast<size_t>(before)]));
      if (program_.targets[k].motion != MotionKind::via) before = program_.targets[k].point;
    }
    RewrittenProgram result;
    insert_moves(result);
    result.changed = static_cast<int>(std::ranges::count(is_changed_, true));
    for (size_t i = 0; i < program_.texts.size(); ++i)
      result.texts.push_back(apply_edits(program_.texts[i].text, edits_, static_cast<int>(i)));
    result.warnings = warnings_.list();
    return result;
  }

 private:
  // Whether a target gets the numbers of its command: it is corrected, and so are all others of its
  // point, alike.
  bool is_commanded(size_t target) const {
    if (!commands_[target].is_corrected) return false;
    const auto index = static_cast<size_t>(program_.targets[target].point);
    const ProgramPoint& point = program_.points[index];
    const Wanted first = wanted_by(point, commands_[uses_[index].front()]);
    return std::ranges::all_of(uses_[index], [&](size_t other) {
      return agree(point, first, wanted_by(point, commands_[other]));
    });
  }

  bool can_be_inserted(const ProgramPointBetween& point) const {
    if (point.motion == MotionKind::line)
      return is_commanded(point.target) && is_commanded(point.target - 1);
    const size_t end = point.motion == MotionKind::via ? point.target + 1 : point.target;
    return is_commanded(end) && is_commanded(end - 2);
  }

  void insert_moves(RewrittenProgram& result) {
    result.inserted = moves_of(between_);
    refuse_what_does_not_load(program_, static_cast<size_t>(result.inserted));
    for (TextEdit& edit : insertion_edits(program_, between_)) edits_.push_back(std::move(edit));
    for (size_t k = 0; k < program_.targets.size(); ++k) {
      const ProgramTarget& target = program_.targets[k];
      if (is_divided_[k] && !target.insertion.remark.empty())
        warnings_.add(target.line, target.insertion.remark);
    }
  }

  // Returns whether a byte changes. What a point leaves out the controller takes from the point
  // before; it is written if that one changes.
  bool write_point(size_t index, bool is_changed_before) {
    const ProgramPoint& point = program_.points[index];
    std::vector<Wanted> wanted;
    for (size_t target : uses_[index]) wanted.push_back(wanted_by(point, commands_[target]));
    for (size_t k = 1; k < wanted.size(); ++k) {
      if (agree(point, wanted[0], wanted[k])) continue;
      warnings_.add(
          program_.targets[uses_[index][k]].line,
          fmt::format("{} needs another correction here than in line {} (another tool, frame, "
                      "posture or direction of arrival), and stays as programmed; give each move "
                      "a point of its own",
                      point.name, program_.targets[uses_[index][0]].line));
      wanted[0] = unchanged(point);
      break;
    }
    if (is_changed_before)
      for (size_t i = 0; i < point.numbers.size(); ++i)
        if (wanted[0].texts[i].empty() && !point.numbers[i].prefix.empty())
          wanted[0].texts[i] = rounded_text(point.numbers[i].value, 0, decimals(point, i));
    const size_t before = edits_.size();
    edit(point.numbers, wanted[0].texts);
    if (edits_.size() != before) edit(point.configuration, wanted[0].configuration);
    return edits_.size() != before;
  }

  void edit(const std::vector<ProgramNumber>& numbers, const std::vector<std::string>& texts) {
    for (size_t i = 0; i < texts.size(); ++i)
      if (!texts[i].empty())
        edits_.push_back({numbers[i].text, numbers[i].begin, numbers[i].end,
                          (numbers[i].is_written() ? "" : numbers[i].prefix) + texts[i]});
  }

  int decimals(const ProgramPoint& point, size_t i) const {
    const ProgramNumber& number = point.numbers[i];
    return std::max(written_decimals(text_of(number)),
                    decimals_kept(program_.dialect, point.kind, i));
  }

  // Targets that differ by one step of rounding agree; they take the numbers of the first.
  bool agree(const ProgramPoint& point, const Wanted& a, const Wanted& b) const {
    for (size_t i = 0; i < a.numbers.size(); ++i)
      if (std::abs(a.numbers[i] - b.numbers[i]) > std::pow(10.0, -decimals(point, i))) return false;
    return a.configuration == b.configuration;
  }

  std::string_view text_of(const ProgramNumber& number) const {
    return std::string_view(program_.texts[static_cast<size_t>(number.text)].text)
        .substr(number.begin, number.end - number.begin);
  }

  static Wanted unchanged(const ProgramPoint& point) {
    Wanted wanted;
    for (const ProgramNumber& number : point.numbers) wanted.numbers.push_back(number.value);
    wanted.texts.resize(point.numbers.size());
    wanted.configuration.resize(point.configuration.size());
    return wanted;
  }

  Wanted wanted_by(const ProgramPoint& point, const ProgramCommand& command) const {
    Wanted wanted = unchanged(point);
    if (!command.is_corrected) return wanted;
    const std::vector<double> written = wanted.numbers;
    wanted.numbers = point.kind == TargetKind::joints
                         ? numbers_of_joints(program_.dialect, command.q)
                         : numbers_of_pose(program_.dialect, command.pose, written);
    if (is_same(point, command, written)) {
      wanted.numbers = written;
      return wanted;
    }
    for (size_t i = 0; i < wanted.numbers.size(); ++i) {
      const ProgramNumber& number = point.numbers[i];
      if (!number.is_written() && number.prefix.empty()) continue;
      const int kept = decimals(point, i);
      if (std::abs(wanted.numbers[i] - written[i]) <= 0.5 * std::pow(10.0, -kept)) {
        wanted.numbers[i] = written[i];
        if (number.is_written()) continue;
      }
      wanted.texts[i] = rounded_text(wanted.numbers[i], written_decimals(text_of(number)), kept);
    }
    wanted.configuration = configuration_of(point, command);
    return wanted;
  }

  // A command that is the target itself changes no byte, also where a quaternion is not unit.
  bool is_same(const ProgramPoint& point, const ProgramCommand& command,
               const std::vector<double>& written) const {
    constexpr double kSame = 1e-8;  // [m], [rad]
    if (point.kind == TargetKind::joints)
      return (joints_of_numbers(program_.dialect, written) - command.q).cwiseAbs().maxCoeff() <
             kSame;
    const Pose pose = pose_of_numbers(program_.dialect, written);
    return (pose.translation - command.pose.translation).norm() < kSame &&
           rotation_log(pose.rotation * command.pose.rotation.transpose()).norm() < kSame;
  }

  // Changed where the corrected joints have another turn or quadrant than the programmed ones;
  // bits and numbers that say something else stay.
  std::vector<std::string> configuration_of(const ProgramPoint& point,
                                            const ProgramCommand& command) const {
    std::vector<std::string> texts(point.configuration.size());
    const auto change = [&](size_t i, int before, int now) {
      constexpr double kMost = 1e6;  // 9E9 states nothing
      const double written = point.configuration[i].value;
      if (before != now && std::abs(written) < kMost)
        texts[i] = fmt::format("{}", static_cast<int>(written) + now - before);
    };
    if (program_.dialect == Dialect::krl && !texts.empty())
      change(0, turn_bits(command.programmed), turn_bits(command.q));
    if (program_.dialect == Dialect::rapid && texts.size() == 4)
      for (size_t i = 0; i < 3; ++i) {
        const int joint = i == 0 ? 0 : i == 1 ? 3 : 5;
        change(i, quadrant(command.programmed[joint]), quadrant(command.q[joint]));
      }
    return texts;
  }

  static int turn_bits(const JointVector& q) {
    int bits = 0;
    for (int j = 0; j < kProgramAxes; ++j)
      if (q[j] < 0) bits |= 1 << j;
    return bits;
  }

  const RobotProgram& program_;
  const std::vector<ProgramCommand>& commands_;
  ProgramWarnings warnings_;
  std::vector<std::vector<size_t>> uses_;     // targets of each point
  std::vector<ProgramPointBetween> between_;  // that are written
  std::vector<TextEdit> edits_;
  std::vector<char> is_changed_;  // of each point
  std::vector<char> is_divided_;  // of each target: points are inserted in its move
};

}  // namespace

RewrittenProgram rewrite(const RobotProgram& program, const std::vector<ProgramCommand>& commands,
                         const std::vector<ProgramPointBetween>& between) {
  return Rewriter(program, commands, between).write();
}

}  // namespace armtrue
