#include "programs/abb/rapid_calls.h"

#include <algorithm>
#include <utility>

#include "programs/abb/rapid_words.h"

namespace armtrue {
namespace {

// Instructions and functions of RAPID that change no numbers, positions, points or frames among
// their arguments (RAPID reference manual).
bool is_reading(std::string_view word) {
  return contains({"ABS",           "ABSDNUM",      "ACOS",        "ASIN",
                   "ATAN",          "ATAN2",        "CALCJOINTT",  "CALCROBT",
                   "CORRWRITE",     "COS",          "CPOS",        "CROBT",
                   "CROSSPROD",     "DEFDFRAME",    "DEFFRAME",    "DIM",
                   "DISTANCE",      "DNUMTONUM",    "DNUMTOSTR",   "DOTPROD",
                   "EOFFSON",       "EOFFSSET",     "ERRLOG",      "ERRWRITE",
                   "EULERZYX",      "EXP",          "GRIPLOAD",    "MAX",
                   "MECHUNITLOAD",  "MIN",          "MIRPOS",      "NORIENT",
                   "NUMTODNUM",     "NUMTOSTR",     "OFFS",        "ORIENTZYX",
                   "OROBT",         "PACKRAWBYTES", "PDISPON",     "PDISPSET",
                   "POSEINV",       "POSEMULT",     "POSEVECT",    "POW",
                   "RELTOOL",       "ROUND",        "ROUNDDNUM",   "SETAO",
                   "SETDATAVAL",    "SETDO",        "SETGO",       "SETSYSDATA",
                   "SIN",           "SPEEDREFRESH", "SQRT",        "TAN",
                   "TPWRITE",       "TRIGGCHECKIO", "TRIGGEQUIP",  "TRIGGINT",
                   "TRIGGIO",       "TRIGGRAMPAO",  "TRIGGSPEED",  "TRUNC",
                   "TRUNCDNUM",     "VALTOSTR",     "VECTMAGN",    "VELSET",
                   "WAITTIME",      "WRITE",        "WRITEANYBIN", "WRITEBIN",
                   "WRITESTRBIN",   "WZBOXDEF",     "WZCYLDEF",    "WZHOMEJOINTDEF",
                   "WZLIMJOINTDEF", "WZSPHDEF"},
                  word);
}

// Those that may change a whole tool or work object.
bool changes_frames(std::string_view word) {
  return contains({"INCR", "GETDATAVAL", "MTOOLROTCALIB", "MTOOLTCPCALIB", "READANYBIN",
                   "STOOLROTCALIB", "STOOLTCPCALIB", "STRTOVAL", "UNPACKRAWBYTES"},
                  word);
}

// Behind which an instruction begins.
bool is_before_instruction(std::string_view word) {
  return contains({"THEN", "ELSE", "DO", "ENDIF", "ENDFOR", "ENDWHILE", "ENDTEST", "ERROR", "UNDO",
                   "BACKWARD", "ENDPROC", "ENDFUNC", "ENDTRAP", "DEFAULT", "LOCAL"},
                  word);
}

// Behind which an expression or a declaration begins.
bool is_before_expression(std::string_view word) {
  return contains({"IF", "ELSEIF", "WHILE", "TEST", "CASE", "FOR", "FROM", "TO", "STEP", "RETURN",
                   "VAR", "PERS", "CONST", "TASK"},
                  word);
}

bool is_operator(std::string_view word) {
  return contains({"AND", "OR", "NOT", "XOR", "DIV", "MOD"}, word);
}

// Reads a statement up to a datum.
class ReceiverSearch {
 public:
  ReceiverSearch(std::string_view text, const Statement& statement, size_t at)
      : cursor_(text, statement.begin, at) {
    while (!cursor_.done()) read_token();
  }

  // Of what stands there; empty if it is a part of an expression.
  std::string receiver() const {
    if (last_ != Last::separator && last_ != Last::instruction) return "";
    if (!open_.empty()) return open_.back();
    return is_assignment_ ? "" : instruction_;
  }

 private:
  enum class Last { nothing, operation, separator, instruction, name, operand };

  void read_token() {
    const char c = cursor_.next();
    if (is_letter(c)) return read_word(cursor_.take_name());
    if (is_digit(c)) {
      if (!cursor_.take_number()) cursor_.step();
      return end_operand();
    }
    cursor_.step();
    if (c == '"') {
      cursor_.skip_to("\"");
      cursor_.take('"');
      return end_operand();
    }
    if (c == '.') {
      cursor_.take_name();
      last_ = Last::operand;
      return;
    }
    if (c == '(' || c == '[' || c == '{') {
      open_.push_back(c == '(' && last_ == Last::name ? name_ : "");
      if (c == '(' && last_ == Last::instruction) open_.back() = instruction_;
      last_ = c == '(' ? Last::separator : Last::operation;
    } else if (c == ')' || c == ']' || c == '}') {
      if (!open_.empty()) open_.pop_back();
      last_ = Last::operand;
    } else {
      read_sign(c);
    }
  }

  void read_sign(char c) {
    if (c == '%' && open_.empty() && expects_instruction_) {  // %"part"+name%
      cursor_.skip_to("%");
      cursor_.take('%');
      return begin_instruction("%");
    }
    last_ = c == ',' || c == '?' ? Last::separator : Last::operation;
    if (c == '\\') cursor_.take_name();
    if (c == ':' && cursor_.take('=')) {
      last_ = Last::separator;
      is_assignment_ |= open_.empty() && is_only_name_;
    } else if (c == ':' && open_.empty()) {
      expect_instruction();  // behind a label or CASE 1:
    }
    if (open_.empty()) is_only_name_ = false;
  }

  void read_word(const std::string& word) {
    const bool is_behind_operand =
        last_ == Last::name || last_ == Last::operand || last_ == Last::instruction;
    if (!open_.empty() || is_operator(word)) {
      last_ = is_operator(word) ? Last::operation : Last::name;
      name_ = word;
    } else if (is_before_instruction(word)) {
      expect_instruction();
    } else if (begins_rapid_routine(word) || word == "MODULE") {
      take_rapid_routine(word, cursor_);
      if (cursor_.take('(')) cursor_.skip_to(")");
      cursor_.take(')');
      expect_instruction();
    } else if (is_before_expression(word)) {
      expects_instruction_ = false;
      is_compact_if_ = word == "IF";  // unless a THEN follows
      instruction_.clear();
      last_ = Last::operation;
    } else if (expects_instruction_ || (is_compact_if_ && is_behind_operand)) {
      begin_instruction(word);
    } else {
      name_ = word;
      last_ = Last::name;
      is_only_name_ = false;
    }
  }

  void expect_instruction() {
    expects_instruction_ = true;
    is_compact_if_ = is_assignment_ = false;
    instruction_.clear();
    last_ = Last::nothing;
  }

  void begin_instruction(const std::string& word) {
    instruction_ = word;
    expects_instruction_ = is_compact_if_ = false;
    is_only_name_ = true;
    last_ = Last::instruction;
  }

  void end_operand() {
    if (open_.empty()) is_only_name_ = false;
    last_ = Last::operand;
  }

  TextCursor cursor_;
  std::vector<std::string> open_;  // brackets: the function before them, or none
  std::string instruction_, name_;
  Last last_ = Last::nothing;
  bool expects_instruction_ = true, is_compact_if_ = false;
  bool is_only_name_ = false;  // the instruction is a name with components so far
  bool is_assignment_ = false;
};

}  // namespace

std::string rapid_receiver(std::string_view text, const Statement& statement, size_t at,
                           TextCursor behind) {
  skip_rapid_part(behind);
  const char next = behind.next();
  if (next != ',' && next != ')' && next != '\\' && next != '\0') return "";
  return ReceiverSearch(text, statement, at).receiver();
}

std::string rapid_type_of_part(const std::string& type, TextCursor behind) {
  static const std::map<std::string, std::string> kTypes{
      {"TRANS", "POS"},      {"ROT", "ORIENT"},     {"ROBCONF", "CONFDATA"},
      {"EXTAX", "EXTJOINT"}, {"ROBAX", "ROBJOINT"}, {"TFRAME", "POSE"},
      {"UFRAME", "POSE"},    {"OFRAME", "POSE"},    {"TLOAD", "LOADDATA"},
      {"COG", "POS"},        {"AOM", "ORIENT"},     {"ROBHOLD", "BOOL"},
      {"UFPROG", "BOOL"},    {"UFMEC", "STRING"},   {"X", "NUM"},
      {"Y", "NUM"},          {"Z", "NUM"},          {"Q1", "NUM"},
      {"Q2", "NUM"},         {"Q3", "NUM"},         {"Q4", "NUM"}};
  std::string result = type;
  while (behind.next() == '.' || behind.next() == '{')
    if (behind.take('.')) {
      const std::string part = behind.take_name();
      const auto found = kTypes.find(part);
      const bool is_axis =
          part.starts_with("RAX_") || part.starts_with("EAX_") || part.starts_with("CF");
      result = found != kTypes.end() ? found->second : is_axis ? "NUM" : "";
    } else {
      behind.skip_to("}");
      behind.take('}');
    }
  return result;
}

void RapidRoutines::read(std::string_view text, const std::vector<Statement>& statements) {
  Parameters* routine = nullptr;
  for (const Statement& statement : statements)
    each_rapid_word(text, statement, [&](const std::string& word, size_t at, TextCursor cursor) {
      if (begins_rapid_routine(word)) {
        const std::string name = take_rapid_routine(word, cursor);
        routine = &routines_[name].emplace_back();
        each_rapid_parameter(text, cursor, [&](const RapidParameter& parameter) {
          if (!parameter.mode.empty()) (*routine)[parameter.name].type = parameter.type;
        });
      } else if (ends_rapid_routine(word)) {
        routine = nullptr;
      } else if (routine) {
        const auto parameter = routine->find(word);
        if (parameter != routine->end()) note(parameter->second, text, statement, at, cursor);
      }
      return false;
    });
}

void RapidRoutines::note(Parameter& parameter, std::string_view text, const Statement& statement,
                         size_t at, TextCursor behind) {
  TextCursor assigned = behind;
  if (takes_rapid_assignment(assigned)) {
    parameter.is_changed |= !names_rapid_parameter(text, statement, at);
    return;
  }
  const std::string receiver = rapid_receiver(text, statement, at, behind);
  if (!receiver.empty())
    parameter.handed.push_back({receiver, rapid_type_of_part(parameter.type, behind)});
}

void RapidRoutines::follow_calls() {
  for (bool is_new = true; is_new;) {
    is_new = false;
    for (auto& [name, same_name] : routines_)
      for (Parameters& parameters : same_name)
        for (auto& [parameter_name, parameter] : parameters) {
          const bool is_changed =
              parameter.is_changed ||
              std::ranges::any_of(parameter.handed, [&](const Parameter::Handed& handed) {
                return may_change(handed.receiver, handed.type);
              });
          is_new |= std::exchange(parameter.is_changed, is_changed) != is_changed;
        }
  }
}

std::set<std::string> RapidRoutines::changed_by(const std::string& name) const {
  std::set<std::string> types;
  const auto found = routines_.find(name);
  if (found == routines_.end()) return types;
  for (const Parameters& parameters : found->second)
    for (const auto& [parameter_name, parameter] : parameters)
      if (parameter.is_changed) types.insert(parameter.type);
  return types;
}

bool RapidRoutines::may_change(const std::string& receiver, const std::string& type) const {
  if (contains(receiver)) {
    const std::set<std::string> changed = changed_by(receiver);
    return type.empty() ? !changed.empty() : changed.contains(type);
  }
  if (type == "TOOLDATA" || type == "WOBJDATA") return changes_frames(receiver);
  return !is_reading(receiver) && !find_rapid_move(receiver);
}

}  // namespace armtrue
