#include "programs/program_flow.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace armtrue {
namespace {

constexpr int kUncertain = ProgramFlow::kUncertain;
constexpr int kUnreached = kUncertain + 1;

}  // namespace

// Follows each routine until no value changes any more: what the end of a loop or of a routine that
// is called passes on counts before it in the text, too. All values only go from unreached to one
// value to uncertain, so each routine is followed a few times, whatever the order. A call follows
// the routine that it calls at once if that begins with another value than before: so a long list
// of calls, each of which has what the one before leaves, is followed once.
class FlowOfValue {
 public:
  FlowOfValue(const ProgramFlow& flow, const std::vector<ProgramFlow::Setting>& settings,
              int initial)
      : initial_(initial) {
    for (const ProgramFlow::Place& place : flow.steps_) events_.push_back({place, std::nullopt});
    for (const ProgramFlow::Setting& setting : settings)
      events_.push_back({{setting.at, Step::label, ""}, setting.value});
    std::ranges::stable_sort(events_, {}, [](const Event& event) { return event.place.at; });
    find_routines();
    find_calls();
    merge(routines_[0].entry, initial);
    for (size_t i = routines_.size(); i-- > 0;) stale_.push_back(i);
  }

  ProgramFlow::Values run() {
    do {
      is_changed_ = false;
      for (size_t i = 0; i < routines_.size(); ++i) begin(i);
      while (!stale_.empty()) {
        const size_t last = stale_.back();
        stale_.pop_back();
        follow(last);
      }
    } while (is_changed_);
    ProgramFlow::Values result;
    result.initial_ = is_spoiled_ ? kUncertain : initial_;
    if (is_spoiled_) return result;
    for (size_t i = 0; i < events_.size(); ++i)
      result.changes_.emplace_back(events_[i].place.at, events_[i].value);
    return result;
  }

 private:
  using Step = ProgramFlow::Step;
  struct Event {
    ProgramFlow::Place place;
    std::optional<int> setting;
    int value = kUnreached;  // behind it
  };
  struct Routine {
    std::string name;
    bool is_interrupt = false, is_called = false;
    int entry = kUnreached, end = kUnreached, jumped = kUnreached, seen = kUnreached;
    int left = kUnreached;                 // by Step::leave
    std::map<std::string, int> gone_to{};  // labels, by Step::go_to
    std::vector<size_t> events{};   // its own, in their order
    std::vector<size_t> callers{};  // routines that call it by name
    bool is_stale = true;           // a value that it depends on has changed
    bool is_open = false;           // it is being followed
  };
  struct Block {
    std::optional<size_t> loop;  // the event that begins it
    int entry = kUnreached, ended = kUnreached;  // kUnreached: no way leads there
  };
  // A routine that is followed.
  struct Walk {
    size_t routine = 0;
    int value = kUnreached;
    std::vector<Block> blocks{};
    bool is_dead = false;  // no way leads here; then the value is that of the text before

    int alive() const { return is_dead ? kUnreached : value; }
    void come_from(int all_ways) {
      is_dead &= all_ways == kUnreached;
      if (all_ways != kUnreached) value = all_ways;
    }
  };

  static bool begins_routine(const Event& event) {
    return !event.setting &&
           (event.place.step == Step::routine || event.place.step == Step::interrupt);
  }

  // A routine within another one interrupts the text of the other.
  void find_routines() {
    routines_.push_back({"", false, false});  // the text outside
    std::vector<size_t> open{0};
    for (size_t i = 0; i < events_.size(); ++i) {
      const Event& event = events_[i];
      if (begins_routine(event)) {
        open.push_back(routines_.size());
        routines_.push_back({event.place.name, event.place.step == Step::interrupt, false});
      } else if (!event.setting && event.place.step == Step::end_routine && open.size() > 1) {
        open.pop_back();
      }
      routines_[open.back()].events.push_back(i);
    }
    for (size_t i = 1; i < routines_.size(); ++i)
      if (!routines_[i].is_interrupt && !routines_[i].name.empty())
        named_[routines_[i].name].push_back(i);
  }

  void find_calls() {
    bool is_any_called = false;
    for (size_t i = 0; i < routines_.size(); ++i)
      for (const size_t event : routines_[i].events) {
        const ProgramFlow::Place& place = events_[event].place;
        if (events_[event].setting || place.step != Step::call) continue;
        if (place.name.empty()) {
          is_any_called = true;
          callers_of_any_.push_back(i);
        } else if (const auto meant = named_.find(place.name); meant != named_.end()) {
          for (const size_t callee : meant->second) {
            Routine& routine = routines_[callee];
            routine.is_called = true;
            if (routine.callers.empty() || routine.callers.back() != i)
              routine.callers.push_back(i);
          }
        }
      }
    if (is_any_called)
      for (const auto& [name, meant] : named_)
        for (const size_t callee : meant) routines_[callee].is_called = true;
  }

  // Returns whether the value has changed.
  bool merge(int& into, int value) {
    if (value == kUnreached || into == value || into == kUncertain) return false;
    into = into == kUnreached ? value : kUncertain;
    return is_changed_ = true;
  }
  static int joined(int a, int b) {
    if (a == kUnreached || a == b) return b;
    return b == kUnreached ? a : kUncertain;
  }

  // What a routine begins with, but for its calls.
  void begin(size_t index) {
    Routine& routine = routines_[index];
    if (index == 0) return;
    if (!routine.is_called) enter(index, initial_);
    if (routine.is_interrupt)
      enter(index, seen_);
    else if (!routine.is_called)
      enter(index, end_of_other_uncalled(routine.end));
    if (!routine.is_interrupt && !routine.name.empty()) enter(index, value_of_any_call_);
  }

  void enter(size_t index, int value) {
    if (merge(routines_[index].entry, value)) make_stale(index);
  }

  void make_stale(size_t index) {
    if (routines_[index].is_stale) return;
    routines_[index].is_stale = true;
    stale_.push_back(index);
  }

  // Of the routines that nothing calls, the text outside among them, but for one with this end.
  int end_of_other_uncalled(int own) const {
    int all = kUnreached;
    for (const auto& [end, count] : uncalled_ends_) {
      if (count > (end == own ? 1 : 0)) all = joined(all, end);
      if (all == kUncertain) break;
    }
    return all;
  }

  void follow(size_t index) {
    // Calls within calls beyond this depth wait in stale_, so that the stack suffices.
    constexpr int kDeepest = 1000;
    if (routines_[index].is_open || depth_ >= kDeepest) return;
    ++depth_;
    routines_[index].is_open = true;
    while (routines_[index].is_stale) {
      routines_[index].is_stale = false;
      pass(index);
    }
    routines_[index].is_open = false;
    --depth_;
  }

  void pass(size_t index) {
    Routine& routine = routines_[index];
    Walk walk{index, routine.entry};
    for (const size_t i : routine.events) {
      Event& event = events_[i];
      if (event.setting)
        set(*event.setting, walk);
      else
        take(event, i, walk);
      see(index, walk.value);
      event.value = walk.value;
    }
    end(routine, joined(joined(walk.alive(), routine.jumped), routine.left));
  }

  void see(size_t index, int value) {
    Routine& routine = routines_[index];
    if (!merge(routine.seen, value)) return;
    make_stale(index);  // for handlers
    if (!routine.is_interrupt) merge(seen_, value);
  }

  void end(Routine& routine, int value) {
    const int before = routine.end;
    if (!merge(routine.end, value)) return;
    for (const size_t caller : routine.callers) make_stale(caller);
    if (routine.is_interrupt) return;
    if (!routine.name.empty() && merge(end_of_any_, routine.end))
      for (const size_t caller : callers_of_any_) make_stale(caller);
    if (routine.is_called) return;
    if (before != kUnreached && --uncalled_ends_[before] == 0) uncalled_ends_.erase(before);
    ++uncalled_ends_[routine.end];
  }

  // What an interrupt sets holds anywhere.
  void set(int value, Walk& walk) {
    is_spoiled_ |= routines_[walk.routine].is_interrupt;
    walk.value = value;
  }

  void take(const Event& event, size_t index, Walk& walk) {
    Routine& routine = routines_[walk.routine];
    std::vector<Block>& blocks = walk.blocks;
    int& value = walk.value;
    switch (event.place.step) {
      case Step::routine:
      case Step::interrupt:
      case Step::end_routine:
        break;
      case Step::call:
        call(event, walk);
        break;
      case Step::branch:
        blocks.push_back({std::nullopt, walk.alive(), kUnreached});
        break;
      case Step::loop:
        walk.come_from(
            joined(walk.alive(), passed_back_.try_emplace(index, kUnreached).first->second));
        blocks.push_back({index, walk.alive(), kUnreached});
        break;
      case Step::alternative:
        if (blocks.empty()) break;
        blocks.back().ended = joined(blocks.back().ended, walk.alive());
        walk.is_dead = true;
        walk.come_from(blocks.back().entry);
        break;
      case Step::end_block:
        if (!blocks.empty()) end_block(walk);
        break;
      case Step::jump:
        if (merge(routine.jumped, value)) make_stale(walk.routine);
        break;
      case Step::go_to:
        pass_on(routine.gone_to.try_emplace(event.place.name, kUnreached).first->second, walk);
        break;
      case Step::leave:
        pass_on(routine.left, walk);
        break;
      case Step::exit_loop:
        exit_loop(walk);
        break;
      case Step::label: {
        const auto gone = routine.gone_to.find(event.place.name);
        const int from = gone == routine.gone_to.end() ? kUnreached : gone->second;
        walk.come_from(joined(joined(walk.alive(), routine.jumped), from));
        break;
      }
      case Step::handler:
        value = joined(value, routine.seen);
        break;
    }
  }

  // Nothing behind it comes from here.
  void pass_on(int& into, Walk& walk) {
    if (merge(into, walk.alive())) make_stale(walk.routine);
    walk.is_dead = true;
  }

  void exit_loop(Walk& walk) {
    const auto is_loop = [](const Block& block) { return block.loop.has_value(); };
    const auto loop = std::ranges::find_if(walk.blocks.rbegin(), walk.blocks.rend(), is_loop);
    if (loop == walk.blocks.rend()) return;
    loop->ended = joined(loop->ended, walk.alive());
    walk.is_dead = true;
  }

  void end_block(Walk& walk) {
    Routine& routine = routines_[walk.routine];
    const Block& block = walk.blocks.back();
    int value = walk.alive();
    if (block.loop) {
      value = joined(value, routine.jumped);
      if (merge(passed_back_[*block.loop], value)) make_stale(walk.routine);
    }
    walk.is_dead = true;
    walk.come_from(joined(joined(value, block.ended), block.entry));
    walk.blocks.pop_back();
  }

  void call(const Event& event, Walk& walk) {
    if (event.place.name.empty()) {
      merge(value_of_any_call_, walk.value);
      walk.value = joined(walk.value, end_of_any_);
      return;
    }
    const auto meant = named_.find(event.place.name);
    if (meant == named_.end()) return;  // it stands in another text
    int after = kUnreached;
    for (const size_t callee : meant->second) {
      enter(callee, walk.value);
      follow(callee);
      after = joined(after, routines_[callee].end);
    }
    walk.value = after;
  }

  const int initial_;
  std::vector<Event> events_;
  std::vector<Routine> routines_;
  std::map<std::string, std::vector<size_t>> named_;  // routines that a name calls
  std::vector<size_t> callers_of_any_;                // that call a routine without its name
  std::vector<size_t> stale_;                         // to be followed, the last one first
  std::map<size_t, int> passed_back_;                 // to the begin of a loop
  std::map<int, int> uncalled_ends_;  // how many routines that nothing calls end with a value
  int seen_ = kUnreached;             // anywhere but in interrupts
  int value_of_any_call_ = kUnreached, end_of_any_ = kUnreached;
  int depth_ = 0;
  bool is_changed_ = false, is_spoiled_ = false;
};

int ProgramFlow::Values::at(size_t place) const {
  const auto behind = std::ranges::upper_bound(changes_, place, {}, &std::pair<size_t, int>::first);
  const int value = behind == changes_.begin() ? initial_ : std::prev(behind)->second;
  return value == kUnreached ? kUncertain : value;
}

ProgramFlow::Values ProgramFlow::follow(const std::vector<Setting>& settings, int initial) const {
  if (!settings.empty()) return FlowOfValue(*this, settings, initial).run();
  Values result;
  result.initial_ = initial;
  return result;
}

}  // namespace armtrue
