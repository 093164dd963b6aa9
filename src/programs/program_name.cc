#include <fmt/format.h>

#include "armtrue/programs/dialect.h"
#include "programs/text_cursor.h"
#include "programs/text_edit.h"

namespace armtrue {
namespace {

bool is_plain_letter(char c) { return is_letter(c) && c != '$'; }

}  // namespace

std::string why_illegal_name(const Dialect& dialect, const std::string& name) {
  const size_t most = dialect.facts().longest_name;
  if (most == 0) return "";
  std::string legal;
  for (char c : name) legal += is_plain_letter(c) || is_digit(c) ? c : '_';
  if (legal.empty() || is_digit(legal[0])) legal.insert(0, 1, 'P');
  legal = legal.substr(0, most);
  if (legal == name) return "";
  return fmt::format(
      "'{}' is no name for a {} program, which has at most {} letters a to z, digits and "
      "underscores and begins with no digit; use '{}'",
      name, dialect.facts().maker, most, legal);
}

void rename(const RobotProgram& program, const std::string& name, std::vector<std::string>& texts) {
  for (size_t i = 0; i < texts.size(); ++i) {
    std::vector<TextEdit> edits;
    for (const ProgramName& place : program.names) {
      if (place.text != static_cast<int>(i)) continue;
      const std::string now = program.texts[i].text.substr(place.begin, place.end - place.begin);
      if (upper(now) == upper(name)) continue;
      edits.push_back({place.text, place.begin, place.end,
                       program.dialect->facts().has_capital_names ? upper(name) : name});
    }
    // Names stand before all points, whose numbers may have changed.
    texts[i] = apply_edits(texts[i], edits, static_cast<int>(i));
  }
}

}  // namespace armtrue
