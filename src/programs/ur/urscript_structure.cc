#include "programs/ur/urscript_structure.h"

#include <algorithm>
#include <functional>
#include <map>
#include <set>

namespace armtrue {
namespace {

using Step = ProgramFlow::Step;

class UrStructureReader {
 public:
  explicit UrStructureReader(std::string_view text) : text_(text) {}

  UrStructure read(const std::vector<Statement>& statements) {
    for (const Statement& statement : statements)
      each_word(text_, statement, [&](const std::string& word, size_t, TextCursor cursor) {
        if (const std::string name = function_of(word, cursor); !name.empty())
          functions_.insert(name);
        if (word == "RUN") run_.insert(cursor.take_name());
      });
    find_acting(statements);
    for (const Statement& statement : statements)
      each_word(text_, statement, [&](const std::string& word, size_t at, TextCursor& cursor) {
        read_word(word, at, cursor);
      });
    if (const auto open = std::ranges::find(open_, true, &Open::is_function); open != open_.end())
      result_.open = open->at;
    const std::set<std::string> begun = begun_from_outside();
    for (const auto& [name, range] : inner_)
      if (!begun.contains(name)) result_.never_run.push_back(range);
    return std::move(result_);
  }

 private:
  // What an `end` ends: a function, or a block.
  struct Open {
    size_t at;
    bool is_function;
    std::string name{};                    // of a function within another one
    std::optional<size_t> behind_leave{};  // halt or return that no block may pass over
  };

  // The name behind DEF, THREAD or SEC; empty if no function begins here. The cursor then stands
  // behind the name.
  static std::string function_of(const std::string& word, TextCursor& cursor) {
    if (word != "DEF" && word != "THREAD" && word != "SEC") return "";
    TextCursor behind = cursor;
    const std::string name = behind.take_name();
    if (name.empty() || behind.next() != '(') return "";
    cursor = behind;
    return name;
  }

  void find_acting(const std::vector<Statement>& statements) {
    struct Part {
      std::string name;  // of a function; blocks have none
      bool is_acting = false;
    };
    std::vector<Part> open;
    for (const Statement& statement : statements)
      each_word(text_, statement, [&](const std::string& word, size_t, TextCursor& cursor) {
        if (const std::string name = function_of(word, cursor); !name.empty())
          open.push_back({name});
        else if (word == "IF" || word == "WHILE")
          open.emplace_back();
        else if (word == "END" && !open.empty())
          open.pop_back();
        else if (is_ur_move(word) || word == "RUN" ||
                 (functions_.contains(word) && cursor.next() == '('))
          for (auto part = open.rbegin(); part != open.rend() && !part->is_acting; ++part) {
            part->is_acting = true;
            acting_.insert(part->name);
          }
      });
  }

  void read_word(const std::string& word, size_t at, TextCursor& cursor) {
    ProgramFlow& flow = result_.flow;
    if (const std::string name = function_of(word, cursor); !name.empty()) {
      const bool is_inner = std::ranges::find(open_, true, &Open::is_function) != open_.end();
      const Step step = is_inner ? Step::local_routine : Step::routine;
      const bool may_interrupt = word == "THREAD" && (!is_inner || run_.contains(name));
      flow.add(may_interrupt ? Step::interrupt : step, at, name);
      result_.scopes.open(at);
      read_parameters(name, cursor, result_.scopes.at(at));
      open_.push_back({at, true, is_inner ? name : ""});
    } else if (word == "IF" || word == "WHILE") {
      flow.add(word == "IF" ? Step::branch : loop_of(cursor), at);
      open_.push_back({at, false});
    } else if (word == "ELIF" || word == "ELSE") {
      flow.add(word == "ELIF" ? Step::alternative : Step::otherwise, at);
    } else if (word == "END" && !open_.empty()) {
      flow.add(open_.back().is_function ? Step::end_routine : Step::end_block, at);
      if (open_.back().is_function) result_.scopes.close(at);
      if (const auto behind = open_.back().behind_leave)
        result_.never_run.emplace_back(*behind, at);
      if (!open_.back().name.empty())
        inner_.emplace(open_.back().name, std::pair(open_.back().at, at));
      open_.pop_back();
    } else if (word == "BREAK" || word == "RETURN") {
      flow.add(word == "BREAK" ? Step::exit_loop : Step::leave, at);
      if (word == "RETURN") note_leave(cursor);
    } else if (word == "HALT" && cursor.next() != '=' && cursor.next() != '(') {
      flow.add(Step::stop, at);
      note_leave(cursor);
    } else if (word == "CONTINUE") {
      flow.add(Step::jump, at);
    } else if (word == "RUN") {
      const std::string thread = cursor.take_name();
      if (acting_.contains(thread)) flow.add(Step::start, at, thread);
      begun_by_[inner_function()].insert(thread);
    } else if (functions_.contains(word) && cursor.next() == '(') {
      flow.add(Step::call, at, word);
      begun_by_[inner_function()].insert(word);
    }
  }

  // while (True):
  static Step loop_of(TextCursor condition) {
    while (condition.take('(')) {
    }
    const bool is_true =
        condition.take_name() == "TRUE" && (condition.next() == ')' || condition.next() == ':');
    return is_true ? Step::repeat : Step::loop;
  }

  // In a block it may be passed over.
  void note_leave(const TextCursor& cursor) {
    if (open_.empty() || !open_.back().is_function || open_.back().behind_leave) return;
    open_.back().behind_leave = cursor.at();
  }

  // The innermost function that is open, if it stands within another one; else empty.
  std::string inner_function() const {
    const auto open = std::find_if(open_.rbegin(), open_.rend(), std::mem_fn(&Open::is_function));
    return open == open_.rend() ? "" : open->name;
  }

  // What the outermost functions call or run, and what that does.
  std::set<std::string> begun_from_outside() const {
    std::set<std::string> begun;
    for (std::vector<std::string> next{""}; !next.empty();) {
      const auto by = begun_by_.find(next.back());
      next.pop_back();
      if (by == begun_by_.end()) continue;
      for (const std::string& name : by->second)
        if (begun.insert(name).second) next.push_back(name);
    }
    return begun;
  }

  // (pose, speed=0.1)
  void read_parameters(const std::string& function, TextCursor cursor, int scope) {
    if (!cursor.take('(')) return;
    const size_t begin = cursor.at();
    cursor.skip_to(")");
    size_t position = 0;
    for (const Statement& part : split_arguments(text_, begin, cursor.at(), ","))
      if (const size_t length = TextCursor(text_, part.begin, part.end).take_name().size();
          length > 0)
        result_.parameters.push_back({std::string(text_.substr(part.begin, length)),
                                      part.begin,
                                      scope,
                                      {function, position++}});
  }

  std::string_view text_;
  std::set<std::string> functions_, run_;  // in capitals; the threads that something runs
  // Those that move the arm, or call or run others. Where the others run does not count, such as
  // the counter that PolyScope starts before it sets the tool.
  std::set<std::string> acting_;
  std::vector<Open> open_;
  std::multimap<std::string, std::pair<size_t, size_t>> inner_;  // functions within others
  std::map<std::string, std::set<std::string>> begun_by_;        // what inner functions call or run
  UrStructure result_;
};

}  // namespace

bool is_ur_move(const std::string& word) {
  return word == "MOVEJ" || word == "MOVEL" || word == "MOVEP" || word == "MOVEC" ||
         word == "OPTIMOVEJ" || word == "OPTIMOVEL";
}

bool is_other_ur_motion(const std::string& word) {
  for (const char* name : {"SERVOJ", "SERVOC", "SERVOL", "SPEEDJ", "SPEEDL"})
    if (word == name) return true;
  return false;
}

UrStructure structure_of_urscript(std::string_view text, const std::vector<Statement>& statements) {
  return UrStructureReader(text).read(statements);
}

}  // namespace armtrue
