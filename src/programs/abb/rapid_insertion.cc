#include "programs/abb/rapid_insertion.h"

#include <algorithm>
#include <cmath>

namespace armtrue {
namespace {

std::string why_not_inserted(const RobotProgram& program, const std::string& masked,
                             const RapidMoveText& move, const RapidExternalAxes& external,
                             const ProgramTarget& target, const std::vector<int>& points,
                             size_t line) {
  const auto has = [&](const char* option) {
    return std::ranges::find(move.options, option) != move.options.end();
  };
  if (target.kind == TargetKind::joints) return "its point is joint angles";
  for (int point : points)
    if (program.points[point].is_expression) return "its point is an expression";
  if (std::string(move.kind_of->name).starts_with("TRIGG"))
    return "its events count from its start";
  if (move.kind_of->is_process()) return "its process begins, changes or ends with it";
  if (has("T")) return "its speed is a time (\\T)";
  if (has("ID")) return "it is synchronised with another arm (\\ID)";
  TextCursor before(masked, line, move.begin);
  if (!move.is_first || !before.done()) return "it does not begin its line";
  constexpr double kMost = 8;
  for (int point : points)
    for (const ProgramNumber& number : program.points[point].configuration)
      if (number.value != std::floor(number.value) || std::abs(number.value) > kMost)
        return "the confdata of its point is no plain one";
  // The auxiliary point of an arc is a target already.
  const size_t begin = program.targets.size() - std::min(program.targets.size(), points.size());
  const auto here = external.find(points.back());
  if (here == external.end() || program.targets.empty()) return "its external axes are unknown";
  const auto before_it = external.find(program.targets[begin].point);
  if (before_it == external.end() || before_it->second != here->second) return "external axes move";
  return "";
}

}  // namespace

void prepare_rapid_insertion(const RobotProgram& program, const std::string& masked,
                             const RapidMoveText& move, const RapidExternalAxes& external,
                             const std::vector<int>& points,
                             const std::vector<Statement>& arguments, ProgramTarget& target) {
  const std::string& original = program.texts[0].text;
  const size_t line = line_begin(original, move.begin);
  target.obstacle = why_not_inserted(program, masked, move, external, target, points, line);
  if (!target.obstacle.empty()) return;
  const size_t tool = move.kind_of->tool;
  const Statement &zone = move.parts[tool - 1], &last = move.parts[tool];
  const auto text = [&](size_t begin, size_t end) {
    std::string part = masked.substr(begin, end - begin);
    std::ranges::replace(part, '\r', ' ');
    return part;
  };
  const std::string plain = std::string("Move") + move.kind();
  const bool is_plain = upper(plain) == move.kind_of->name;
  const size_t keyword = move.begin + std::string(move.kind_of->name).size();
  const Statement& end = arguments[points.size() - 1];
  target.insertion.at = line;
  target.insertion.before = (is_plain ? text(line, keyword) : text(line, move.begin) + plain) +
                            text(keyword, arguments[0].begin);
  if (points.size() > 1) target.insertion.middle = text(arguments[0].end, end.begin);
  target.insertion.behind = text(end.end, zone.begin) +
                            (target.blend > 0 ? text(zone.begin, zone.end) : "z1") +
                            text(zone.end, is_plain ? move.end : last.end) + ";";
  target.insertion.line_end = line_end(original, move.end);
}

}  // namespace armtrue
