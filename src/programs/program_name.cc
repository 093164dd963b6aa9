#include <fmt/format.h>

#include "armtrue/programs/dialect.h"
#include "programs/text_cursor.h"
#include "programs/text_edit.h"

namespace armtrue {
namespace {

bool is_plain_letter(char c) { return is_letter(c) && c != '$'; }

}  // namespace

std::string why_illegal_name(const Dialect& dialect, const std::string& name) {
  const NameRule& rule = dialect.facts().names;
  if (rule.longest == 0) return "";
  std::string legal;
  for (char c : name) {
    const bool is_legal =
        is_plain_letter(c) || is_digit(c) || rule.others.find(c) != std::string::npos;
    legal += is_legal ? c : '_';
  }
  if (legal.empty() || (is_digit(legal[0]) && !rule.may_begin_with_digit)) legal.insert(0, 1, 'P');
  legal = legal.substr(0, rule.longest);
  if (legal == name) return "";
  std::string others;
  for (const char c : rule.others) others += fmt::format(", '{}'", c);
  return fmt::format(
      "'{}' is no name for a {} program, which has at most {} letters a to z, digits{} and "
      "underscores{}; use '{}'",
      name, dialect.facts().maker, rule.longest, others,
      rule.may_begin_with_digit ? "" : " and begins with no digit", legal);
}

void rename(const RobotProgram& program, const std::string& name, std::vector<std::string>& texts) {
  for (size_t i = 0; i < texts.size(); ++i) {
    std::vector<TextEdit> edits;
    for (const ProgramName& place : program.names) {
      if (place.text != static_cast<int>(i)) continue;
      const std::string now = program.texts[i].text.substr(place.begin, place.end - place.begin);
      if (upper(now) == upper(name)) continue;
      // Behind a change, the name is no longer where it was.
      if (texts[i].compare(0, place.end, program.texts[i].text, 0, place.end) != 0) continue;
      edits.push_back({place.text, place.begin, place.end,
                       program.dialect->facts().names.are_capitals ? upper(name) : name});
    }
    // Names stand before all points, whose numbers may have changed.
    texts[i] = apply_edits(texts[i], edits, static_cast<int>(i));
  }
}

}  // namespace armtrue
