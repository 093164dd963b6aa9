#include "programs/routine_copies.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "armtrue/programs/dialect.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"
#include "programs/text_edit.h"

namespace armtrue {
namespace {

int lines_in(std::string_view text) { return static_cast<int>(std::ranges::count(text, '\n')); }

// Where the places of a text are after edits. What is inserted at a place stands before it.
class MovedPlaces {
 public:
  explicit MovedPlaces(const std::vector<TextEdit>& edits) {
    for (const TextEdit& edit : edits)
      added_[{edit.begin, edit.end > edit.begin}] += edit.text.size() - (edit.end - edit.begin);
    size_t sum = 0;
    for (auto& [place, bytes] : added_) bytes = sum += bytes;
  }

  size_t begin(size_t place) const { return place + added({place, true}); }
  // The same of what ends at a place: what is inserted there stands behind it.
  size_t end(size_t place) const { return place + added({place, false}); }

 private:
  // Place, and whether bytes there are replaced: these change behind it.
  using Place = std::pair<size_t, bool>;
  size_t added(const Place& place) const {
    const auto behind = added_.lower_bound(place);
    return behind == added_.begin() ? 0 : std::prev(behind)->second;
  }
  std::map<Place, size_t> added_;  // bytes, modulo 2^64 as their sums
};

// Copies in rounds: a copy makes the frames after its call certain, and a copy of a caller calls
// the routine, too. So routines wait for their callers that get copies, and routines that call
// themselves get none.
class RoutineCopier {
 public:
  RoutineCopier(RobotProgram program, const KnownFrames& known, TargetParts parts)
      : program_(std::move(program)), known_(known), parts_(parts) {
    for (const ProgramText& text : program_.texts) take_names(text.text);
  }

  RobotProgram run() {
    constexpr int kMostRounds = 30;  // calls in one another, of no real program
    for (int round = 0; round < kMostRounds && copy_next(); ++round) {
    }
    return std::move(program_);
  }

 private:
  void take_names(const std::string& text) {
    each_word(text, {0, 0, text.size()},
              [&](const std::string& word, size_t, const TextCursor&) { names_.insert(word); });
  }

  // Returns whether the program has changed.
  bool copy_next() {
    routines_ = program_.dialect->routines(program_, known_);
    find_callers();
    edits_.clear();
    added_.clear();
    std::vector<Groups> wanted;
    for (size_t i = 0; i < routines_.size(); ++i) wanted.push_back(copies_of(i));
    const std::vector<char> waits = called_by_those_with(wanted);
    for (size_t i = 0; i < routines_.size(); ++i)
      if (!waits[i])
        for (const auto& [context, calls] : wanted[i]) add_copy(routines_[i], context, calls);
    if (edits_.empty()) return false;
    apply();
    return true;
  }

  // Calls with the same context.
  using Groups = std::vector<std::pair<std::string, std::vector<const RoutineCall*>>>;

  std::vector<char> called_by_those_with(const std::vector<Groups>& copies) const {
    std::vector<std::vector<size_t>> callees(routines_.size());
    for (size_t i = 0; i < routines_.size(); ++i)
      for (const size_t caller : callers_[i]) callees[caller].push_back(i);
    std::vector<char> found(routines_.size(), false);
    std::vector<size_t> open;
    for (size_t i = 0; i < routines_.size(); ++i)
      if (!copies[i].empty()) open.push_back(i);
    while (!open.empty()) {
      const size_t routine = open.back();
      open.pop_back();
      for (const size_t callee : callees[routine])
        if (!std::exchange(found[callee], true)) open.push_back(callee);
    }
    return found;
  }

  void find_callers() {
    callers_.assign(routines_.size(), {});
    needs_.assign(routines_.size(), false);
    std::vector<size_t> open;
    for (size_t i = 0; i < routines_.size(); ++i) {
      for (const RoutineCall& call : routines_[i].calls)
        if (const int caller = routine_at(call.begin); caller >= 0) callers_[i].insert(caller);
      if (routines_[i].depends_on_caller) open.push_back(i);
    }
    while (!open.empty()) {
      const size_t routine = open.back();
      open.pop_back();
      if (std::exchange(needs_[routine], true)) continue;
      open.insert(open.end(), callers_[routine].begin(), callers_[routine].end());
    }
  }

  // The innermost one; -1: none. They stand in the order of the text.
  int routine_at(size_t place) const {
    auto behind = std::ranges::upper_bound(routines_, place, {}, &Routine::begin);
    while (behind != routines_.begin())
      if (place < (--behind)->end) return static_cast<int>(behind - routines_.begin());
    return -1;
  }

  // The calls that get copies. The first calls keep the routine itself, if nothing else needs it
  // unchanged.
  Groups copies_of(size_t index) const {
    const Routine& routine = routines_[index];
    if (!needs_[index] || !routine.can_be_copied || is_copy(routine)) return {};
    Groups groups;
    bool stays = routine.has_other_callers;
    for (const RoutineCall& call : routine.calls) {
      stays |= call.context.empty();
      if (call.context.empty()) continue;
      auto group = std::ranges::find(groups, call.context, &Groups::value_type::first);
      if (group == groups.end()) group = groups.insert(group, {call.context, {}});
      group->second.push_back(&call);
    }
    const bool is_for_first = !stays && !groups.empty();
    if (is_for_first) groups.erase(groups.begin());
    return groups;
  }

  bool is_copy(const Routine& routine) const { return copy_of_name_.contains(routine.name); }

  void add_copy(const Routine& routine, const std::string& context,
                const std::vector<const RoutineCall*>& calls) {
    std::string& name = name_of_copy_[{upper(routine.name), context}];
    if (name.empty()) {
      name = free_name(routine.name);
      std::string text = text_of_copy(routine, name);
      const std::string& whole = program_.texts[0].text;
      if (whole[routine.end - 1] != '\n') text = line_end(whole, routine.end) + text;
      RoutineCopy copy;
      copy.name = name;
      copy.of = routine.name;
      copy.of_begin = routine.begin;
      copy.of_end = routine.end;
      edits_.push_back({0, routine.end, routine.end, text});
      added_.push_back({copy, edits_.back()});
    }
    for (const RoutineCall* call : calls) {
      edits_.push_back({0, call->begin, call->end, name});
      calls_.emplace_back(name, edits_.back());
    }
  }

  // Its calls are those of the routine before copies, and get copies of their own.
  std::string text_of_copy(const Routine& routine, const std::string& name) const {
    const std::string& src = program_.texts[0].text;
    std::vector<TextEdit> back;
    for (const RoutineCopy& copy : program_.copies)
      for (const RoutineCopy::Call& own : copy.calls)
        if (own.begin >= routine.begin && own.end <= routine.end)
          back.push_back({0, own.begin - routine.begin, own.end - routine.begin, own.was});
    const std::string whole =
        apply_edits(src.substr(routine.begin, routine.end - routine.begin), back, 0);
    return routine.before_name + name + whole.substr(routine.head_end - routine.begin);
  }

  // NAME_2, NAME_3; at most as long as the shortest rule of any maker has it.
  std::string free_name(const std::string& name) {
    constexpr size_t kLongest = 24;
    for (int number = 2;; ++number) {
      const std::string end = "_" + std::to_string(number);
      const std::string free = name.substr(0, kLongest - end.size()) + end;
      if (names_.insert(upper(free)).second) return free;
    }
  }

  // Writes the copies and their calls, and keeps the places of all copies.
  void apply() {
    if (program_.copies.empty()) program_.without_copies = program_.texts[0].text;
    const MovedPlaces now(edits_);
    for (RoutineCopy& copy : program_.copies) move(copy, now);
    for (Added& added : added_) {
      RoutineCopy& copy = added.copy;
      copy.begin = now.end(added.text.begin) + size_before(added.text);
      copy.end = copy.begin + added.text.text.size();
      copy.of_begin = now.begin(copy.of_begin);
      copy.of_end = now.end(copy.of_end);
      copy_of_name_[copy.name] = program_.copies.size();
      program_.copies.push_back(std::move(copy));
    }
    for (const auto& [name, call] : calls_) {
      const size_t begin = now.begin(call.begin);
      program_.copies[copy_of_name_.at(name)].calls.push_back(
          {begin, begin + call.text.size(), was(call)});
    }
    calls_.clear();
    keep_lines();
    std::vector<ProgramText> texts = std::move(program_.texts);
    texts[0].text = apply_edits(texts[0].text, edits_, 0);
    RobotProgram again;
    again.dialect = program_.dialect;
    again.own_texts = program_.own_texts;
    again.neighbours = std::move(program_.neighbours);
    again.copies = std::move(program_.copies);
    again.without_copies = std::move(program_.without_copies);
    again.lines = std::move(program_.lines);
    again.texts = std::move(texts);
    program_ = std::move(again);
    program_.dialect->parse(program_, known_, parts_);
  }

  std::string was(const TextEdit& call) const {
    return program_.texts[0].text.substr(call.begin, call.end - call.begin);
  }

  static void move(RoutineCopy& copy, const MovedPlaces& now) {
    copy.begin = now.begin(copy.begin);
    copy.end = now.end(copy.end);
    copy.of_begin = now.begin(copy.of_begin);
    copy.of_end = now.end(copy.of_end);
    for (RoutineCopy::Call& call : copy.calls) {
      call.begin = now.begin(call.begin);
      call.end = now.end(call.end);
    }
  }

  // Of the copies that stand at the same place before this one.
  size_t size_before(const TextEdit& text) const {
    size_t size = 0;
    for (const Added& added : added_) {
      if (&added.text == &text) break;
      if (added.text.begin == text.begin) size += added.text.text.size();
    }
    return size;
  }

  // The lines of a copy are those of its routine. The copies are in the order of their places.
  void keep_lines() {
    const std::string_view text = program_.texts[0].text;
    if (program_.lines.empty()) {
      program_.lines.resize(static_cast<size_t>(lines_in(text)) + 1);
      std::iota(program_.lines.begin(), program_.lines.end(), 1);
    }
    const std::vector<int> before = std::move(program_.lines);
    std::vector<int>& lines = program_.lines = {};
    const auto add = [&](size_t first, size_t behind) {
      lines.insert(lines.end(), before.begin() + static_cast<long>(first),
                   before.begin() + static_cast<long>(behind));
    };
    size_t place = 0, line_ends = 0, kept = 0;
    for (const Added& added : added_) {
      const size_t at = added.text.begin;
      line_ends += static_cast<size_t>(lines_in(text.substr(place, at - place)));
      place = at;
      const size_t behind = line_ends + (text[at - 1] == '\n' ? 0 : 1);
      add(kept, behind);
      kept = behind;
      add(behind - static_cast<size_t>(lines_in(added.text.text)), behind);
    }
    add(kept, before.size());
  }

  struct Added {
    RoutineCopy copy;
    TextEdit text;  // that inserts it
  };

  RobotProgram program_;
  const KnownFrames& known_;
  const TargetParts parts_;
  std::set<std::string> names_;
  std::map<std::pair<std::string, std::string>, std::string> name_of_copy_;  // by routine, context
  std::map<std::string, size_t> copy_of_name_;  // in the copies of the program
  std::vector<Routine> routines_;
  std::vector<std::set<size_t>> callers_;  // of each routine
  std::vector<char> needs_;                // of each: it, or one that it calls, depends on callers
  std::vector<TextEdit> edits_;            // of a round
  std::vector<Added> added_;
  std::vector<std::pair<std::string, TextEdit>> calls_;  // of copies, by their names
};

// Where copies stand, and how many bytes they and their calls add.
class CopyPlaces {
 public:
  static constexpr size_t kNone = -1;

  explicit CopyPlaces(const std::vector<RoutineCopy>& copies) : copies_(copies) {
    for (size_t i = 0; i < copies.size(); ++i) by_begin_[copies[i].begin] = i;
    added_[0] = 0;
    std::map<size_t, size_t> added;  // by where it ends
    for (const RoutineCopy& copy : copies) {
      added[copy.end] += copy.end - copy.begin;
      for (const RoutineCopy::Call& call : copy.calls)
        if (copy_at(call.begin) == kNone)
          added[call.end] += call.end - call.begin - call.was.size();
    }
    size_t sum = 0;
    for (const auto& [end, bytes] : added) added_[end] = sum += bytes;
  }

  // The copy that a place stands in.
  size_t copy_at(size_t place) const {
    const auto behind = by_begin_.upper_bound(place);
    if (behind == by_begin_.begin()) return kNone;
    const size_t copy = std::prev(behind)->second;
    return place < copies_[copy].end ? copy : kNone;
  }

  size_t without_copies(size_t place) const {
    if (const size_t copy = copy_at(place); copy != kNone) place = copies_[copy].begin;
    return place - std::prev(added_.upper_bound(place))->second;
  }

 private:
  const std::vector<RoutineCopy>& copies_;
  std::map<size_t, size_t> by_begin_;
  std::map<size_t, size_t> added_;  // from this place on: so many bytes, with those before it
};

// Which copies are needed. The innermost are mostly the last, and their calls then are known.
class CopyChooser {
 public:
  CopyChooser(const RobotProgram& program, const std::vector<TextEdit>& edits)
      : text_(program.texts[0].text), is_kept_(program.copies.size(), false) {
    for (const TextEdit& edit : edits)
      if (edit.file == 0) changes_.push_back({edit.begin, edit.end, edit.text, kNone});
    for (size_t i = 0; i < program.copies.size(); ++i)
      for (const RoutineCopy::Call& call : program.copies[i].calls)
        changes_.push_back({call.begin, call.begin, program.copies[i].name, i});
    std::ranges::stable_sort(changes_, {}, &Change::begin);
    while (find_kept(program.copies)) {
    }
  }

  bool is_kept(size_t copy) const { return is_kept_[copy]; }

 private:
  static constexpr size_t kNone = CopyPlaces::kNone;
  struct Change {
    size_t begin, end;
    std::string text;
    size_t copy;  // that is called, or kNone
  };
  // Line, place in the line, length, text.
  using Places = std::vector<std::tuple<int, size_t, size_t, std::string>>;

  // Returns whether there are more. A later copy may call one that was made before it.
  bool find_kept(const std::vector<RoutineCopy>& copies) {
    bool are_more = false;
    for (size_t i = copies.size(); i-- > 0;) {
      const RoutineCopy& copy = copies[i];
      if (is_kept_[i] || changes_in(copy.begin, copy.end) == changes_in(copy.of_begin, copy.of_end))
        continue;
      is_kept_[i] = are_more = true;
    }
    return are_more;
  }

  Places changes_in(size_t begin, size_t end) const {
    Places list;
    int line = 0;
    size_t at = begin;
    for (auto change = std::ranges::lower_bound(changes_, begin, {}, &Change::begin);
         change != changes_.end() && change->begin < end; ++change) {
      line += lines_in(std::string_view(text_).substr(at, change->begin - at));
      at = change->begin;
      if (change->copy == kNone || is_kept_[change->copy])
        list.emplace_back(line, at - line_begin(text_, at), change->end - at, change->text);
    }
    return list;
  }

  const std::string& text_;
  std::vector<Change> changes_;
  std::vector<char> is_kept_;
};

}  // namespace

RobotProgram with_routine_copies(RobotProgram program, const KnownFrames& known,
                                 TargetParts parts) {
  if (program.left_alone == 0 || parts != TargetParts::pose) return program;
  return RoutineCopier(std::move(program), known, parts).run();
}

const std::string& text_without_copies(const RobotProgram& program, size_t text) {
  return text == 0 && !program.copies.empty() ? program.without_copies : program.texts[text].text;
}

bool is_in_routine_copy(const RobotProgram& program, const ProgramPoint& point) {
  return point.text == 0 && std::ranges::any_of(program.copies, [&](const RoutineCopy& copy) {
           return copy.begin <= point.begin && point.begin < copy.end;
         });
}

size_t place_without_copies(const RobotProgram& program, size_t place) {
  return CopyPlaces(program.copies).without_copies(place);
}

std::vector<TextEdit> edits_without_copies(const RobotProgram& program,
                                           const std::vector<TextEdit>& edits,
                                           std::vector<size_t>& kept) {
  if (program.copies.empty()) return edits;
  const std::string& text = program.texts[0].text;
  const CopyPlaces places(program.copies);
  const CopyChooser chosen(program, edits);
  std::vector<TextEdit> result;
  std::vector<std::vector<TextEdit>> in_copies(program.copies.size());
  const auto add = [&](TextEdit edit) {
    const size_t copy = edit.file == 0 ? places.copy_at(edit.begin) : CopyPlaces::kNone;
    if (copy != CopyPlaces::kNone) {
      edit.begin -= program.copies[copy].begin;
      edit.end -= program.copies[copy].begin;
      in_copies[copy].push_back(std::move(edit));
      return;
    }
    if (edit.file == 0) {
      edit.begin = places.without_copies(edit.begin);
      edit.end = places.without_copies(edit.end);
    }
    result.push_back(std::move(edit));
  };
  for (const TextEdit& edit : edits) add(edit);
  // Outside of copies the call is that of the routine already, and in them that of the copy.
  for (size_t i = 0; i < program.copies.size(); ++i)
    for (const RoutineCopy::Call& call : program.copies[i].calls) {
      const bool is_in_copy = places.copy_at(call.begin) != CopyPlaces::kNone;
      if (is_in_copy == chosen.is_kept(i)) continue;
      const size_t begin = places.without_copies(call.begin);
      if (is_in_copy)
        add({0, call.begin, call.end, call.was});
      else
        result.push_back(
            {0, begin, begin + call.was.size(), text.substr(call.begin, call.end - call.begin)});
    }
  for (size_t i = 0; i < program.copies.size(); ++i) {
    if (!chosen.is_kept(i)) continue;
    kept.push_back(i);
    const RoutineCopy& copy = program.copies[i];
    const size_t at = places.without_copies(copy.begin);
    result.push_back(
        {0, at, at, apply_edits(text.substr(copy.begin, copy.end - copy.begin), in_copies[i], 0)});
  }
  return result;
}

}  // namespace armtrue
