#include "programs/krl_syntax.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr int kDecimals = 4;
constexpr int kMaxDecimals = 9;  // beyond, a double of some metres has none
constexpr const char* kComponentNames[kKrlComponents] = {"X",  "Y",  "Z",  "A",  "B",  "C",
                                                         "E1", "E2", "E3", "E4", "E5", "E6"};

double unit_of(int component) {
  return component < 3 ? kMillimetre : component < 6 ? kDegree : 1.0;
}

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '$';
}
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::string upper(std::string_view name) {
  std::string result(name);
  for (char& c : result)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return result;
}

bool contains(std::initializer_list<std::string_view> names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Reads one statement from left to right.
class Cursor {
 public:
  Cursor(std::string_view text, size_t begin, size_t end) : text_(text), at_(begin), end_(end) {}

  size_t at() const { return at_; }
  size_t end() const { return end_; }
  bool done() {
    skip_blanks();
    return at_ == end_;
  }
  char next() {
    skip_blanks();
    return at_ < end_ ? text_[at_] : '\0';
  }
  void step() { ++at_; }
  bool take(char c) {
    if (next() != c) return false;
    ++at_;
    return true;
  }
  // A name in capitals, or nothing.
  std::string take_name() {
    skip_blanks();
    const size_t begin = at_;
    if (at_ < end_ && is_letter(text_[at_]))
      while (at_ < end_ && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    return upper(text_.substr(begin, at_ - begin));
  }
  // What stands up to one of the separators.
  void skip_to(std::string_view separators) {
    while (at_ < end_ && separators.find(text_[at_]) == std::string_view::npos) ++at_;
  }
  // A decimal number with its sign; what it is not stays unread.
  std::optional<double> take_number() {
    skip_blanks();
    size_t begin = at_;
    if (begin < end_ && text_[begin] == '+') ++begin;
    size_t digits = begin;
    if (digits == at_ && digits < end_ && text_[digits] == '-') ++digits;
    if (digits >= end_ || (!is_digit(text_[digits]) && text_[digits] != '.')) return std::nullopt;
    double value = 0;
    const auto [rest, error] = std::from_chars(text_.data() + begin, text_.data() + end_, value,
                                               std::chars_format::general);
    if (error != std::errc()) return std::nullopt;
    at_ = static_cast<size_t>(rest - text_.data());
    return value;
  }

 private:
  void skip_blanks() {
    while (at_ < end_ && is_blank(text_[at_])) ++at_;
  }

  std::string_view text_;
  size_t at_, end_;
};

enum class AggregateKind { frame, axes, other };

struct Aggregate {
  AggregateKind kind = AggregateKind::other;
  KrlFrame frame;
};

// Reads {X 1.0, ..} or {E6POS: X 1.0, ..}; the cursor stands on the brace, then behind the other. A
// component that is no plain number, stands twice or belongs to no position makes it `other`.
Aggregate take_aggregate(Cursor& cursor) {
  Aggregate result;
  KrlFrame& frame = result.frame;
  frame.values.setConstant(std::numeric_limits<double>::quiet_NaN());
  cursor.next();
  frame.begin = cursor.at();
  cursor.step();
  frame.entries = cursor.at();
  bool positions = false, axes = false;
  while (!cursor.done()) {
    std::string name = cursor.take_name();
    if (frame.entries == frame.begin + 1 && cursor.take(':')) {
      if (!contains({"POS", "E6POS", "FRAME", "AXIS", "E6AXIS"}, name)) return result;
      frame.entries = cursor.at();
      name = cursor.take_name();
    }
    const auto* const component =
        std::find(std::begin(kComponentNames), std::end(kComponentNames), name);
    const auto index = component - std::begin(kComponentNames);
    if (index < kKrlComponents) {
      cursor.next();
      const size_t begin = cursor.at();
      const auto value = cursor.take_number();
      if (!value || std::isfinite(frame.values[index])) return result;
      frame.values[index] = *value * unit_of(static_cast<int>(index));
      frame.numbers[static_cast<size_t>(index)] = {
          static_cast<unsigned>(begin - frame.begin),
          static_cast<unsigned>(cursor.at() - frame.begin)};
      positions |= index < 6;
    } else if (contains({"S", "T"}, name)) {
      cursor.skip_to(",}");
    } else if (name.size() == 2 && name[0] == 'A' && name[1] >= '1' && name[1] <= '6') {
      axes = true;
      cursor.skip_to(",}");
    } else {
      return result;
    }
    if (cursor.take('}')) {
      frame.end = cursor.at();
      if (positions != axes) result.kind = axes ? AggregateKind::axes : AggregateKind::frame;
      return result;
    }
    if (!cursor.take(',')) return result;
  }
  return result;
}

struct Keyword {
  std::string_view name;
  KrlMotion motion;
  bool spline;
  bool relative;
};

const Keyword* find_motion(std::string_view name) {
  using enum KrlMotion;
  static constexpr Keyword kMotions[] = {
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
  for (const Keyword& keyword : kMotions)
    if (keyword.name == name) return &keyword;
  return nullptr;
}

bool is_point_type(std::string_view name) {
  return contains({"POS", "E6POS", "FRAME", "AXIS", "E6AXIS"}, name);
}

struct Statement {
  int line;
  size_t line_begin, begin, end;
};

// A name of a point and what the texts say about it.
struct Declaration {
  int values = 0;  // how often it is given a value
  int frame = -1;  // the last frame, if it was one
  bool axes = false;
  bool shared = false;
  bool used = false;  // in a statement that may change it
};

class Parser {
 public:
  explicit Parser(const KrlProgram& program) : program_(program) {}

  KrlSyntax parse() {
    if (program_.dat) read(program_.dat->text, true);
    read(program_.src.text, false);
    resolve();
    return std::move(syntax_);
  }

 private:
  // Splits a text into statements: one per line, without comment.
  void read(std::string_view text, bool in_dat) {
    text_ = text;
    in_dat_ = in_dat;
    size_t begin = text.substr(0, 3) == "\xEF\xBB\xBF" ? 3 : 0;
    for (int line = 1; begin < text.size(); ++line) {
      const size_t newline = std::min(text.find('\n', begin), text.size());
      size_t from = begin;
      while (from < newline && is_blank(text[from])) ++from;
      size_t to = from;
      for (bool quoted = false; to < newline && (quoted || text[to] != ';'); ++to)
        if (text[to] == '"') quoted = !quoted;
      if (to == from && to < newline) read_comment(text.substr(from, newline - from));
      while (to > from && is_blank(text[to - 1])) --to;
      if (to > from && text[from] != '&') read_statement({line, begin, from, to});
      begin = newline + 1;
    }
  }

  void read_comment(std::string_view comment) {
    Cursor cursor(comment, 1, comment.size());
    const std::string word = cursor.take_name();
    if (word == "FOLD") {
      folds_.push_back(comment.find("%{") != std::string_view::npos);
      inline_forms_ += folds_.back();
    } else if (word == "ENDFOLD" && !folds_.empty()) {
      inline_forms_ -= folds_.back();
      folds_.pop_back();
    }
  }

  void read_statement(const Statement& statement) {
    Cursor cursor(text_, statement.begin, statement.end);
    std::string word = cursor.take_name();
    bool declares = false, global = false;
    for (; contains({"DECL", "GLOBAL", "CONST"}, word); word = cursor.take_name()) {
      declares |= word == "DECL";
      global |= word == "GLOBAL";
    }
    if (is_point_type(word)) return read_declaration(cursor, global);
    if (declares) return;
    if (read_definition(statement, word)) return;
    if (in_dat_) return;
    if (const Keyword* keyword = find_motion(word)) return read_move(statement, *keyword, cursor);
    follow_structure(word);
    if (word == "$BASE" || word == "BAS") read_base(statement, word);
    note_names(statement.begin, statement.end, false);
  }

  void follow_structure(std::string_view word) {
    if (contains({"DEF", "DEFFCT"}, word)) {
      start_unknown_ = true;
      loops_ = 0;
    } else if (contains({"LOOP", "FOR", "WHILE", "REPEAT"}, word)) {
      ++loops_;
    } else if (contains({"ENDLOOP", "ENDFOR", "ENDWHILE", "UNTIL"}, word)) {
      loops_ = std::max(0, loops_ - 1);
    } else if (contains({"SPLINE", "PTP_SPLINE"}, word)) {
      spline_block_ = true;
    } else if (word == "ENDSPLINE") {
      spline_block_ = false;
    } else if (word == "TRIGGER") {
      trigger_ = true;
    }
  }

  // $BASE=.. or BAS(#BASE,..)
  void read_base(const Statement& statement, std::string_view word) {
    std::string spelled;
    for (size_t i = statement.begin; i < statement.end; ++i)
      if (!is_blank(text_[i])) spelled += text_[i];
    spelled = upper(spelled);
    if (word == "BAS" && spelled.rfind("BAS(#BASE", 0) != 0) return;
    const int base = bases_.try_emplace(spelled, static_cast<int>(bases_.size()) + 1).first->second;
    start_unknown_ |= base != base_;
    base_ = base;
  }

  // The name of a variable or of an element of an array, as NAME or NAME[3]; nothing if the index
  // is no number.
  std::string take_variable(Cursor& cursor) {
    std::string name = cursor.take_name();
    Cursor ahead = cursor;
    if (name.empty() || !ahead.take('[')) return name;
    const auto index = ahead.take_number();
    if (!index || !ahead.take(']')) return "";
    cursor = ahead;
    return name + fmt::format("[{}]", *index);
  }

  int keep(const Aggregate& aggregate) {
    if (aggregate.kind != AggregateKind::frame) return -1;
    syntax_.frames.push_back(aggregate.frame);
    syntax_.frames.back().in_dat = in_dat_;
    return static_cast<int>(syntax_.frames.size()) - 1;
  }

  void define(const std::string& name, const Aggregate& aggregate, bool global) {
    Declaration& declaration = declarations_[name];
    ++declaration.values;
    declaration.frame = keep(aggregate);
    declaration.axes = aggregate.kind == AggregateKind::axes;
    declaration.shared |= global;
  }

  // The names, with or without value, behind the type.
  void read_declaration(Cursor& cursor, bool global) {
    do {
      const std::string name = take_variable(cursor);
      if (name.empty()) return;
      if (cursor.take('=')) {
        if (cursor.next() != '{') return;
        define(name, take_aggregate(cursor), global);
      } else {
        declarations_[name].shared |= global;
      }
    } while (cursor.take(','));
  }

  // NAME={..}
  bool read_definition(const Statement& statement, const std::string& word) {
    Cursor cursor(text_, statement.begin, statement.end);
    if (word.empty() || word[0] == '$') return false;
    const std::string name = take_variable(cursor);
    if (name.empty() || !cursor.take('=') || cursor.next() != '{') return false;
    const Aggregate aggregate = take_aggregate(cursor);
    if (aggregate.kind == AggregateKind::other || !cursor.done()) return false;
    define(name, aggregate, false);
    return true;
  }

  void read_move(const Statement& statement, const Keyword& keyword, Cursor& cursor) {
    KrlMove move;
    move.line = statement.line;
    move.line_begin = statement.line_begin;
    move.begin = statement.begin;
    move.end = statement.end;
    move.keyword_end = cursor.at();
    move.motion = keyword.motion;
    move.spline = keyword.spline;
    move.relative = keyword.relative;
    move.in_spline_block = spline_block_;
    move.in_loop = loops_ > 0;
    move.in_inline_form = inline_forms_ > 0;
    move.after_trigger = trigger_;
    move.start_unknown = start_unknown_;
    move.base = base_;
    trigger_ = start_unknown_ = false;
    if (keyword.relative) {
      note_names(move.keyword_end, move.end, true);
    } else {
      bool plain = true;
      if (move.motion == KrlMotion::circle) {
        plain = read_target(cursor, move.auxiliary, ",", true);
        plain = plain && cursor.take(',');
      }
      plain = plain && read_target(cursor, move.target, ",", false);
      if (!plain) {
        move.target.kind = move.auxiliary.kind = KrlTargetKind::expression;
        forget_names();
        note_names(move.keyword_end, move.end, true);
      } else {
        Cursor rest = cursor;
        move.circle_angle = move.motion == KrlMotion::circle && rest.take(',');
        note_names(cursor.at(), move.end, true);
      }
    }
    syntax_.moves.push_back(move);
  }

  // A frame, axes or a name; false if it is anything else. It ends at a separator or at a word.
  bool read_target(Cursor& cursor, KrlTarget& target, std::string_view separators, bool auxiliary) {
    const char first = cursor.next();
    target.begin = cursor.at();
    if (first == '{') {
      const Aggregate aggregate = take_aggregate(cursor);
      if (aggregate.kind == AggregateKind::other) return false;
      target.kind =
          aggregate.kind == AggregateKind::axes ? KrlTargetKind::axes : KrlTargetKind::frame;
      target.frame = keep(aggregate);
    } else {
      const std::string name = take_variable(cursor);
      if (name.empty()) return false;
      named_.push_back({syntax_.moves.size(), auxiliary, name});
    }
    target.end = cursor.at();
    const char next = cursor.next();
    return cursor.done() || separators.find(next) != std::string_view::npos ||
           (is_letter(next) && (first == '{' || cursor.at() > target.end));
  }

  // The names of a target that turned out to be none.
  void forget_names() {
    while (!named_.empty() && named_.back().move == syntax_.moves.size()) named_.pop_back();
  }

  // Names in a statement that is not understood, or behind the target of a move.
  void note_names(size_t begin, size_t end, bool only_reads) {
    char before = ' ';
    for (size_t i = begin; i < end; ++i) {
      const char c = text_[i];
      if (c == '"') {
        i = std::min(text_.find('"', i + 1), end);
      } else if (is_letter(c) || is_digit(c)) {
        const size_t from = i;
        while (i + 1 < end && (is_letter(text_[i + 1]) || is_digit(text_[i + 1]))) ++i;
        const std::string_view name = text_.substr(from, i + 1 - from);
        if (is_letter(c) && before != '.' && before != '#') {
          if (c == '$')
            note_system_variable(name, i + 1, end);
          else
            uses_.push_back({name, only_reads});
        }
      }
      if (!is_blank(c)) before = c;
    }
  }

  // $ABS_ACCUR, unless it is switched off.
  void note_system_variable(std::string_view name, size_t behind, size_t end) {
    if (name.size() != 10 || upper(name) != "$ABS_ACCUR" || syntax_.absolute_accuracy_line) return;
    Cursor cursor(text_, behind, end);
    if (cursor.take('=')) {
      cursor.take('=');
      cursor.take('#');
      if (contains({"FALSE", "NONE", "SUPPRESSED"}, cursor.take_name())) return;
    }
    syntax_.absolute_accuracy_line =
        1 + static_cast<int>(
                std::count(text_.begin(), text_.begin() + static_cast<long>(behind), '\n'));
  }

  // What the names of targets stand for, once everything is read.
  void resolve() {
    std::unordered_map<std::string, std::pair<bool, bool>> used;  // read, perhaps changed
    if (!declarations_.empty())
      for (const auto& [name, only_reads] : uses_) {
        auto& use = used[upper(name)];
        (only_reads ? use.first : use.second) = true;
      }
    for (auto& [name, declaration] : declarations_) {
      const auto use = used.find(name.substr(0, name.find('[')));
      if (use == used.end()) continue;
      declaration.shared |= use->second.first;
      declaration.used |= use->second.second;
    }
    for (const NamedTarget& named : named_) {
      KrlMove& move = syntax_.moves[named.move];
      KrlTarget& target = named.auxiliary ? move.auxiliary : move.target;
      const auto found = declarations_.find(named.name);
      if (found == declarations_.end()) {
        target.kind = KrlTargetKind::undeclared;
        continue;
      }
      const Declaration& declaration = found->second;
      const bool known = declaration.values == 1 && !declaration.used;
      target.declared = true;
      target.shared = declaration.shared;
      target.frame = declaration.frame;
      target.kind = !known                   ? KrlTargetKind::reassigned
                    : declaration.axes       ? KrlTargetKind::axes
                    : declaration.frame >= 0 ? KrlTargetKind::frame
                                             : KrlTargetKind::expression;
    }
  }

  struct NamedTarget {
    size_t move;
    bool auxiliary;
    std::string name;
  };

  const KrlProgram& program_;
  KrlSyntax syntax_;
  std::string_view text_;
  bool in_dat_ = false;
  std::vector<bool> folds_;  // open ones; true: an inline form of the pendant
  int inline_forms_ = 0;     // of these
  int loops_ = 0;
  bool spline_block_ = false, trigger_ = false, start_unknown_ = true;
  int base_ = 0;
  std::unordered_map<std::string, int> bases_;
  std::unordered_map<std::string, Declaration> declarations_;
  std::vector<NamedTarget> named_;
  std::vector<std::pair<std::string_view, bool>> uses_;
};

// Decimals as they were, at least: what stands behind the point, less the exponent.
int written_decimals(std::string_view number) {
  const size_t exponent = std::min(number.find_first_of("eE"), number.size());
  const size_t point = number.find('.');
  int decimals =
      point < exponent ? static_cast<int>(std::min<size_t>(exponent - point - 1, 20)) : 0;
  if (exponent < number.size()) {
    int power = 0;
    size_t from = exponent + 1;
    if (from < number.size() && number[from] == '+') ++from;
    std::from_chars(number.data() + from, number.data() + number.size(), power);
    decimals = power > decimals ? 0 : std::min(decimals - power, kMaxDecimals);
  }
  return std::min(decimals, kMaxDecimals);
}

std::string rounded(double value, int at_least) {
  std::string text = fmt::format("{:.{}f}", value, std::max(at_least, kDecimals));
  const size_t point = text.find('.');
  while (text.size() - point - 1 > static_cast<size_t>(at_least) && text.back() == '0')
    text.pop_back();
  if (text.back() == '.') text.pop_back();
  if (text.find_first_not_of("-0.") == std::string::npos && text[0] == '-') text.erase(0, 1);
  return text;
}

}  // namespace

KrlSyntax parse_krl(const KrlProgram& program) { return Parser(program).parse(); }

std::string krl_frame_text(std::string_view text, const KrlFrame& frame, const KrlValues& values,
                           const KrlValues& before) {
  struct Change {
    size_t begin, end;
    std::string number;
  };
  std::vector<Change> changes;
  size_t behind_position = frame.entries;
  std::string added;
  for (int i = 0; i < kKrlComponents; ++i) {
    const KrlFrame::Number& number = frame.numbers[static_cast<size_t>(i)];
    const bool present = number.end > 0;
    const size_t begin = frame.begin + number.begin, end = frame.begin + number.end;
    if (present && i < 3) behind_position = std::max(behind_position, end);
    if (!std::isfinite(values[i])) continue;
    const double value = values[i] / unit_of(i);
    const double now = (present ? frame.values[i] : before[i]) / unit_of(i);
    const int decimals = present ? written_decimals(text.substr(begin, end - begin)) : 0;
    const double step = std::pow(10.0, -std::max(decimals, kDecimals));
    if (std::abs(value - now) <= 0.5 * step) continue;
    if (present)
      changes.push_back({begin, end, rounded(value, decimals)});
    else
      added += fmt::format(",{} {}", kComponentNames[i], rounded(value, 0));
  }
  if (!added.empty()) {
    if (behind_position == frame.entries) added = added.substr(1) + ",";
    changes.push_back({behind_position, behind_position, added});
  }
  std::stable_sort(changes.begin(), changes.end(),
                   [](const Change& a, const Change& b) { return a.begin < b.begin; });
  std::string result;
  size_t from = frame.begin;
  for (const Change& change : changes) {
    result += text.substr(from, change.begin - from);
    result += change.number;
    from = change.end;
  }
  result += text.substr(from, frame.end - from);
  return result;
}

}  // namespace armtrue
