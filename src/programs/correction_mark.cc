#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "armtrue/programs/robot_program.h"
#include "programs/insertion.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"
#include "programs/written_number.h"

// What a correction leaves in a program. A comment stays in a program that is loaded, run and read
// back: KUKA `;`, FANUC and ABB `!`, UR `#`. FANUC takes at most 32 characters.

namespace armtrue {
namespace {

std::string mark_of(Corrector by) {
  return by == Corrector::mirror ? "corrected by armtrue mirror" : "corrected by armtrue compensate";
}

const char* comment_of(Dialect dialect) {
  switch (dialect) {
    case Dialect::krl:
      return ";";
    case Dialect::urscript:
      return "#";
    case Dialect::rapid:
    case Dialect::fanuc:
      break;
  }
  return "!";
}

bool begins_program(Dialect dialect, TextCursor line) {
  std::string word = line.take_name();
  if (word == "GLOBAL") word = line.take_name();
  switch (dialect) {
    case Dialect::krl:
      return word == "DEF" || word == "DEFFCT" || word == "DEFDAT";
    case Dialect::rapid:
      return word == "MODULE";
    case Dialect::urscript:
      return word == "DEF";
    case Dialect::fanuc:
      break;
  }
  return false;
}

// Behind the line that begins the program; where none does, at the beginning of the text.
void insert_comment(Dialect dialect, const std::string& comment, std::string& text) {
  size_t place = 0;
  for (size_t begin = 0; begin < text.size() && place == 0;) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    if (begins_program(dialect, TextCursor(text, begin, end))) place = end + 1;
    begin = end + 1;
  }
  // MODULE part(SYSMODULE, .. on several lines
  const std::string_view head = std::string_view(text).substr(0, std::min(place, text.size()));
  if (const size_t open = head.rfind('('); place > 0 && open != std::string::npos &&
                                           head.find(')', open) == std::string::npos)
    place = text.find('\n', std::min(text.find(')', open), text.size())) + 1;
  if (place > text.size()) return;  // a text of one line, which has no moves
  text.insert(place, comment + line_end(text, 0));
}

// As the last instruction of /MN, with its number.
void insert_remark(const std::string& remark, std::string& text) {
  const size_t first = line_that_begins(text, "/MN");
  size_t place = 0, width = 0;
  double number = 0;
  for (size_t begin = first; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    if (begin > first && text[begin] == '/') break;
    TextCursor cursor(text, begin, end);
    const auto value = cursor.take_number();
    const size_t behind = cursor.at();
    if (value && cursor.next() == ':') {
      number = *value;
      width = behind - begin;
    }
    if (value || width > 0) place = end + 1;
    begin = end + 1;
  }
  if (place == 0 || place > text.size()) return;
  text.insert(place, fmt::format("{:>{}}:  {} ;{}", number + 1, width, remark, line_end(text, 0)));
  const size_t count = text.find("LINE_COUNT", std::min(line_that_begins(text, "/ATTR"), first));
  if (count >= first) return;
  TextCursor cursor(text, count + 10, std::min(text.find('\n', count), text.size()));
  if (!cursor.take('=')) return;
  cursor.next();
  const size_t begin = cursor.at();
  if (const auto lines = cursor.take_number())
    text.replace(begin, cursor.at() - begin, fmt::format("{}", *lines + 1));
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

void mark_corrected(Dialect dialect, Corrector by, std::string& text) {
  const std::string comment = comment_of(dialect) + mark_of(by);
  if (dialect == Dialect::fanuc)
    insert_remark(comment, text);
  else
    insert_comment(dialect, comment, text);
}

void mark_corrected(const RobotProgram& program, Corrector by, std::vector<std::string>& texts) {
  for (size_t i = 0; i < program.own_texts; ++i)
    if (texts[i] != program.texts[i].text) mark_corrected(program.dialect, by, texts[i]);
}

std::optional<CorrectionMark> find_correction_mark(const std::vector<ProgramText>& texts,
                                                   Corrector by) {
  for (const ProgramText& text : texts) {
    int number = 1;
    for (size_t begin = 0; begin < text.text.size(); ++number) {
      const size_t end = std::min(text.text.find('\n', begin), text.text.size());
      const std::string line = plain(std::string_view(text.text).substr(begin, end - begin));
      if (line.find(mark_of(by)) != std::string::npos) return CorrectionMark{text.name, number};
      begin = end + 1;
    }
  }
  return std::nullopt;
}

bool has_check_digits(const RobotProgram& program, Corrector by) {
  CheckDigits digits(CheckSize::digits, by), rounded(CheckSize::quarter, by);
  for (const ProgramPoint& point : program.points)
    for (size_t i = 0; i < point.numbers.size(); ++i) {
      const ProgramNumber& number = point.numbers[i];
      const NumberCheck check = number_check(program.dialect, point.kind, i);
      if (!number.is_written()) continue;
      if (check.rounded > 0) rounded.add_rounded(number.value, check.rounded);
      if (check.decimals == 0) continue;
      std::string_view text = program.texts[number.text].text;
      text = text.substr(number.begin, number.end - number.begin);
      const int written = written_decimals(text.substr(0, text.find_last_not_of('0') + 1));
      digits.add(number.value, std::max(written, check.decimals));
    }
  return digits.are_found() || rounded.are_found();
}

}  // namespace armtrue
