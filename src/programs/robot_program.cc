#include "armtrue/programs/robot_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "armtrue/programs/dialect.h"
#include "programs/program_warnings.h"
#include "programs/routine_copies.h"
#include "programs/statement.h"

namespace armtrue {
namespace {

// 100 km, or a million turns: beyond, circles through points are lost in rounding.
constexpr double kLargestNumber = 1e8;

void refuse_huge_numbers(const RobotProgram& program) {
  for (const ProgramPoint& point : program.points)
    for (const ProgramNumber& number : point.numbers)
      if (number.is_written() && !(std::abs(number.value) < kLargestNumber))
        throw InputError(fmt::format("{}:{}: a number of the point {} is too large; correct it",
                                     program.texts[number.text].name, point.line, point.name));
}

void count_lines_without_copies(RobotProgram& program) {
  if (program.copies.empty()) return;
  const auto counted = [&](int line) { return program.lines[line - 1]; };
  for (ProgramTarget& target : program.targets) target.line = counted(target.line);
  for (ProgramCall& call : program.calls_not_given) call.line = counted(call.line);
  for (ProgramCall& call : program.calls_of_others) call.line = counted(call.line);
  for (ProgramPoint& point : program.points)
    if (point.text == 0) point.line = counted(point.line);
}

// `is_left`: of each target.
void remove_targets(RobotProgram& program, const std::vector<char>& is_left) {
  std::vector<size_t> now(program.targets.size());  // index of each that stays
  std::vector<ProgramTarget> targets;
  for (size_t k = 0; k < program.targets.size(); ++k) {
    now[k] = targets.size();
    if (is_left[k]) continue;
    targets.push_back(std::move(program.targets[k]));
    targets.back().follows_target &= k > 0 && !is_left[k - 1];
  }
  for (ProgramTarget& target : targets) {
    if (std::ranges::any_of(target.starts, [&](size_t start) { return is_left[start]; }))
      target.starts.clear();
    for (size_t& start : target.starts) start = now[start];
  }
  program.targets = std::move(targets);
}

// Cuts a long line, between two characters of UTF-8.
void shorten(std::string& line) {
  constexpr size_t kShown = 80;
  size_t end = kShown;
  if (line.size() <= end) return;
  while (end > 0 && (static_cast<unsigned char>(line[end]) & 0xC0) == 0x80) --end;
  line = line.substr(0, end) + "..";
}

}  // namespace

std::vector<size_t> targets_of_move(const RobotProgram& program, size_t target) {
  const auto is_via = [&](size_t k) { return program.targets[k].motion == MotionKind::via; };
  if (is_via(target)) return {target, target + 1};
  // An arc of FANUC's A has no auxiliary point of its own.
  if (program.targets[target].motion == MotionKind::arc && target > 0 && is_via(target - 1))
    return {target - 1, target};
  return {target};
}

void leave_alone(RobotProgram& program, const std::map<size_t, std::string>& why) {
  std::vector<char> is_left(program.targets.size(), false);
  ProgramWarnings warnings(program.texts[0].name);
  for (const auto& [target, reason] : why) {
    const std::vector<size_t> move = targets_of_move(program, target);
    if (is_left[move[0]]) continue;
    for (const size_t k : move) {
      is_left[k] = true;
      ProgramPoint& point = program.points[program.targets[k].point];
      point.is_shared = true;
      if (point.starts_from >= 0) program.points[point.starts_from].is_shared = true;
    }
    warnings.add(program.targets[target].line, "left alone: " + reason);
    if (program.targets[target].never_runs) continue;
    program.why_left_alone.push_back(reason);
    ++program.left_alone;
  }
  std::ranges::copy(warnings.list(), std::back_inserter(program.warnings));
  remove_targets(program, is_left);
}

void remove_what_never_runs(RobotProgram& program) {
  std::vector<char> never_runs;
  for (const ProgramTarget& target : program.targets) never_runs.push_back(target.never_runs);
  if (std::ranges::count(never_runs, true) == std::ssize(never_runs)) return;
  for (const ProgramTarget& target : program.targets) {
    if (!target.never_runs) continue;
    program.never_run += target.motion != MotionKind::via;
    if (target.node >= 0) program.ways[target.node].clear();
  }
  remove_targets(program, never_runs);
}

bool operator==(const HandedFrame& a, const HandedFrame& b) {
  const bool is_same_pose = a.pose ? b.pose && a.pose->rotation == b.pose->rotation &&
                                         a.pose->translation == b.pose->translation
                                   : !b.pose;
  return a.kind == b.kind && a.name == b.name && is_same_pose;
}

double beyond(double low, double high, double q) { return std::max(low - q, q - high); }

bool is_in_ranges(const Configuration& configuration, const JointVector& q) {
  return (q.array() >= configuration.low.array() - kRangeSlack).all() &&
         (q.array() <= configuration.high.array() + kRangeSlack).all();
}

void refuse_cut_off(const Dialect& dialect, const std::vector<ProgramText>& texts) {
  for (const ProgramText& text : texts) {
    // A comment would reach to the end of the text.
    if (text.text.find('\r') != std::string::npos && text.text.find('\n') == std::string::npos)
      throw InputError(text.name +
                       ": its lines end with CR alone; save it with LF or CR LF at their ends");
    const auto open = dialect.open_part(text.text);
    if (!open) continue;
    std::string line =
        text.text.substr(open->at, text.text.find_first_of("\r\n", open->at) - open->at);
    shorten(line);
    throw InputError(
        fmt::format("{}:{}: what begins with '{}' has no {}: the text is cut off, as by a copy "
                    "that stopped, or "
                    "the word is missing; copy the file again, or correct it",
                    text.name, line_at(text.text, open->at), line, open->end));
  }
}

RobotProgram parse_program(const Dialect& dialect, std::vector<ProgramText> texts,
                           const KnownFrames& known, TargetParts parts,
                           std::vector<ProgramText> others, ProgramNeighbours neighbours) {
  RobotProgram program;
  program.dialect = &dialect;
  program.neighbours = std::move(neighbours);
  program.texts = std::move(texts);
  program.own_texts = program.texts.size();
  std::ranges::move(others, std::back_inserter(program.texts));
  dialect.parse(program, known, parts);
  program = with_routine_copies(std::move(program), known, parts);
  count_lines_without_copies(program);
  refuse_huge_numbers(program);
  if (!program.targets.empty()) return program;
  throw NoTargets(
      fmt::format("{}: has no move to a point with plain numbers, read as {}{}{}; give the program "
                  "with its points, or its right dialect (compensate --dialect)",
                  program.texts[0].name, dialect.facts().name, program.warnings.empty() ? "" : ": ",
                  program.warnings.empty() ? "" : program.warnings.front()),
      program.why_left_alone);
}

}  // namespace armtrue
