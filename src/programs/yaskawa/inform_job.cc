#include "programs/yaskawa/inform_job.h"

#include <algorithm>
#include <cmath>

#include "programs/text_cursor.h"
#include "programs/yaskawa/inform_positions.h"

namespace armtrue {
namespace {

std::string word_until_blank(std::string_view text, size_t begin) {
  while (begin < text.size() && is_blank(text[begin])) ++begin;
  size_t end = begin;
  while (end < text.size() && !is_blank(text[end]) && text[end] != '\n') ++end;
  return std::string(text.substr(begin, end - begin));
}

}  // namespace

std::vector<Statement> inform_lines(std::string_view job, size_t begin) {
  std::vector<Statement> instructions;
  for (const Statement& line : lines_of(job, begin)) {
    TextCursor cursor(job, line.begin, line.end);
    if (cursor.next() == '+' && !instructions.empty())
      instructions.back().end = line.end;
    else if (cursor.next() != '/')
      instructions.push_back({line.line, cursor.at(), line.end});
  }
  return instructions;
}

size_t inform_instructions(std::string_view job) {
  return std::min(line_that_begins(job, "//INST"), job.size());
}

std::optional<std::string> inform_job_name(std::string_view job) {
  const size_t line = line_that_begins(job, "//NAME");
  if (line == std::string_view::npos) return std::nullopt;
  return word_until_blank(job, line + 6);
}

std::optional<int> inform_robot(std::string_view job) {
  const size_t line = line_that_begins(job, "///GROUP1");
  if (line == std::string_view::npos) return 1;
  const std::string group = word_until_blank(job, line + 9);  // RB1, or RB1,BS1
  constexpr size_t kDigit = 2;
  if (!group.starts_with("RB") || group.size() <= kDigit || !is_digit(group[kDigit]))
    return std::nullopt;
  return group[kDigit] - '0';
}

bool is_inform_move(const std::string& word) {
  return contains({"MOVJ", "MOVL", "MOVC", "MOVS", "SMOVL", "SMOVC", "SMOVS"}, word);
}

bool is_other_inform_motion(const std::string& word) {
  return contains({"IMOV", "EIMOVL", "EIMOVC", "SYMOVJ", "SYMOVL", "SYMOVC"}, word);
}

void note_inform_changes(std::string_view job, const Statement& statement, bool with_frames,
                         InformChanges& changes) {
  const std::string first = TextCursor(job, statement.begin, statement.end).take_name();
  // They only read a variable.
  if (is_inform_move(first) || is_other_inform_motion(first) || first == "SFTON") return;
  std::set<int>* frames = first == "MFRAME"    ? &changes.users
                          : first == "SETTOOL" ? &changes.tools
                                               : nullptr;
  if (frames && !with_frames) return;
  bool is_set = first != "MFRAME";  // the first one that is named; the others are read
  each_word(job, statement, [&](const std::string& word, size_t, TextCursor behind) {
    if (frames && (word == "UF" || word == "TL")) {
      behind.take('#');
      behind.take('(');
      const auto number = behind.take_number();
      const bool is_known = number && std::abs(*number) < InformChanges::kAnyFrame;
      frames->insert(is_known ? static_cast<int>(*number) : InformChanges::kAnyFrame);
    }
    const bool is_all = word.starts_with("PX");
    const std::string name = inform_position_name(is_all ? "P" + word.substr(2) : word);
    const bool is_any = (word == "P" || word == "PX") && behind.next() == '[';
    if (!is_any && !name.starts_with('P')) return;
    if (is_set && is_any) changes.is_any_variable = true;
    if (is_set && !is_any) changes.variables.insert(name);
    is_set = false;
  });
}

std::vector<std::string> inform_calls(std::string_view job, const Statement& statement) {
  std::vector<std::string> names;
  each_word(job, statement, [&](const std::string& word, size_t, const TextCursor& cursor) {
    if (word != "CALL" && word != "PSTART") return;
    const size_t behind = job.find("JOB:", cursor.at());
    names.push_back(behind < statement.end ? word_until_blank(job, behind + 4) : "");
  });
  return names;
}

}  // namespace armtrue
