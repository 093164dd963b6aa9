#include "armtrue/programs/corrected_already.h"

#include <fmt/format.h>

#include <algorithm>

namespace armtrue {
namespace {

constexpr Corrector kCorrectors[] = {Corrector::compensate, Corrector::mirror};

}  // namespace

const std::string& instead_of_corrected(Corrector by) {
  static const std::string kCompensated =
      "give the original one, also after a new calibration; what a pass of the corrected program "
      "still shows is for mirror-correct --program";
  static const std::string kMirrored =
      "give the original program; to use both, compensate the original, measure a pass of the "
      "compensated program, and give that program to mirror-correct --program";
  return by == Corrector::mirror ? kMirrored : kCompensated;
}

void refuse_mark(const std::vector<ProgramText>& texts, Corrector by, const std::string& instead) {
  if (const auto mark = find_correction_mark(texts, by))
    throw CorrectedAlready(fmt::format(
        "{}:{}: this comment says that the program is corrected already; corrected twice, it would "
        "be wrong: {}",
        mark->text, mark->line, instead));
}

void refuse_check_digits(const RobotProgram& program, Corrector by, const std::string& instead) {
  if (has_check_digits(program, by))
    throw CorrectedAlready(fmt::format(
        "{}: the last digits of its numbers are those that {} writes: it is corrected already; "
        "corrected twice, it would be wrong: {}",
        program.texts[0].name, by == Corrector::mirror ? "mirror-correct" : "compensate", instead));
}

void refuse_corrected_texts(const std::vector<ProgramText>& texts) {
  for (const Corrector by : kCorrectors) refuse_mark(texts, by, instead_of_corrected(by));
}

void refuse_corrected_points(const RobotProgram& program) {
  std::vector<ProgramText> declaring;
  for (size_t i = program.own_texts; i < program.texts.size(); ++i)
    if (std::ranges::any_of(program.points, [&](const ProgramPoint& point) {
          return point.text == static_cast<int>(i);
        }))
      declaring.push_back(program.texts[i]);
  refuse_corrected_texts(declaring);
  for (const Corrector by : kCorrectors) refuse_check_digits(program, by, instead_of_corrected(by));
}

}  // namespace armtrue
