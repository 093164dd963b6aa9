#include "programs/kuka/krl_words.h"

#include <algorithm>

#include "programs/statement.h"

namespace armtrue {
namespace {

// Pluses in place of operators and functions of KRL: a name before a bracket is called then.
std::string without_functions(std::string_view statement) {
  std::string text = masked(statement, ';', "\"");
  for (size_t i = 0; i < text.size(); ++i) {
    if (!is_letter(text[i])) continue;
    const size_t begin = i;
    while (i < text.size() && (is_letter(text[i]) || is_digit(text[i]))) ++i;
    if (contains({"NOT", "AND",  "OR",    "EXOR",    "B_NOT",   "B_AND",   "B_OR", "B_EXOR",
                  "DIV", "MOD",  "TO",    "STEP",    "ABS",     "SQRT",    "SIN",  "COS",
                  "TAN", "ACOS", "ATAN2", "INVERSE", "FORWARD", "VARSTATE"},
                 upper(std::string_view(text).substr(begin, i - begin))))
      text.replace(begin, i - begin, i - begin, '+');
  }
  return text;
}

}  // namespace

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

std::vector<KrlCall> krl_calls(std::string_view source) {
  std::vector<KrlCall> calls;
  for (const Statement& line : lines_of(source)) {
    TextCursor cursor(source, line.begin, line.end);
    cursor.next();
    const size_t statement = cursor.at();
    if (contains({"GLOBAL", "DEF", "DEFFCT", "EXT", "EXTFCT", "DECL", "INTERRUPT", "TRIGGER"},
                 TextCursor(cursor).take_name()))
      continue;
    each_word(source, {line.line, statement, line.end},
              [&](const std::string& word, size_t at, TextCursor& behind) {
                if (behind.next() == '(')
                  calls.push_back({word, line.line, statement, at == statement});
              });
  }
  return calls;
}

std::optional<KrlHead> krl_head(std::string_view text, const Statement& line) {
  TextCursor cursor(text, line.begin, line.end);
  KrlHead head;
  head.word = cursor.take_name();
  for (; contains({"DECL", "GLOBAL", "CONST"}, head.word); head.word = cursor.take_name())
    head.is_global |= head.word == "GLOBAL";
  if (!begins_krl_routine(head.word) && head.word != "DEFDAT") return std::nullopt;
  if (head.word == "DEFFCT") cursor.take_name();  // its type
  cursor.next();
  head.begin = cursor.at();
  head.name = cursor.take_name();
  head.end = cursor.at();
  return head;
}

bool begins_krl_routine(std::string_view word) { return word == "DEF" || word == "DEFFCT"; }

bool is_krl_frame_list(std::string_view name) {
  if (!name.starts_with("BASE_DATA[") && !name.starts_with("TOOL_DATA[")) return false;
  const std::string_view index = name.substr(name.find('[') + 1);
  return index.find_first_not_of("0123456789") == index.size() - 1 && index.ends_with(']');
}

bool begins_krl_loop(std::string_view word) {
  return contains({"LOOP", "FOR", "WHILE", "REPEAT"}, word);
}

bool ends_krl_loop(std::string_view word) {
  return contains({"ENDLOOP", "ENDFOR", "ENDWHILE", "UNTIL"}, word);
}

bool takes_krl_assignment(TextCursor& cursor) {
  while (cursor.next() == '[' || cursor.next() == '.')
    if (cursor.take('.')) {
      cursor.take_name();
    } else {
      cursor.skip_to("]");
      cursor.take(']');
    }
  return cursor.take('=') && cursor.next() != '=';
}

bool is_krl_assignment(std::string_view statement) {
  const std::string text = without_functions(statement);
  return is_plain_assignment(text, 0, text.size());
}

bool leaves_krl_arm(std::string_view statement, std::string_view word) {
  // Functions that KUKA delivers: collision detection (KSS 8.x inline forms call it before each
  // move), messages, errors of KRL.
  if (contains({"SET_CD_PARAMS", "USE_CM_PRO_SETTING", "SET_CM_PRO_INACTIVE", "MSGNOTIFY",
                "MSGQUIT", "MSGSTATE", "MSGDIALOG", "ERR_CLEAR", "ERR_RAISE"},
               word))
    return true;
  if (contains(
          {"WAIT",       "BAS",    "CONTINUE",  "HALT",       "PULSE",     "ANIN",    "ANOUT",
           "DIGIN",      "SPLINE", "ENDSPLINE", "PTP_SPLINE", "CONST_VEL", "TRIGGER", "STOP",
           "TIME_BLOCK", "COPEN",  "CCLOSE",    "CREAD",      "CWRITE",    "SREAD",   "SWRITE"},
          word))
    return true;
  const bool is_branch = begins_krl_loop(word) || ends_krl_loop(word) ||
                         contains({"IF", "ELSE", "ENDIF", "SWITCH", "CASE", "DEFAULT", "ENDSWITCH",
                                   "EXIT", "END", "ENDFCT", "GOTO", "RETURN"},
                                  word);
  if (!is_branch) return is_krl_assignment(statement);
  return is_krl_assignment("X=" + std::string(statement.substr(word.size())));
}

bool krl_states_mode(std::string_view text, std::string_view name, std::string_view value) {
  const std::string capitals = upper(text);
  for (size_t at = capitals.find(name); at != std::string::npos; at = capitals.find(name, at + 1)) {
    TextCursor cursor(capitals, at + name.size(), capitals.size());
    if (cursor.next() == 'E') cursor.step();
    cursor.take('=');
    if (cursor.take('#') && cursor.take_name() == value) return true;
  }
  return false;
}

void take_krl_ldat(TextCursor& cursor, std::unordered_map<std::string, double>& ldats) {
  const std::string name = cursor.take_name();
  if (!cursor.take('=') || !cursor.take('{')) return;
  while (!cursor.done() && cursor.next() != '}') {
    if (cursor.take_name() == "APO_DIST")
      if (const auto distance = cursor.take_number()) ldats[name] = *distance;
    cursor.skip_to(",}");
    if (!cursor.take(',')) break;
  }
}

}  // namespace armtrue
