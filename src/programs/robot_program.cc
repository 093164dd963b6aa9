#include "armtrue/programs/robot_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "armtrue/text/input_error.h"
#include "programs/dialects.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

struct DialectName {
  Dialect dialect;
  const char* name;
  std::array<const char*, 5> extensions;  // in capitals
};

constexpr DialectName kDialectNames[] = {
    {Dialect::krl, "krl", {".SRC", "", "", "", ""}},
    {Dialect::rapid, "rapid", {".MOD", ".PRG", ".SYS", ".MODX", ".SYSX"}},
    {Dialect::fanuc, "fanuc", {".LS", "", "", "", ""}},
    {Dialect::urscript, "urscript", {".SCRIPT", ".URSCRIPT", "", "", ""}},
};

// 100 km, or a million turns: beyond, circles through points are lost in rounding.
constexpr double kFarthest = 1e8;

void refuse_huge_numbers(const RobotProgram& program) {
  for (const ProgramPoint& point : program.points)
    for (const ProgramNumber& number : point.numbers)
      if (number.is_written() && !(std::abs(number.value) < kFarthest))
        throw InputError(fmt::format("{}:{}: a number of the point {} is too large; correct it",
                                     program.texts[static_cast<size_t>(number.text)].name,
                                     point.line, point.name));
}

}  // namespace

bool is_in_ranges(const Configuration& configuration, const JointVector& q) {
  return (q.array() >= configuration.low.array() - kRangeSlack).all() &&
         (q.array() <= configuration.high.array() + kRangeSlack).all();
}

std::string to_string(Dialect dialect) {
  return std::ranges::find(kDialectNames, dialect, &DialectName::dialect)->name;
}

std::optional<Dialect> find_dialect(const std::string& name) {
  for (const DialectName& known : kDialectNames)
    if (name == known.name) return known.dialect;
  return std::nullopt;
}

std::optional<Dialect> dialect_of_file(const std::string& path) {
  const size_t point = path.find_last_of("./");
  if (point == std::string::npos || path[point] != '.') return std::nullopt;
  const std::string extension = upper(path.substr(point));
  for (const DialectName& known : kDialectNames)
    if (std::ranges::find(known.extensions, extension) != known.extensions.end())
      return known.dialect;
  return std::nullopt;
}

RobotProgram parse_program(Dialect dialect, std::vector<ProgramText> texts,
                           const KnownFrames& known, TargetParts parts,
                           std::vector<ProgramText> others) {
  RobotProgram program;
  program.dialect = dialect;
  program.texts = std::move(texts);
  program.own_texts = program.texts.size();
  std::ranges::move(others, std::back_inserter(program.texts));
  switch (dialect) {
    case Dialect::krl:
      parse_krl_program(program, known, parts);
      break;
    case Dialect::rapid:
      parse_rapid_program(program, known, parts);
      break;
    case Dialect::fanuc:
      parse_fanuc_program(program, known, parts);
      break;
    case Dialect::urscript:
      parse_urscript_program(program, known, parts);
      break;
  }
  refuse_huge_numbers(program);
  if (!program.targets.empty()) return program;
  throw NoTargets(
      fmt::format("{}: has no move to a point with plain numbers, read as {}{}{}; give the program "
                  "with its points, or its right dialect (compensate --dialect)",
                  program.texts[0].name, to_string(dialect), program.warnings.empty() ? "" : ": ",
                  program.warnings.empty() ? "" : program.warnings.front()),
      program.why_left_alone);
}

}  // namespace armtrue
