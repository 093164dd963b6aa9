#include "programs/abb/rapid_words.h"

#include <algorithm>
#include <map>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr int kLast = RapidMove::kLast;

constexpr RapidMove kRapidMoves[] = {
    {"MOVEJ", 1, 3, false},
    {"MOVEL", 1, 3, false},
    {"MOVEC", 2, 4, false},
    {"MOVEABSJ", 1, 3, true},
    {"MOVEJDO", 1, 3, false},
    {"MOVELDO", 1, 3, false},
    {"MOVECDO", 2, 4, false},
    {"MOVEJAO", 1, 3, false},
    {"MOVELAO", 1, 3, false},
    {"MOVECAO", 2, 4, false},
    {"MOVEJGO", 1, 3, false},
    {"MOVELGO", 1, 3, false},
    {"MOVECGO", 2, 4, false},
    {"MOVEJSYNC", 1, 3, false},
    {"MOVELSYNC", 1, 3, false},
    {"MOVECSYNC", 2, 4, false},
    {"TRIGGJ", 1, 4, false},
    {"TRIGGL", 1, 4, false},
    {"TRIGGC", 2, 5, false},
    // Process moves: points, speed, data of the process, zone (not of SpotL and SpotJ), tool; older
    // ones have one more argument, as ArcL\On,p1,v100,seam1,weld1,weave1,z10,tool1 (application
    // manuals Arc, Dispensing, Spot, CAP, Paint).
    {"ARCL", 1, kLast, false},
    {"ARCC", 2, kLast, false},
    {"ARCLSTART", 1, kLast, false},
    {"ARCCSTART", 2, kLast, false},
    {"ARCLEND", 1, kLast, false},
    {"ARCCEND", 2, kLast, false},
    {"ARCMOVEL", 1, kLast, false},
    {"ARCMOVEJ", 1, kLast, false},
    {"ARCMOVEC", 2, kLast, false},
    {"ARCMOVEABSJ", 1, kLast, true},
    {"DISPL", 1, kLast, false},
    {"DISPC", 2, kLast, false},
    {"SPOTL", 1, kLast, false},
    {"SPOTJ", 1, kLast, false},
    {"PAINTL", 1, kLast, false},
    {"PAINTC", 2, kLast, false},
    {"CAPL", 1, kLast, false},
    {"CAPC", 2, kLast, false},
};

// Where each bracket that opens is closed.
std::map<size_t, size_t> closing_brackets(std::string_view text) {
  std::map<size_t, size_t> closing;
  std::vector<size_t> open;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '(') open.push_back(i);
    if (text[i] != ')' || open.empty()) continue;
    closing[open.back()] = i;
    open.pop_back();
  }
  return closing;
}

}  // namespace

const RapidMove* find_rapid_move(const std::string& name) {
  const auto* const move = std::ranges::find(kRapidMoves, name, &RapidMove::name);
  return move == std::end(kRapidMoves) ? nullptr : move;
}

bool is_other_rapid_move(const std::string& word, TextCursor cursor) {
  // Only an instruction has an argument behind it; data of a like name stand in expressions.
  const char next = cursor.next();
  if (next != '[' && next != '\\' && next != '*' && cursor.take_name().empty()) return false;
  for (const char* begin : {"MOVE", "TRIGG", "SEARCH", "ARC", "SPOT", "DISP", "PAINT", "CAP"})
    if (word.starts_with(begin) && word.size() > std::string(begin).size()) {
      const char last = word.back();
      return last == 'L' || last == 'J' || last == 'C' || word.ends_with("START") ||
             word.ends_with("END") || word.ends_with("IOS");
    }
  return false;
}

bool stands_between_rapid_moves(const std::string& word) {
  return contains(
      {"CONST",       "PERS",       "VAR",        "SET",        "RESET",      "SETDO",
       "SETAO",       "SETGO",      "PULSEDO",    "INVERTDO",   "WAITTIME",   "WAITDI",
       "WAITDO",      "WAITGI",     "WAITAI",     "WAITUNTIL",  "TPWRITE",    "TPERASE",
       "CONFL",       "CONFJ",      "SINGAREA",   "ACCSET",     "VELSET",     "CLKSTART",
       "CLKSTOP",     "CLKRESET",   "GRIPLOAD",   "INCR",       "DECR",       "ADD",
       "CLEAR",       "TRIGGIO",    "TRIGGINT",   "TRIGGEQUIP", "TRIGGSPEED", "PATHRESOL",
       "CIRPATHMODE", "PATHACCLIM", "WORLDACCLIM"},
      word);
}

bool begins_rapid_routine(const std::string& word) {
  return word == "PROC" || word == "FUNC" || word == "TRAP";
}

bool is_rapid_declaration(const std::string& word) {
  return word == "CONST" || word == "PERS" || word == "VAR";
}

bool ends_rapid_routine(const std::string& word) {
  return word == "ENDPROC" || word == "ENDFUNC" || word == "ENDTRAP";
}

std::string take_rapid_routine(const std::string& word, TextCursor& cursor) {
  if (word == "FUNC") cursor.take_name();
  return cursor.take_name();
}

void skip_rapid_part(TextCursor& cursor) {
  while (cursor.next() == '.' || cursor.next() == '{')
    if (cursor.take('.')) {
      cursor.take_name();
    } else {
      cursor.skip_to("}");
      cursor.take('}');
    }
}

bool takes_rapid_assignment(TextCursor& cursor) {
  skip_rapid_part(cursor);
  return cursor.take(':') && cursor.take('=');
}

bool names_rapid_parameter(std::string_view text, const Statement& statement, size_t at) {
  std::string before, last;  // words or characters before it
  for (TextCursor cursor(text, statement.begin, at); !cursor.done();) {
    before = std::exchange(last, cursor.take_name());
    if (!last.empty()) continue;
    last = cursor.next();
    cursor.step();
  }
  if (last == "," || last == "(") return true;
  // An instruction before it; not the end of a condition, IF a=b x:=1, or of the head of a TRAP.
  return !last.empty() && is_letter(last[0]) &&
         !contains({"THEN", "ELSE", "DO", "ENDIF", "ENDFOR", "ENDWHILE", "ENDTEST", "ERROR", "UNDO",
                    "BACKWARD"},
                   last) &&
         !contains({"IF", "ELSEIF", "AND", "OR", "NOT", "XOR", "DIV", "MOD", "TRAP", "=",
                    "<",  ">",      "+",   "-",  "*",   "/",   "(",   ",",   ".",    "\\"},
                   before);
}

std::string masked_rapid(const std::string& module) {
  std::string text = masked(module, '!', "\"");
  const Statement whole{0, 0, text.size()};
  std::set<std::string> procedures;
  each_word(text, whole, [&](const std::string& word, size_t, TextCursor cursor) {
    if (word == "PROC") procedures.insert(cursor.take_name());
  });
  const std::map<size_t, size_t> closing = closing_brackets(text);
  std::string before;
  std::vector<std::pair<size_t, size_t>> brackets;
  each_word(text, whole, [&](const std::string& word, size_t, TextCursor cursor) {
    const bool is_head = std::exchange(before, word) == "PROC";
    if (is_head || cursor.next() != '(' || !procedures.contains(word)) return;
    const auto bracket = closing.find(cursor.at());
    if (bracket == closing.end()) return;
    TextCursor behind(text, bracket->second + 1, text.size());
    const char next = behind.next();
    if (next == ';' || next == ',' || next == '\\') brackets.push_back(*bracket);
  });
  for (const auto& [open, close] : brackets) text[open] = text[close] = ' ';
  return text;
}

ArcTurning rapid_turning(TextCursor cursor) {
  if (!cursor.take('\\')) return ArcTurning::with_path;
  const std::string mode = cursor.take_name();
  if (mode == "PATHFRAME") return ArcTurning::with_path;
  return mode == "OBJECTFRAME" ? ArcTurning::in_frame : ArcTurning::perhaps_through_via;
}

double radius_of_rapid_zone(const std::string& zone) {
  static const std::map<std::string, double> kZones{
      {"Z0", 0.3}, {"Z1", 1},     {"Z5", 5},     {"Z10", 10},  {"Z15", 15},
      {"Z20", 20}, {"Z30", 30},   {"Z40", 40},   {"Z50", 50},  {"Z60", 60},
      {"Z80", 80}, {"Z100", 100}, {"Z150", 150}, {"Z200", 200}};
  const auto found = kZones.find(zone);
  return found == kZones.end() ? 0 : found->second * kMillimetre;
}

}  // namespace armtrue
