#include "programs/krl_words.h"

#include <algorithm>
#include <cmath>

#include "programs/statement.h"

namespace armtrue {

const KrlKeyword* find_krl_motion(std::string_view name) {
  using enum KrlMotion;
  static constexpr KrlKeyword kMotions[] = {
      {"PTP", point_to_point, false, false},
      {"LIN", line, false, false},
      {"CIRC", circle, false, false},
      {"SPTP", point_to_point, true, false},
      {"SLIN", line, true, false},
      {"SCIRC", circle, true, false},
      {"SPL", spline_point, true, false},
      {"PTP_REL", point_to_point, false, true},
      {"LIN_REL", line, false, true},
      {"CIRC_REL", circle, false, true},
      {"SPTP_REL", point_to_point, true, true},
      {"SLIN_REL", line, true, true},
      {"SCIRC_REL", circle, true, true},
      {"SPL_REL", spline_point, true, true},
  };
  for (const KrlKeyword& keyword : kMotions)
    if (keyword.name == name) return &keyword;
  return nullptr;
}

std::string krl_blending(std::string_view rest, const KrlMove& move) {
  const std::string capitals = upper(rest);
  for (const char* word : {"C_DIS", "C_SPL", "C_VEL", "C_ORI", "C_PTP"})
    if (capitals.find(word) != std::string::npos) return "";
  return move.spline ? " C_SPL" : " C_DIS";
}

bool stands_between_krl_moves(std::string_view text, size_t begin, size_t end,
                              std::string_view word) {
  static constexpr std::string_view kWords[] = {"WAIT",  "BAS",     "CONTINUE", "HALT",     "PULSE",
                                                "ANOUT", "TRIGGER", "SPLINE",   "ENDSPLINE"};
  return std::ranges::find(kWords, word) != std::end(kWords) ||
         is_plain_assignment(text, begin, end);
}

bool krl_circles_turn_with_path(std::string_view text) {
  const std::string capitals = upper(text);
  constexpr std::string_view kName = "CIRC_TYP";
  for (size_t at = capitals.find(kName); at != std::string::npos;
       at = capitals.find(kName, at + 1)) {
    TextCursor cursor(capitals, at + kName.size(), capitals.size());
    if (cursor.next() == 'E') cursor.step();
    cursor.take('=');
    if (cursor.take('#') && cursor.take_name() == "PATH") return true;
  }
  return false;
}

void take_krl_fdat(TextCursor& cursor, std::unordered_map<std::string, KrlFdat>& fdats) {
  const std::string name = cursor.take_name();
  if (!cursor.take('=') || !cursor.take('{')) return;
  KrlFdat fdat;
  const auto number = [&]() -> std::optional<int> {
    constexpr double kMost = 1000;
    const auto value = cursor.take_number();
    if (!value || !(std::abs(*value) < kMost)) return std::nullopt;
    return static_cast<int>(*value);
  };
  while (!cursor.done() && cursor.next() != '}') {
    const std::string entry = cursor.take_name();
    if (entry == "TOOL_NO") fdat.tool = number();
    if (entry == "BASE_NO") fdat.base = number();
    if (entry == "IPO_FRAME" && cursor.take('#'))
      fdat.is_external_tcp = cursor.take_name() == "TCP";
    cursor.skip_to(",}");
    if (!cursor.take(',')) break;
  }
  fdats[name] = fdat;
}

}  // namespace armtrue
