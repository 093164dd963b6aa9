#include "programs/kuka/krl_syntax.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "armtrue/kinematics/pose.h"
#include "programs/kuka/krl_variables.h"
#include "programs/kuka/krl_words.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

struct KrlStatement : Statement {
  size_t line_begin;
};

// XHOME, XHOME1 to XHOME5 of $config.dat; HOME of a program that declares its own.
bool is_home(std::string_view name) {
  if (name.starts_with("X")) name.remove_prefix(1);
  if (!name.starts_with("HOME")) return false;
  name.remove_prefix(4);
  return name.empty() || (name.size() == 1 && name[0] >= '1' && name[0] <= '5');
}

// What the texts say about the name of a point.
struct Declaration {
  int values = 0;       // how often the name is given a value
  int frame = -1;       // its last value, if that was a frame
  int axes = -1;        // its last value, if that was joint angles
  bool shared = false;  // other statements than moves read it
  bool is_global = false;
  bool used = false;         // a statement that is not understood may change it
  bool is_declared = false;  // else it is only given a value
  std::vector<int> set{};    // the frames that the .src gives it; -1: something else
};

class KrlParser {
 public:
  KrlParser(const std::vector<ProgramText>& texts, size_t own,
            const ProgramNeighbours::SharedVariables* shared)
      : texts_(texts), own_(own), shared_(shared) {}

  // Those of others first: what the program declares itself takes their place.
  KrlSyntax parse() {
    find_parameters();
    for (size_t text = own_; text < texts_.size(); ++text) read(text);
    for (size_t text = own_; text-- > 0;) read(text);
    follow_functions();
    resolve();
    const auto states = [&](const char* name, const char* value) {
      return std::any_of(texts_.begin(), texts_.begin() + own_, [&](const ProgramText& text) {
        return krl_states_mode(text.text, name, value);
      });
    };
    syntax_.circles_turn_with_path = states("CIRC_TYP", "PATH");
    syntax_.keeps_orientation = states("ORI_TYP", "CONSTANT");
    syntax_.nodes = flow_.take_nodes();
    return std::move(syntax_);
  }

 private:
  struct NamedUse {
    std::string_view name;
    bool only_reads, in_set_up;
  };
  // What the texts say about the type of a variable.
  struct Type {
    std::string name;
    int declarations = 0;  // in the own texts
    bool is_of_others = false;
    bool is_global = false;  // of an FDAT
  };
  // What changes a variable in the .src.
  struct Changes {
    std::vector<KrlChange> list;
    bool is_beyond_main = false;  // in another routine than the first
    bool is_at_any_time = false;  // of an interrupt; or a parameter, which is another variable
  };
  struct NamedTarget {
    size_t move;
    bool auxiliary;
    std::string name;
  };

  struct Factor {
    int frame;         // written out; -1: by its name
    std::string name;  // or empty
  };
  // A target that is a product of frames.
  struct Product {
    size_t move;
    bool auxiliary;
    size_t begin, end;  // in the .src
    std::vector<Factor> factors;
  };

  // Splits a text into statements, one per line, and reads each without its comment.
  void read(size_t index) {
    const std::string_view text = text_ = texts_[index].text;
    index_ = index;
    gives_ = index < own_ ? Gives::all : Gives::nothing;
    is_source_ = false;
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
      if (to > from && text[from] != '&') read_statement({{line, from, to}, begin});
      begin = newline + 1;
    }
  }

  void read_comment(std::string_view comment) {
    TextCursor cursor(comment, 1, comment.size());
    const std::string word = cursor.take_name();
    if (word == "FOLD") {
      folds_.push_back(comment.find("%{") != std::string_view::npos);
      inline_forms_ += folds_.back();
    } else if (word == "ENDFOLD" && !folds_.empty()) {
      inline_forms_ -= folds_.back();
      folds_.pop_back();
    }
  }

  void read_statement(const KrlStatement& statement) {
    TextCursor cursor(text_, statement.begin, statement.end);
    std::string word = cursor.take_name();
    bool declares = false, global = false;
    for (; contains({"DECL", "GLOBAL", "CONST"}, word); word = cursor.take_name()) {
      declares |= word == "DECL";
      global |= word == "GLOBAL";
    }
    if (is_of_others()) {
      if (word == "DEFDAT") return begin_list_of_others(cursor);
      is_source_ |= begins_krl_routine(word);
      has_sources_of_others_ |= is_source_;
      if (is_source_) return note_assignment_of_others(statement);
      if (read_robot_root(word, cursor)) return;
      note_machine_data(statement);
      if (gives_ == Gives::nothing || (gives_ == Gives::global && !global)) return;
    }
    if (is_krl_point_type(word)) return read_declaration(cursor, global, word);
    if (word == "REAL" || word == "INT") return read_numbers(statement, cursor, global, word);
    if (word == "FDAT") return read_fdat(cursor, global);
    if (word == "LDAT") return take_krl_ldat(cursor, syntax_.ldats);
    if (declares) return;
    routines_ += index_ == 0 && begins_krl_routine(word);
    if (index_ == 0 && word == "DEFFCT") functions_.insert(krl_head(text_, statement)->name);
    if (read_definition(statement, word)) return;
    if (index_ > 0) return;
    if (const KrlKeyword* keyword = find_krl_motion(word))
      return read_move(statement, *keyword, cursor);
    const bool stays =
        leaves_krl_arm(text_.substr(statement.begin, statement.end - statement.begin), word);
    flow_.pass(word, stays, syntax_.set_ups.size());
    syntax_.steps.pass(word, statement.begin, cursor);
    if (word == "$APO" || word == "LDAT_ACT")
      syntax_.zones.push_back({statement.line, statement.begin, statement.end, word});
    if (contains({"SPLINE", "PTP_SPLINE"}, word)) {
      spline_block_ = statement;
    } else if (word == "ENDSPLINE") {
      spline_block_.reset();
    } else if (word == "TRIGGER") {
      trigger_ = true;
    }
    in_set_up_ =
        contains({"DEF", "DEFFCT", "$BASE", "$TOOL", "$IPO_MODE", "BAS", "FDAT_ACT"}, word);
    if (in_set_up_ || begins_krl_loop(word) || ends_krl_loop(word) ||
        (!word.empty() && !stays && cursor.next() == '('))
      syntax_.set_ups.push_back({statement.line, statement.begin, statement.end, word});
    if (read_call(statement, word, cursor)) return;
    const size_t changed = stays ? changed_until(statement, word) : statement.end;
    note_changes(statement, changed, word);
    note_names(statement.begin, changed, false);
    note_names(changed, statement.end, true);
    in_set_up_ = false;
  }

  // DEF sub(point:IN,height:OUT) of the .src; not of a name that has two of them.
  void find_parameters() {
    std::unordered_set<std::string> twice;
    for (const Statement& line : lines_of(texts_[0].text)) {
      TextCursor cursor(texts_[0].text, line.begin, line.end);
      std::string word = cursor.take_name();
      if (word == "GLOBAL") word = cursor.take_name();
      if (word != "DEF") continue;
      const std::string name = cursor.take_name();
      if (!cursor.take('(')) continue;
      std::vector<bool> is_in;
      do {
        cursor.take_name();
        is_in.push_back(cursor.take(':') && cursor.take_name() == "IN");
      } while (cursor.take(','));
      if (cursor.take(')') && !parameters_.try_emplace(name, is_in).second) twice.insert(name);
    }
    for (const std::string& name : twice) parameters_.erase(name);
  }

  // sub(XP1,25): a routine gets a copy of what it takes as :IN. Returns false if the statement is
  // no call of a routine of the .src. `cursor`: behind its name.
  bool read_call(const KrlStatement& statement, const std::string& word, TextCursor cursor) {
    const auto routine = parameters_.find(word);
    if (routine == parameters_.end() || !cursor.take('(')) return false;
    const std::string_view text = text_.substr(statement.begin, statement.end - statement.begin);
    if (text.back() != ')' || text.find('"') != text.npos) return false;
    const std::vector<Statement> arguments =
        split_arguments(text_, cursor.at(), statement.end - 1, ",");
    for (size_t i = 0; i < arguments.size(); ++i) {
      const KrlStatement part{{statement.line, arguments[i].begin, arguments[i].end},
                              statement.line_begin};
      const bool calls =
          text_.substr(part.begin, part.end - part.begin).find('(') != std::string_view::npos;
      const bool is_copied = i < routine->second.size() && routine->second[i] && !calls;
      if (!is_copied) note_changes(part, part.end, word);
      note_names(part.begin, part.end, is_copied);
    }
    in_set_up_ = false;
    return true;
  }

  bool is_of_others() const { return index_ >= own_; }

  // $ABS_ACCUR of $machine.dat, $TRAFONAME[]="#KR210R2700_2 S C2 FLR" there and $MODEL_NAME[] of
  // $robcor.dat: they hold for all programs of the controller.
  void note_machine_data(const Statement& statement) {
    each_word(text_, statement, [&](const std::string& name, size_t at, TextCursor& cursor) {
      if (name == "$ABS_ACCUR") note_system_variable(text_.substr(at, name.size()), cursor.at());
      if (!contains({"$TRAFONAME", "$MODEL_NAME"}, name) || !syntax_.arm_name.empty()) return;
      const size_t open = text_.find('"', at);
      const size_t close = open >= statement.end ? open : text_.find('"', open + 1);
      if (close >= statement.end) return;
      syntax_.arm_name = text_.substr(open + 1, close - open - 1);
      syntax_.arm_name_text = static_cast<int>(index_);
      syntax_.arm_name_line = statement.line;
    });
  }

  // $ROBROOT={..}; returns false if the statement is anything else. Of an arm on a rail (#ERSYS) it
  // counts from the carriage.
  bool read_robot_root(const std::string& word, TextCursor cursor) {
    if ((word == "FRAME" ? cursor.take_name() : word) != "$ROBROOT" || !cursor.take('=') ||
        cursor.next() != '{')
      return false;
    if (upper(text_).find("#ERSYS") == std::string::npos)
      syntax_.robot_root = keep(take_krl_aggregate(cursor));
    return true;
  }

  // The variables that a statement of the .src may change.
  void note_changes(const Statement& statement, size_t until, const std::string& word) {
    if (in_set_up_ && !begins_krl_routine(word)) return;
    const bool is_assignment =
        until < statement.end && text_[until] == '=' && !in_set_up_ && !contains({"FOR"}, word);
    bool is_component = false;
    each_word(text_, {statement.line, statement.begin, until},
              [&](const std::string& name, size_t at, const TextCursor&) {
                is_component = at > statement.begin && text_[at - 1] == '.';
                if (is_component || name[0] == '$') return;
                Changes& changes = changes_[name];
                changes.list.push_back(
                    {statement.begin, statement.end, is_assignment && at == statement.begin});
                changes.is_beyond_main |= routines_ > 1;
                changes.is_at_any_time |= contains({"DEF", "DEFFCT", "INTERRUPT", "TRIGGER"}, word);
              });
  }

  // FP1={TOOL_NO 1,..} behind DECL FDAT.
  void read_fdat(TextCursor& cursor, bool global) {
    const std::string name = cursor.take_name();
    note_type(name, "FDAT");
    types_[name].is_global |= global;
    if (cursor.take('=') && cursor.next() == '{') syntax_.fdats[name] = take_krl_fdat(cursor);
  }

  // REAL LENGTH=50.0,WIDTH
  void read_numbers(const Statement& statement, TextCursor& cursor, bool global,
                    const std::string& type) {
    do {
      const std::string name = cursor.take_name();
      if (name.empty() || cursor.next() == '[') break;
      note_type(name, type);
      if (!cursor.take('=')) continue;
      const auto number = cursor.take_number();
      if (index_ == 0)
        changes_[name].list.push_back({statement.begin, statement.end, false});
      else if (number && !is_of_others() && !global && (cursor.done() || cursor.next() == ','))
        numbers_[name] = *number;
      cursor.skip_to(",");
    } while (cursor.take(','));
    if (index_ == 0) note_names(statement.begin, statement.end, false);
  }

  void note_type(const std::string& name, const std::string& type) {
    Type& of = types_[name];
    of.declarations += !is_of_others();
    of.is_of_others |= is_of_others();
    of.name = of.name.empty() || of.name == type ? type : "?";
  }

  // DEFDAT $CONFIG or DEFDAT NAME PUBLIC: what $config.dat declares is global, and of other lists
  // what they say so of.
  void begin_list_of_others(TextCursor& cursor) {
    if (cursor.take_name() == "$CONFIG")
      gives_ = Gives::all;
    else
      gives_ = cursor.take_name() == "PUBLIC" ? Gives::global : Gives::nothing;
  }

  // NAME=.., NAME[3].X=.. in the .src of another program.
  void note_assignment_of_others(const Statement& statement) {
    TextCursor cursor(text_, statement.begin, statement.end);
    const std::string name = cursor.take_name();
    if (name.empty()) return;
    if (takes_krl_assignment(cursor)) set_by_others_.insert(name);
  }

  // Up to where a statement that calls nothing may change what it names: to the `=` of an
  // assignment. A condition changes nothing.
  size_t changed_until(const Statement& statement, const std::string& word) const {
    if (contains({"IF", "ELSE", "SWITCH", "CASE", "WHILE", "UNTIL"}, word)) return statement.begin;
    const std::string_view text = text_.substr(statement.begin, statement.end - statement.begin);
    if (in_set_up_ || !is_krl_assignment(text)) return statement.end;
    return statement.begin + text.find('=');
  }

  // Takes the name of a variable, NAME, or of an element of an array, NAME[3]. Returns nothing if
  // the index is no number.
  std::string take_variable(TextCursor& cursor) {
    std::string name = cursor.take_name();
    TextCursor ahead = cursor;
    if (name.empty() || !ahead.take('[')) return name;
    const auto index = ahead.take_number();
    if (!index || !ahead.take(']')) return "";
    cursor = ahead;
    return name + fmt::format("[{}]", *index);
  }

  int keep(const KrlAggregate& aggregate) {
    if (aggregate.kind != KrlAggregateKind::frame) return -1;
    syntax_.frames.push_back(aggregate.frame);
    syntax_.frames.back().text = static_cast<int>(index_);
    return static_cast<int>(syntax_.frames.size()) - 1;
  }

  int keep_axes(const KrlAggregate& aggregate) {
    if (aggregate.kind != KrlAggregateKind::axes) return -1;
    syntax_.axes.push_back(aggregate.frame);
    syntax_.axes.back().text = static_cast<int>(index_);
    return static_cast<int>(syntax_.axes.size()) - 1;
  }

  void define(const std::string& name, const KrlAggregate& aggregate, bool global) {
    Declaration& declaration = declared(name);
    declaration.is_declared |= index_ > 0;
    ++declaration.values;
    declaration.frame = keep(aggregate);
    if (index_ == 0) declaration.set.push_back(declaration.frame);
    declaration.axes = keep_axes(aggregate);
    declaration.is_global |= global;
  }

  Declaration& declared(const std::string& name) {
    return (is_of_others() ? of_others_ : declarations_)[name];
  }

  // Reads the names behind a type, each with or without a value.
  void read_declaration(TextCursor& cursor, bool global, const std::string& type) {
    do {
      const std::string name = take_variable(cursor);
      if (name.empty()) return;
      note_type(name, type);
      declared(name).is_declared = true;
      if (cursor.take('=')) {
        if (cursor.next() != '{') return;
        define(name, take_krl_aggregate(cursor), global);
      } else {
        declared(name).is_global |= global;
      }
    } while (cursor.take(','));
  }

  // Reads NAME={..}; returns false if the statement is anything else.
  bool read_definition(const Statement& statement, const std::string& word) {
    TextCursor cursor(text_, statement.begin, statement.end);
    if (word.empty() || word[0] == '$') return false;
    const std::string name = take_variable(cursor);
    if (name.empty() || !cursor.take('=') || cursor.next() != '{') return false;
    const KrlAggregate aggregate = take_krl_aggregate(cursor);
    if (aggregate.kind == KrlAggregateKind::other || !cursor.done()) return false;
    define(name, aggregate, false);
    if (index_ == 0) note_changes(statement, text_.find('=', statement.begin), word);
    return true;
  }

  void read_move(const KrlStatement& statement, const KrlKeyword& keyword, TextCursor& cursor) {
    KrlMove move;
    move.line = statement.line;
    move.line_begin = statement.line_begin;
    move.begin = statement.begin;
    move.end = statement.end;
    move.keyword_end = cursor.at();
    move.motion = keyword.motion;
    move.spline = keyword.spline;
    move.spline_block = spline_block_;
    move.in_loop = flow_.is_in_loop();
    move.in_inline_form = inline_forms_ > 0;
    move.after_trigger = trigger_;
    flow_.add_move(static_cast<int>(syntax_.moves.size()));
    move.set_ups = syntax_.set_ups.size();
    trigger_ = false;
    if (keyword.relative) {
      read_relative(cursor, move);
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
        TextCursor rest = cursor;
        move.circle_angle = move.motion == KrlMotion::circle && rest.take(',');
        note_names(cursor.at(), move.end, true);
      }
    }
    syntax_.moves.push_back(move);
  }

  // LIN_REL {Z 50} C_DIS #TOOL. Written out, it is LIN with a point in $BASE.
  void read_relative(TextCursor& cursor, KrlMove& move) {
    note_names(move.keyword_end, move.end, true);
    move.relative = KrlRelative::base;
    KrlTarget& target = move.target;
    if (move.motion == KrlMotion::circle || cursor.next() != '{') return;
    target.begin = move.keyword_end - std::string_view("_REL").size();
    target.before = text_.substr(move.keyword_end, cursor.at() - move.keyword_end);
    if (target.before.empty()) target.before = " ";
    const KrlAggregate aggregate = take_krl_aggregate(cursor);
    const size_t behind = target.end = cursor.at();
    while (!cursor.done()) {
      const size_t at = cursor.at();
      if (cursor.take('#')) {
        const std::string name = cursor.take_name();
        if ((name != "BASE" && name != "TOOL") || target.end > behind) return;
        if (name == "TOOL") move.relative = KrlRelative::tool;
        target.end = cursor.at();
        target.behind = text_.substr(behind, at - behind);
        target.behind.erase(target.behind.find_last_not_of(" \t") + 1);
      } else if (const std::string word = cursor.take_name(); word == "WITH") {
        if (text_.substr(at, move.end - at).find("#TOOL") != std::string_view::npos) return;
        break;
      } else if (!word.starts_with("C_")) {
        return;
      }
    }
    target.frame = keep(aggregate);
    if (target.frame < 0) return;
    KrlFrame& frame = syntax_.frames.back();
    frame.begin = target.begin;
    frame.end = target.end;
    target.kind = KrlTargetKind::frame;
    target.is_expression = true;
  }

  // Reads a frame, axis angles or a name that ends at a separator or at a word. Returns false if
  // the target is anything else.
  bool read_target(TextCursor& cursor, KrlTarget& target, std::string_view separators,
                   bool auxiliary) {
    const char first = cursor.next();
    target.begin = cursor.at();
    if (first == '{') {
      const KrlAggregate aggregate = take_krl_aggregate(cursor);
      if (aggregate.kind == KrlAggregateKind::other) {
        keep_external(aggregate, target);
        return false;
      }
      target.kind =
          aggregate.kind == KrlAggregateKind::axes ? KrlTargetKind::axes : KrlTargetKind::frame;
      target.frame = keep(aggregate);
      target.axes = keep_axes(aggregate);
    } else {
      const std::string name = take_variable(cursor);
      if (name.empty()) return false;
      named_.push_back({syntax_.moves.size(), auxiliary, name});
    }
    target.end = cursor.at();
    if (cursor.next() == ':' && !read_factors(cursor, target, auxiliary)) return false;
    const char next = cursor.next();
    return cursor.done() || separators.find(next) != std::string_view::npos ||
           (is_letter(next) && (first == '{' || cursor.at() > target.end));
  }

  // PTP {E1 1700}
  void keep_external(const KrlAggregate& aggregate, KrlTarget& target) {
    const KrlFrame& frame = aggregate.frame;
    const bool is_of_arm =
        frame.values.head<6>().array().isFinite().any() ||
        std::ranges::any_of(frame.axes, [](double q) { return std::isfinite(q); });
    if (frame.end == 0 || is_of_arm || !frame.values.tail<6>().array().isFinite().any()) return;
    target.only_external = static_cast<int>(syntax_.frames.size());
    syntax_.frames.push_back(frame);
  }

  // The frames behind a point, XP1:{Z 50,..}:fTurned.
  bool read_factors(TextCursor& cursor, KrlTarget& target, bool auxiliary) {
    Product product{syntax_.moves.size(), auxiliary, target.begin, 0, {}};
    product.factors.push_back(factor_of(target));
    const size_t behind = target.end;
    while (cursor.take(':')) {  // takes blanks, too
      if (cursor.next() == '{') {
        const KrlAggregate aggregate = take_krl_aggregate(cursor);
        if (aggregate.kind != KrlAggregateKind::frame) return false;
        product.factors.push_back({keep(aggregate), ""});
      } else {
        const std::string name = take_variable(cursor);
        if (name.empty()) return false;
        product.factors.push_back({-1, name});
      }
      target.end = cursor.at();
    }
    note_names(behind, target.end, true);
    product.end = target.end;
    products_.push_back(std::move(product));
    return true;
  }

  // The point in front of frames: it is no named target of its own any more.
  Factor factor_of(const KrlTarget& target) {
    if (target.frame >= 0 || target.axes >= 0) return {target.frame, ""};
    const NamedTarget named = named_.back();
    named_.pop_back();
    return {-1, named.name};
  }

  void resolve(const Product& product, const KrlVariables& variables) {
    KrlMove& move = syntax_.moves[product.move];
    KrlTarget& target = product.auxiliary ? move.auxiliary : move.target;
    target.kind = KrlTargetKind::expression;
    std::vector<std::optional<KrlValue>> factors;
    for (const Factor& factor : product.factors)
      factors.push_back(value_of(factor, variables, move.begin));
    const std::optional<Pose> pose = KrlVariables::product_of(factors);
    const std::string& first = product.factors.front().name;
    if (const auto start = declarations_.find(first); start != declarations_.end()) {
      start->second.shared |= !pose;
      if (syntax_.frame_names.contains(first)) target.starts_from = start->second.frame;
    }
    if (!pose) return;
    KrlFrame result;
    result.begin = product.begin;
    result.end = product.end;
    result.values.head<3>() = pose->translation;
    result.values.segment<3>(3) = abc_from_rotation(pose->rotation);
    syntax_.frames.push_back(result);
    target.frame = static_cast<int>(syntax_.frames.size()) - 1;
    target.kind = KrlTargetKind::frame;
    target.is_expression = true;
  }

  std::optional<KrlValue> value_of(const Factor& factor, const KrlVariables& variables,
                                   size_t place) const {
    int index = factor.frame;
    if (!factor.name.empty()) {
      const auto found = syntax_.frame_names.find(factor.name);
      if (found == syntax_.frame_names.end()) return variables.value_at(factor.name, place);
      index = found->second;
    }
    if (index < 0) return std::nullopt;
    return KrlValue{std::nullopt, syntax_.frames[index], false};
  }

  // Drops the named targets of the current move: they were parts of an expression.
  void forget_names() {
    while (!named_.empty() && named_.back().move == syntax_.moves.size()) named_.pop_back();
    while (!products_.empty() && products_.back().move == syntax_.moves.size())
      products_.pop_back();
  }

  // Notes the names in a statement that is not understood, or behind the target of a move.
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
            note_system_variable(name, i + 1);
          else
            uses_.push_back({name, only_reads, in_set_up_});
        }
      }
      if (!is_blank(c)) before = c;
    }
  }

  // Notes $ABS_ACCUR, unless the statement switches it off.
  void note_system_variable(std::string_view name, size_t behind) {
    if (name.size() != 10 || upper(name) != "$ABS_ACCUR" || syntax_.absolute_accuracy_line) return;
    TextCursor cursor(text_, behind, std::min(text_.find('\n', behind), text_.size()));
    if (cursor.take('=')) {
      cursor.take('=');
      cursor.take('#');
      if (contains({"FALSE", "NONE", "SUPPRESSED"}, cursor.take_name())) return;
    }
    syntax_.absolute_accuracy_line = line_at(text_, behind);
    syntax_.absolute_accuracy_text = static_cast<int>(index_);
  }

  // Finds what the named targets stand for, once both texts are read.
  void resolve() {
    struct Uses {
      bool read = false, perhaps_changed = false, beyond_set_up = false;
    };
    std::unordered_map<std::string, Uses> used;
    for (const auto& [name, declaration] : of_others_) {
      const auto [own, is_new] = declarations_.try_emplace(name, declaration);
      if (!is_new && !own->second.is_declared) own->second.values += declaration.values;
      if (is_new) own->second.is_global = true;
    }
    for (auto& [name, declaration] : declarations_)
      declaration.used |=
          declaration.is_global && set_by_others_.contains(name.substr(0, name.find('[')));
    if (!declarations_.empty() || !named_.empty())
      for (const NamedUse& use : uses_) {
        Uses& all = used[upper(use.name)];
        (use.only_reads ? all.read : all.perhaps_changed) = true;
        all.beyond_set_up |= !use.only_reads && !use.in_set_up;
      }
    for (auto& [name, declaration] : declarations_) {
      const auto use = used.find(name.substr(0, name.find('[')));
      const Uses all = use == used.end() ? Uses{} : use->second;
      declaration.shared |= all.read;
      const bool is_set_by_others =
          std::exchange(declaration.used, declaration.used || all.perhaps_changed);
      if (all.beyond_set_up || is_set_by_others) continue;
      const bool is_of_controller = is_krl_frame_list(name) && !declaration.is_declared;
      const bool is_shared =
          is_of_controller && set_by_others_.contains(name.substr(0, name.find('[')));
      if (declaration.values == 1 && declaration.frame >= 0 && !is_shared)
        syntax_.frame_names[name] = declaration.frame;
      if (is_of_controller) note_set_frame(name, declaration, is_shared);
    }
    syntax_.variables = follow_variables();
    const KrlVariables& variables = *syntax_.variables;
    for (const Product& product : products_) resolve(product, variables);
    for (const NamedTarget& named : named_) {
      KrlMove& move = syntax_.moves[named.move];
      KrlTarget& target = named.auxiliary ? move.auxiliary : move.target;
      const auto found = declarations_.find(named.name);
      if (found == declarations_.end()) {
        const auto use = used.find(named.name.substr(0, named.name.find('[')));
        const bool is_set_here = use != used.end() && use->second.perhaps_changed;
        target.kind = named.name == "$POS_ACT" || named.name == "$AXIS_ACT" ? KrlTargetKind::here
                      : is_set_here         ? KrlTargetKind::reassigned
                      : is_home(named.name) ? KrlTargetKind::home
                                            : KrlTargetKind::undeclared;
        continue;
      }
      const Declaration& declaration = found->second;
      const bool known = declaration.values == 1 && !declaration.used;
      target.shared = declaration.shared;
      target.is_global = declaration.is_global;
      target.frame = declaration.frame;
      target.axes = declaration.axes;
      target.kind = !known                   ? KrlTargetKind::reassigned
                    : declaration.axes >= 0  ? KrlTargetKind::axes
                    : declaration.frame >= 0 ? KrlTargetKind::frame
                                             : KrlTargetKind::expression;
      if (target.kind == KrlTargetKind::reassigned) take_value(variables, named.name, move, target);
    }
  }

  // A frame of the controller that the .src sets to frames with all their numbers. `is_shared`:
  // others set it, too.
  void note_set_frame(const std::string& name, const Declaration& declaration, bool is_shared) {
    const std::string list = name.substr(0, name.find('['));
    const auto is_whole = [&](int frame) {
      return frame >= 0 && syntax_.frames[frame].values.head<6>().array().isFinite().all();
    };
    if (declaration.set.empty() || !std::ranges::all_of(declaration.set, is_whole) ||
        (is_shared && (!shared_ || shared_->set_at_any_time.contains(list))))
      return;
    KrlSetFrame& frame = syntax_.set_frames[name];
    frame.values = declaration.set;
    if (const auto others = of_others_.find(name);
        others != of_others_.end() && others->second.values == 1 && is_whole(others->second.frame))
      frame.before = others->second.frame;
    if (is_shared) frame.lost_at = calls_that_may_set(list);
  }

  // Keeps the FDAT and LDAT that nothing may change. Returns all FDAT as they are declared.
  std::unordered_map<std::string, KrlFdat> drop_changed_data() {
    for (const auto& [name, changes] : changes_) syntax_.changed.insert(name);
    const auto is_changed = [&](const auto& data) {
      const auto type = types_.find(data.first);
      const bool is_seen_by_others =
          type != types_.end() && (type->second.is_global || type->second.declarations == 0);
      return syntax_.changed.contains(data.first) ||
             (is_seen_by_others && set_by_others_.contains(data.first));
    };
    const std::unordered_map<std::string, KrlFdat> declared = syntax_.fdats;
    for (const auto& fdat : declared)
      if (is_changed(fdat)) syntax_.changed.insert(fdat.first);
    std::erase_if(syntax_.fdats, is_changed);
    std::erase_if(syntax_.ldats, is_changed);
    return declared;
  }

  // The variables that only the .src changes, and only where its flow shows when: with the
  // constants from which they take their values. A name that is declared twice is two variables.
  std::shared_ptr<const KrlVariables> follow_variables() {
    const auto followed = std::make_shared<KrlVariables>(texts_[0].text, syntax_.steps);
    KrlVariables& variables = *followed;
    const std::unordered_map<std::string, KrlFdat> declared_fdats = drop_changed_data();
    const bool comes_any_time = !functions_.empty() || !syntax_.steps.interrupts().empty();
    for (const auto& [name, type] : types_) {
      const auto found = declarations_.find(name);
      const Declaration* const declared = found == declarations_.end() ? nullptr : &found->second;
      const bool is_seen_by_others =
          type.declarations == 0 || type.is_global || (declared && declared->is_global);
      const auto fdat = declared_fdats.find(name);
      if (type.name == "?" || type.declarations + type.is_of_others != 1) continue;
      if (is_seen_by_others && !has_sources_of_others_) continue;
      const bool is_shared = is_seen_by_others && set_by_others_.contains(name);
      if (is_shared && (!shared_ || shared_->set_at_any_time.contains(name))) continue;
      const auto changed = changes_.find(name);
      if (changed == changes_.end()) {
        if (fdat != declared_fdats.end() && syntax_.fdats.contains(name))
          variables.add_constant(name, type.name, {std::nullopt, {}, false, fdat->second});
        else if (const auto number = numbers_.find(name); number != numbers_.end())
          variables.add_constant(name, type.name, {number->second, {}, false});
        else if (declared && declared->values == 1 && !declared->used &&
                 (declared->frame >= 0 || declared->axes >= 0))
          variables.add_constant(name, type.name,
                                 {std::nullopt, value_of(*declared), declared->axes >= 0});
        continue;
      }
      const Changes& changes = changed->second;
      if (changes.is_at_any_time || (changes.is_beyond_main && comes_any_time)) continue;
      std::vector<KrlChange> list = changes.list;
      if (is_shared)
        for (const size_t call : calls_that_may_set(name)) list.push_back({call, call, false});
      KrlValue value{std::nullopt, declared ? value_of(*declared) : KrlFrame{}, false};
      if (fdat != declared_fdats.end()) value.fdat = fdat->second;
      variables.add(name, type.name, list, value);
    }
    const auto has_external = [](const KrlFrame& point) {
      return point.values.tail<6>().array().isFinite().any();
    };
    variables.set_has_external(std::ranges::any_of(syntax_.frames, has_external) ||
                               std::ranges::any_of(syntax_.axes, has_external));
    variables.follow();
    return followed;
  }

  // Calls of routines of others that may set a variable; in an expression, before the statement.
  std::vector<size_t> calls_that_may_set(const std::string& name) {
    std::vector<size_t> places;
    for (const KrlCall& call : calls()) {
      const auto found = shared_->set_by.find(call.name);
      if (found == shared_->set_by.end() || !found->second.contains(name)) continue;
      places.push_back(call.place());
    }
    return places;
  }

  // Those of the .src.
  const std::vector<KrlCall>& calls() {
    if (!calls_) calls_ = krl_calls(masked(texts_[0].text, ';', "\""));
    return *calls_;
  }

  // A function of the .src may set what a subprogram may.
  void follow_functions() {
    if (functions_.empty()) return;
    for (const KrlCall& call : calls())
      if (!call.is_statement && functions_.contains(call.name))
        syntax_.steps.pass_call(call.name, call.place());
  }

  KrlFrame value_of(const Declaration& declaration) const {
    if (declaration.axes >= 0) return syntax_.axes[declaration.axes];
    if (declaration.frame >= 0) return syntax_.frames[declaration.frame];
    return {};
  }

  // The point that a variable is at a move: written out in the move, if that needs another one.
  void take_value(const KrlVariables& variables, const std::string& name, const KrlMove& move,
                  KrlTarget& target) {
    const bool is_free = move.motion == KrlMotion::point_to_point;
    const std::optional<KrlValue> value = variables.value_at(name, move.begin);
    if (!value || value->number || variables.may_keep_more(name, *value, is_free)) return;
    KrlFrame point = value->point;
    if (point.status.has_value() != point.turn.has_value()) {
      if (is_free) return;
      point.status.reset();
      point.turn.reset();
    }
    point.text = 0;
    point.begin = target.begin;
    point.end = target.end;
    std::vector<KrlFrame>& list = value->is_axes ? syntax_.axes : syntax_.frames;
    (value->is_axes ? target.axes : target.frame) = static_cast<int>(list.size());
    list.push_back(point);
    target.kind = value->is_axes ? KrlTargetKind::axes : KrlTargetKind::frame;
    target.is_expression = true;
  }

  enum class Gives { nothing, global, all };  // declarations that the program sees

  const std::vector<ProgramText>& texts_;
  const size_t own_;
  const ProgramNeighbours::SharedVariables* const shared_;
  KrlSyntax syntax_;
  std::string_view text_;
  size_t index_ = 0;  // of the text that is read
  Gives gives_ = Gives::all;
  bool is_source_ = false;  // of others
  bool has_sources_of_others_ = false;
  int routines_ = 0;           // of the .src, so far
  std::unordered_set<std::string> functions_;  // DEFFCT: a condition may call them
  std::unordered_map<std::string, Type> types_;
  std::unordered_map<std::string, Changes> changes_;
  std::unordered_map<std::string, double> numbers_;  // that the own data list declares
  std::unordered_set<std::string> set_by_others_;    // names to which their sources give values
  std::vector<bool> folds_;  // open ones; true: an inline form of the pendant
  int inline_forms_ = 0;     // of these
  KrlFlow flow_;
  bool in_set_up_ = false, trigger_ = false;
  std::optional<Statement> spline_block_;  // that is open: its first line
  std::unordered_map<std::string, Declaration> declarations_, of_others_;
  std::vector<NamedTarget> named_;
  std::vector<Product> products_;
  std::vector<NamedUse> uses_;
  std::unordered_map<std::string, std::vector<bool>> parameters_;  // of routines: which are :IN
  std::optional<std::vector<KrlCall>> calls_;  // of the .src, once they were asked for
};

}  // namespace

KrlSyntax parse_krl(const std::vector<ProgramText>& texts, size_t own,
                    const ProgramNeighbours::SharedVariables* shared) {
  return KrlParser(texts, own, shared).parse();
}

KrlSyntax parse_krl(const RobotProgram& program) {
  const auto& shared = program.neighbours.shared;
  return parse_krl(program.texts, program.own_texts, shared ? &*shared : nullptr);
}

}  // namespace armtrue
