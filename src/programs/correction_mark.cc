#include <algorithm>
#include <string_view>

#include "armtrue/programs/dialect.h"
#include "programs/point_numbers.h"
#include "programs/routine_copies.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

// The mark of a correction. A comment stays in a program that is loaded, run and read back. FANUC
// takes at most 32 characters.

namespace armtrue {
namespace {

std::string mark_of(Corrector by) {
  return by == Corrector::mirror ? "corrected by armtrue mirror" : "corrected by armtrue compensate";
}

// In small letters, with one blank between words.
std::string plain(std::string_view line) {
  std::string result;
  for (const char c : line) {
    if (is_blank(c) || c == '\r') {
      if (!result.empty() && result.back() != ' ') result += ' ';
    } else {
      result += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    }
  }
  return result;
}

}  // namespace

void mark_corrected(const Dialect& dialect, Corrector by, std::string& text) {
  dialect.add_comment(mark_of(by), text);
}

void mark_corrected(const RobotProgram& program, Corrector by, std::vector<std::string>& texts) {
  for (size_t i = 0; i < program.own_texts; ++i)
    if (texts[i] != text_without_copies(program, i)) mark_corrected(*program.dialect, by, texts[i]);
}

std::optional<CorrectionMark> find_correction_mark(const std::vector<ProgramText>& texts,
                                                   Corrector by) {
  for (const ProgramText& text : texts)
    for (const auto& [line, begin, end] : lines_of(text.text))
      if (plain(std::string_view(text.text).substr(begin, end - begin)).find(mark_of(by)) !=
          std::string::npos)
        return CorrectionMark{text.name, line};
  return std::nullopt;
}

bool has_check_digits(const RobotProgram& program, Corrector by) {
  CheckDigits digits(CheckSize::digits, by), rounded(CheckSize::quarter, by);
  for (const ProgramPoint& point : program.points) {
    if (is_in_routine_copy(program, point)) continue;  // the same numbers again
    for (size_t i = 0; i < point.numbers.size(); ++i) {
      const ProgramNumber& number = point.numbers[i];
      const NumberCheck check = program.dialect->check(point.kind, i);
      if (!number.is_written()) continue;
      if (check.rounded > 0) rounded.add_rounded(number.value, check.rounded);
      if (check.decimals == 0) continue;
      std::string_view text = program.texts[number.text].text;
      text = text.substr(number.begin, number.end - number.begin);
      const int written = written_decimals(text.substr(0, text.find_last_not_of('0') + 1));
      digits.add(number.value, std::max(written, check.decimals));
    }
  }
  return digits.are_found() || rounded.are_found();
}

}  // namespace armtrue
