#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/text/number_text.h"
#include "programs/insertion.h"
#include "programs/point_numbers.h"
#include "programs/program_warnings.h"
#include "programs/routine_copies.h"
#include "programs/statement.h"
#include "programs/text_edit.h"

namespace armtrue {
namespace {

// What a point becomes by one of its targets: a text for each number, empty where it stays.
struct Wanted {
  std::vector<double> numbers;
  std::vector<std::string> texts, configuration, external;
  std::vector<double> external_values;  // NaN: not known

  bool is_changed() const {
    const auto is_text = [](const std::string& text) { return !text.empty(); };
    return std::ranges::any_of(texts, is_text) || std::ranges::any_of(external, is_text);
  }
};

// The point of a pose, as it is written, that its move displaces.
Pose of_point(const ProgramTarget& target, const Pose& pose) {
  if (target.is_inverse) return inverse(pose);
  return inverse(target.before) * pose * inverse(target.behind);
}

// The pose of such a point.
Pose from_point(const ProgramTarget& target, const Pose& point) {
  if (target.is_inverse) return inverse(point);
  return target.before * point * target.behind;
}

class Rewriter {
 public:
  Rewriter(const RobotProgram& program, const std::vector<ProgramCommand>& commands,
           const std::vector<ProgramPointBetween>& between, std::optional<Corrector> by)
      : program_(program),
        dialect_(*program.dialect),
        commands_(commands),
        by_(by),
        warnings_(program.texts[0].name),
        uses_(program.points.size()),
        stays_(program.points.size(), false),
        is_changed_(program.points.size(), false),
        is_divided_(program.targets.size(), false) {
    for (size_t k = 0; k < program.targets.size(); ++k)
      uses_[program.targets[k].point].push_back(k);
    for (const ProgramPointBetween& point : between)
      if (can_be_inserted(point)) between_.push_back(point);
    for (const ProgramPointBetween& point : between_) {
      is_divided_[point.target] = true;
      // The auxiliary point of a divided arc is written out in its move.
      if (point.motion == MotionKind::via)
        std::erase(uses_[program.targets[point.target].point], point.target);
    }
    changes_between_.resize(between_.size());
  }

  RewrittenProgram write() {
    find_wanted();
    keep_where_expressions_stay();
    for (const bool starts_from_another : {false, true})
      for (size_t point = 0; point < program_.points.size(); ++point) {
        const ProgramPoint& of = program_.points[point];
        if (uses_[point].empty() || (of.starts_from >= 0) != starts_from_another) continue;
        if (of.is_expression)
          write_expression(point);
        else
          write_point(point);
      }
    insert_moves();
    const std::vector<TextEdit> edits = without_needless_copies();
    for (size_t i = 0; i < program_.texts.size(); ++i)
      result_.texts.push_back(
          apply_edits(text_without_copies(program_, i), edits, static_cast<int>(i)));
    result_.edits = std::move(edits_);
    result_.warnings = warnings_.list();
    return std::move(result_);
  }

 private:
  // The edits of the text without copies.
  std::vector<TextEdit> without_needless_copies() {
    std::vector<size_t> kept;
    std::vector<TextEdit> edits = edits_without_copies(program_, edits_, kept);
    for (const size_t i : kept) {
      const RoutineCopy& copy = program_.copies[i];
      for (const RoutineCopy::Call& call : copy.calls) {
        const int line = line_at(program_.texts[0].text, call.begin);
        warnings_.add(program_.lines[line - 1],
                      fmt::format("{} is called here, a copy of {} with points of its own: other "
                                  "calls hand on another tool, frame or point",
                                  copy.name, copy.of));
      }
    }
    return edits;
  }

  bool can_be_inserted(const ProgramPointBetween& point) const {
    const bool is_via = program_.targets[point.target].motion == MotionKind::via;
    const size_t end = is_via ? point.target + 1 : point.target;
    const size_t start = end - (program_.targets[end].motion == MotionKind::arc ? 2 : 1);
    return commands_[end].is_corrected && commands_[start].is_corrected;
  }

  // The numbers that each target and each point between them needs, in the order in which the arm
  // passes them.
  void find_wanted() {
    for (size_t k = 0; k < program_.targets.size(); ++k) wanted_.push_back(wanted_by(k));
    size_t next = 0;  // point between
    for (size_t k = 0; k < program_.targets.size(); ++k) {
      const bool is_via = program_.targets[k].motion == MotionKind::via;
      if (program_.targets[k].motion != MotionKind::arc) start_move(k);
      for (; next < between_.size() && between_[next].target <= (is_via ? k + 1 : k); ++next) {
        const ProgramPointBetween& between = between_[next];
        if (between.is_left_out) continue;
        Wanted wanted = wanted_between(between);
        hold(between.target, between.motion == MotionKind::via, wanted);
        changes_between_[next] = edits_of(point_of(between.target), wanted);
        if (!between.q) continue;
        for (TextEdit& edit :
             dialect_.configuration_edits(program_, point_of(between.target), *between.q))
          changes_between_[next].push_back(std::move(edit));
      }
      hold(k, is_via, wanted_[k]);
      if (commands_[k].is_corrected)
        wanted_[k].configuration =
            dialect_.configuration_texts(point_of(k), as_written(k, wanted_[k]));
    }
  }

  // The command with the joint angles at its numbers as they are written.
  ProgramCommand as_written(size_t index, const Wanted& wanted) const {
    const ProgramTarget& target = program_.targets[index];
    ProgramCommand command = commands_[index];
    if (!command.by_pose) return command;
    const ProgramPoint& point = point_of(index);
    std::vector<double> numbers = wanted.numbers;
    for (size_t i = 0; i < numbers.size(); ++i)
      if (const std::string text = written_text(point, wanted, i); !text.empty())
        numbers[i] = read_number(text).value_or(numbers[i]);
    const Pose written = from_point(target, dialect_.pose_of_numbers(numbers));
    Eigen::Matrix<double, 6, 1> moved;
    moved << written.translation - command.pose.translation,
        rotation_log(written.rotation * command.pose.rotation.transpose());
    if (!target.has_orientation) moved.tail<3>().setZero();
    command.q += *command.by_pose * moved;
    return command;
  }

  // After a branch or in a loop the controller has the numbers of one of several points: `held_`
  // has only those that are equal.
  void start_move(size_t target) {
    const std::vector<size_t>& starts = program_.targets[target].starts;
    if (starts.size() == 1 && starts[0] + 1 == target) return;
    held_.clear();
    held_external_.clear();
    for (size_t start : starts) {
      keep_common(wanted_[start].numbers, start == starts[0], held_);
      keep_common(wanted_[start].external_values, start == starts[0], held_external_);
    }
  }
  static void keep_common(const std::vector<double>& values, bool is_first,
                          std::vector<double>& held) {
    if (is_first) held = values;
    for (size_t i = 0; i < std::min(held.size(), values.size()); ++i)
      if (!(std::abs(values[i] - held[i]) <= half_step(kExternal)))
        held[i] = std::numeric_limits<double>::quiet_NaN();
  }

  // Adds the numbers that a point leaves out, if the controller would have others from the points
  // before; updates `held_`.
  void hold(size_t target, bool is_via, Wanted& wanted) {
    const ProgramPoint& point = point_of(target);
    hold_external(target, is_via, wanted);
    if (point.kind == TargetKind::joints) return held_.clear();
    held_.resize(point.numbers.size(), std::numeric_limits<double>::quiet_NaN());
    for (size_t i = 0; i < held_.size(); ++i) {
      const ProgramNumber& number = point.numbers[i];
      double& here = wanted.numbers[i];
      if (!number.is_written() && !number.prefix.empty() && std::isfinite(number.value)) {
        const int kept = decimals(point, i);
        if (std::abs(here - held_[i]) <= half_step(kept))
          here = held_[i];
        else
          wanted.texts[i] = rounded_text(here, 0, kept);
      }
      if (!is_via)
        held_[i] = here;
      else if (i < 3 && here != held_[i])  // from there or from the start of the arc
        held_[i] = std::numeric_limits<double>::quiet_NaN();
    }
  }

  // The same of external axes, which may be unknown. Those of an auxiliary point count for nothing.
  void hold_external(size_t target, bool is_via, Wanted& wanted) {
    const ProgramPoint& point = point_of(target);
    held_external_.resize(point.external.size(), std::numeric_limits<double>::quiet_NaN());
    for (size_t i = 0; i < wanted.external_values.size(); ++i) {
      const double here = wanted.external_values[i];
      if (std::isnan(here)) continue;
      const ProgramNumber& number = point.external[i];
      if (point.is_expression) {
        const bool is_other = std::abs(here - number.value) > half_step(kExternal);
        const bool is_held = std::abs(here - held_external_[i]) <= half_step(kExternal);
        if (is_other || (number.prefix.empty() && !is_held))
          wanted.external[i] = rounded_text(here, 0, kExternal);
        if (!is_via) held_external_[i] = here;
        continue;
      }
      if (number.is_written())
        wanted.external[i] = text_of_number(number, here, kExternal);
      else if (!is_via && !(std::abs(here - held_external_[i]) <= half_step(kExternal)))
        wanted.external[i] = rounded_text(here, 0, kExternal);
      if (!is_via && (number.is_written() || !wanted.external[i].empty())) held_external_[i] = here;
    }
  }

  void insert_moves() {
    result_.inserted = moves_of(between_);
    dialect_.refuse_what_does_not_load(program_, result_.inserted);
    for (const OwnPoint& own : own_) is_divided_[own.target] = true;
    for (TextEdit& edit : insertion_edits(program_, between_, changes_between_, own_))
      edits_.push_back(std::move(edit));
    for (size_t k = 0; k < program_.targets.size(); ++k) {
      const ProgramTarget& target = program_.targets[k];
      if (is_divided_[k] && !target.remark.empty()) warnings_.add(target.line, target.remark);
    }
  }

  // An expression whose target is not corrected starts from its point as it is declared.
  void keep_where_expressions_stay() {
    for (size_t point = 0; point < program_.points.size(); ++point) {
      const ProgramPoint& of = program_.points[point];
      stays_[point] |= of.is_shared || of.is_of_others;
      if (of.starts_from >= 0 &&
          !std::ranges::all_of(uses_[point], [&](size_t k) { return commands_[k].is_corrected; }))
        stays_[of.starts_from] = true;
    }
  }

  // Writes an expression out in its move if that needs another point, or if the point from which it
  // starts has changed.
  void write_expression(size_t index) {
    const ProgramPoint& point = program_.points[index];
    for (size_t target : uses_[index]) {
      Wanted& wanted = wanted_[target];
      if (!wanted.is_changed() && !starts_from_changed(point) && !starts_elsewhere(target))
        continue;
      ++result_.changed;
      own_.push_back({target, {}, point.before + written_out(point, wanted) + point.behind});
    }
  }

  // Whether a relative move would end elsewhere, as it starts from a corrected point.
  bool starts_elsewhere(size_t target) const {
    const ProgramTarget& move = program_.targets[target];
    const auto is_changed = [&](size_t start) { return wanted_[start].is_changed(); };
    if (!move.is_relative) return false;
    return move.starts.empty() ? std::ranges::any_of(wanted_, &Wanted::is_changed)
                               : std::ranges::any_of(move.starts, is_changed);
  }

  bool starts_from_changed(const ProgramPoint& point) const {
    return point.starts_from >= 0 && is_changed_[point.starts_from];
  }

  std::string written_out(const ProgramPoint& point, const Wanted& wanted) const {
    std::vector<std::string> texts;
    for (size_t i = 0; i < wanted.numbers.size(); ++i)
      texts.push_back(written_text(point, wanted, i));
    return dialect_.written_out(program_, point, {texts, wanted.configuration, wanted.external});
  }

  // Empty if a number of a declaration stays.
  std::string written_text(const ProgramPoint& point, const Wanted& wanted, size_t i) const {
    return point.is_expression && wanted.texts[i].empty()
               ? rounded_text(wanted.numbers[i], 1, decimals_of(dialect_, point, i))
               : wanted.texts[i];
  }

  // Changes a point where it is declared if all its targets need the same numbers; otherwise writes
  // it into the moves that need others.
  void write_point(size_t index) {
    const ProgramPoint& point = program_.points[index];
    const Wanted& first = wanted_[uses_[index].front()];
    const bool is_agreed = std::ranges::all_of(
        uses_[index], [&](size_t target) { return agree(point, first, wanted_[target]); });
    if (is_agreed && !stays_[index]) {
      result_.changed += first.is_changed();
      is_changed_[index] = first.is_changed();
      for (TextEdit& edit : edits_of(point, first)) edits_.push_back(std::move(edit));
      return;
    }
    for (size_t target : uses_[index]) {
      if (!wanted_[target].is_changed() && !starts_from_changed(point)) continue;
      ++result_.changed;
      own_.push_back({target, edits_of(point, wanted_[target]), ""});
    }
  }

  std::vector<TextEdit> edits_of(const ProgramPoint& point, const Wanted& wanted) const {
    std::vector<TextEdit> edits;
    const auto add = [&](const std::vector<ProgramNumber>& numbers,
                         const std::vector<std::string>& texts) {
      for (size_t i = 0; i < texts.size(); ++i)
        if (!texts[i].empty())
          edits.push_back({numbers[i].text, numbers[i].begin, numbers[i].end,
                           (numbers[i].is_written() ? "" : numbers[i].prefix) + texts[i]});
    };
    add(point.numbers, wanted.texts);
    if (!edits.empty()) add(point.configuration, wanted.configuration);
    add(point.external, wanted.external);
    if (edits.empty()) return edits;
    for (const StatedPose& stated : point.poses) add(stated.numbers, texts_of(stated, wanted));
    return edits;
  }

  // A text for each number of a pose that follows joint angles; empty where it stays.
  std::vector<std::string> texts_of(const StatedPose& stated, const Wanted& wanted) const {
    const Pose flange =
        ChainEvaluator(*program_.stated_arm).pose(dialect_.joints_of_numbers(wanted.numbers));
    const std::vector<double> numbers =
        dialect_.numbers_of_pose(stated.before * flange * stated.behind, values_of(stated.numbers));
    std::vector<std::string> texts;
    for (size_t i = 0; i < numbers.size(); ++i)
      texts.push_back(text_of_number(stated.numbers[i], numbers[i],
                                     dialect_.decimals(TargetKind::cartesian, i)));
    return texts;
  }

  int decimals(const ProgramPoint& point, size_t i) const {
    const ProgramNumber& number = point.numbers[i];
    return std::max(written_decimals(text_of(number)), decimals_of(dialect_, point, i));
  }

  // Targets that differ by one step of rounding agree; they take the numbers of the first.
  bool agree(const ProgramPoint& point, const Wanted& a, const Wanted& b) const {
    for (size_t i = 0; i < a.numbers.size(); ++i) {
      if (std::abs(a.numbers[i] - b.numbers[i]) > std::pow(10.0, -decimals(point, i))) return false;
      if (!point.numbers[i].is_written() && a.texts[i] != b.texts[i]) return false;
    }
    return a.configuration == b.configuration && a.external == b.external;
  }

  std::string_view text_of(const ProgramNumber& number) const {
    return std::string_view(program_.texts[number.text].text)
        .substr(number.begin, number.end - number.begin);
  }

  const ProgramPoint& point_of(size_t target) const {
    return program_.points[program_.targets[target].point];
  }

  static double half_step(int decimals) { return 0.5 * std::pow(10.0, -decimals); }

  static Wanted unchanged(const ProgramPoint& point) {
    Wanted wanted;
    wanted.numbers = values_of(point.numbers);
    wanted.texts.resize(point.numbers.size());
    wanted.configuration.resize(point.configuration.size());
    wanted.external.resize(point.external.size());
    return wanted;
  }

  Wanted wanted_by(size_t target) const {
    const ProgramPoint& point = point_of(target);
    const ProgramCommand& command = commands_[target];
    Wanted wanted = unchanged(point);
    wanted.external_values = program_.targets[target].external;
    if (!command.is_corrected) return wanted;
    if (!command.external.empty()) wanted.external_values = command.external;
    wanted.numbers = numbers_of(target, wanted.numbers);
    if (point.is_expression)
      round_expression(point, wanted);
    else
      round(point, wanted);
    return wanted;
  }

  Wanted wanted_between(const ProgramPointBetween& between) const {
    const ProgramPoint& point = point_of(between.target);
    Wanted wanted = unchanged(point);
    std::vector<double> near = wanted.numbers;
    for (double& number : near)
      if (std::isnan(number)) number = 0;
    const std::vector<double> numbers =
        dialect_.numbers_of_pose(of_point(program_.targets[between.target], between.pose), near);
    for (size_t i = 0; i < numbers.size(); ++i)
      if (std::isfinite(wanted.numbers[i])) wanted.numbers[i] = numbers[i];
    round(point, wanted);
    wanted.external_values = between.external;
    return wanted;
  }

  // Rounds what is written, and gives it a text where it changes.
  void round(const ProgramPoint& point, Wanted& wanted) const {
    for (size_t i = 0; i < wanted.numbers.size(); ++i) {
      const ProgramNumber& number = point.numbers[i];
      if (!number.is_written()) continue;
      wanted.texts[i] = checked_text(point, i, wanted.numbers[i]);
      if (wanted.texts[i].empty()) wanted.numbers[i] = number.value;
    }
  }

  // As text_of_number(), with check digits.
  std::string checked_text(const ProgramPoint& point, size_t i, double value) const {
    const ProgramNumber& number = point.numbers[i];
    const std::string text = text_of_number(number, value, decimals_of(dialect_, point, i));
    return text.empty() ? text
                        : changed_text(point, i, value, written_decimals(text_of(number)));
  }

  // With at least so many decimals, and with check digits.
  std::string changed_text(const ProgramPoint& point, size_t i, double value, int at_least) const {
    const int kept = decimals_of(dialect_, point, i);
    if (!by_) return rounded_text(value, at_least, std::max(at_least, kept));
    const NumberCheck check = dialect_.check(point.kind, i);
    if (check.rounded > 0)
      value = checked_if_rounded(value, check.rounded, CheckSize::quarter, *by_);
    if (check.decimals == 0) return rounded_text(value, at_least, std::max(at_least, kept));
    const int decimals = std::max(at_least, check.decimals);
    return rounded_text(checked(value, decimals, CheckSize::digits, *by_), at_least, decimals);
  }

  // An expression is written out whole, or stays.
  void round_expression(const ProgramPoint& point, Wanted& wanted) const {
    for (size_t i = 0; i < wanted.numbers.size(); ++i) {
      const int kept = decimals_of(dialect_, point, i);
      if (std::abs(wanted.numbers[i] - point.numbers[i].value) > half_step(kept))
        wanted.texts[i] = changed_text(point, i, wanted.numbers[i], 1);
      else
        wanted.numbers[i] = point.numbers[i].value;
    }
  }

  // Empty if a number stays as it is written, or is not written.
  std::string text_of_number(const ProgramNumber& number, double value, int at_least) const {
    const int written = written_decimals(text_of(number)), kept = std::max(written, at_least);
    if (!number.is_written() || std::abs(value - number.value) <= half_step(kept)) return "";
    return rounded_text(value, written, kept);
  }

  // The numbers of a command. Position or orientation that equals the target's keeps the written
  // numbers, even if a quaternion is not unit, or angles are not unique.
  std::vector<double> numbers_of(size_t index, const std::vector<double>& written) const {
    const ProgramTarget& target = program_.targets[index];
    const ProgramCommand& command = commands_[index];
    constexpr double kSame = 1e-8;  // [m], [rad]
    if (target.kind == TargetKind::joints)
      return (target.q - command.q).cwiseAbs().maxCoeff() < kSame
                 ? written
                 : numbers_of_joints(dialect_, point_of(index), command.q);
    const Pose programmed = of_point(target, target.pose);
    const Pose commanded = of_point(target, command.pose);
    const Eigen::Vector3d shift = commanded.translation - programmed.translation;
    const Eigen::Matrix3d turn = commanded.rotation * programmed.rotation.transpose();
    const bool is_turned = target.has_orientation && rotation_log(turn).norm() >= kSame;
    if (!is_turned && shift.norm() < kSame) return written;
    std::vector<double> numbers =
        dialect_.numbers_of_pose(commanded, target.has_orientation ? written : std::vector(6, 0.0));
    if (!is_turned) std::copy(written.begin() + 3, written.end(), numbers.begin() + 3);
    return numbers;
  }

  static constexpr int kExternal = 4;  // decimals of an external axis

  const RobotProgram& program_;
  const Dialect& dialect_;
  const std::vector<ProgramCommand>& commands_;
  std::optional<Corrector> by_;
  ProgramWarnings warnings_;
  std::vector<std::vector<size_t>> uses_;     // targets of each point
  std::vector<ProgramPointBetween> between_;  // that are written
  std::vector<char> stays_, is_changed_;      // of each point: its declaration
  std::vector<char> is_divided_;              // of each target: points are inserted in its move
  std::vector<Wanted> wanted_;                // by each target
  std::vector<double> held_external_;         // the same of external axes
  std::vector<double> held_;  // the numbers that the controller has from the points before
  std::vector<std::vector<TextEdit>> changes_between_;  // of the point of the target of each
  std::vector<OwnPoint> own_;
  std::vector<TextEdit> edits_;
  RewrittenProgram result_;
};

}  // namespace

std::vector<NumberBeside> numbers_beside(const RobotProgram& program,
                                         const std::vector<ProgramCommand>& commands) {
  std::vector<NumberBeside> result;
  std::vector<bool> is_done(program.points.size(), false);
  for (size_t k = 0; k < program.targets.size(); ++k) {
    const size_t index = program.targets[k].point;
    if (is_done[index]) continue;
    is_done[index] = true;
    const ProgramTarget& target = program.targets[k];
    const ProgramPoint& point = program.points[index];
    const bool is_joints = point.kind == TargetKind::joints;
    std::vector<double> written;
    for (const ProgramNumber& number : point.numbers)
      written.push_back(std::isfinite(number.value) ? number.value : 0);
    const std::vector<double> beside =
        is_joints ? numbers_of_joints(*program.dialect, point, commands[k].q)
                  : program.dialect->numbers_of_pose(of_point(target, commands[k].pose), written);
    const size_t count = is_joints || target.has_orientation ? point.numbers.size() : 3;
    for (size_t i = 0; i < count; ++i)
      if (point.numbers[i].is_written())
        result.push_back({static_cast<int>(is_joints ? point.numbers.size() + i : i), written[i],
                          beside[i], decimals_of(*program.dialect, point, i),
                          program.dialect->moved_by_check(point.kind, i), k});
  }
  return result;
}

RewrittenProgram rewrite(const RobotProgram& program, const std::vector<ProgramCommand>& commands,
                         const std::vector<ProgramPointBetween>& between,
                         std::optional<Corrector> by) {
  return Rewriter(program, commands, between, by).write();
}

}  // namespace armtrue
