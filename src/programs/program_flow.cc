#include "programs/program_flow.h"

#include <algorithm>
#include <map>
#include <optional>

namespace armtrue {
namespace {

constexpr int kUncertain = ProgramFlow::kUncertain;
constexpr int kUnreached = kUncertain + 1;

}  // namespace

// Goes through the text until no value changes any more: what the end of a loop or a routine passes
// on counts before it in the text, too.
class FlowOfValue {
 public:
  FlowOfValue(const ProgramFlow& flow, const std::vector<ProgramFlow::Setting>& settings,
              int initial)
      : initial_(initial) {
    for (const ProgramFlow::Place& place : flow.steps_) events_.push_back({place, std::nullopt});
    for (const ProgramFlow::Setting& setting : settings)
      events_.push_back({{setting.at, Step::label, ""}, setting.value});
    std::ranges::stable_sort(events_, {}, [](const Event& event) { return event.place.at; });
    routines_.push_back({"", false, false});  // the text outside
    for (const Event& event : events_)
      if (begins_routine(event))
        routines_.push_back({event.place.name, event.place.step == Step::interrupt, false});
    for (const Event& event : events_)
      if (event.place.step == Step::call)
        for (Routine& routine : routines_) routine.is_called |= is_meant(routine, event);
    merge(routines_[0].entry, initial);
  }

  ProgramFlow::Values run() {
    do {
      is_changed_ = false;
      pass();
    } while (is_changed_);
    ProgramFlow::Values result;
    result.initial_ = is_spoiled_ ? kUncertain : initial_;
    if (!is_spoiled_) result.changes_ = values_;
    return result;
  }

 private:
  using Step = ProgramFlow::Step;
  struct Event {
    ProgramFlow::Place place;
    std::optional<int> setting;
  };
  struct Routine {
    std::string name;
    bool is_interrupt = false, is_called = false;
    int entry = kUnreached, end = kUnreached, jumped = kUnreached, seen = kUnreached;
  };
  struct Block {
    std::optional<size_t> loop;  // the event that begins it
    int entry = kUnreached, ended = kUnreached;
  };
  // A routine that is read, and the value before it in the text.
  struct Open {
    size_t routine = 0;
    int value = kUnreached;
    std::vector<Block> blocks;
  };

  static bool begins_routine(const Event& event) {
    return event.place.step == Step::routine || event.place.step == Step::interrupt;
  }
  static bool is_meant(const Routine& routine, const Event& call) {
    return !routine.is_interrupt && !routine.name.empty() &&
           (call.place.name.empty() || call.place.name == routine.name);
  }

  void merge(int& into, int value) {
    if (value == kUnreached || into == value || into == kUncertain) return;
    into = into == kUnreached ? value : kUncertain;
    is_changed_ = true;
  }
  static int joined(int a, int b) {
    if (a == kUnreached || a == b) return b;
    return b == kUnreached ? a : kUncertain;
  }

  void pass() {
    values_.clear();
    open_ = {Open{}};
    value_ = routines_[0].entry;
    size_t next = 1;  // routine
    for (size_t i = 0; i < events_.size(); ++i) {
      const Event& event = events_[i];
      if (begins_routine(event))
        begin(next++);
      else if (event.setting)
        set(*event.setting);
      else
        take(event, i);
      merge(now().seen, value_);
      values_.emplace_back(event.place.at, value_);
    }
    while (open_.size() > 1) end();
    merge(now().end, joined(value_, now().jumped));
  }

  Routine& now() { return routines_[open_.back().routine]; }

  void begin(size_t index) {
    Routine& routine = routines_[index];
    if (!routine.is_called) merge(routine.entry, initial_);
    for (const Routine& other : routines_) {
      if (&other == &routine || other.is_interrupt) continue;
      if (routine.is_interrupt)
        merge(routine.entry, other.seen);
      else if (!routine.is_called && !other.is_called)
        merge(routine.entry, other.end);
    }
    open_.push_back({index, value_, {}});
    value_ = routine.entry;
  }

  void end() {
    merge(now().end, joined(value_, now().jumped));
    value_ = open_.back().value;
    open_.pop_back();
  }

  // What an interrupt sets holds anywhere.
  void set(int value) {
    is_spoiled_ |= now().is_interrupt;
    value_ = value;
  }

  void take(const Event& event, size_t index) {
    std::vector<Block>& blocks = open_.back().blocks;
    switch (event.place.step) {
      case Step::routine:
      case Step::interrupt:
        break;
      case Step::end_routine:
        if (open_.size() > 1) end();
        break;
      case Step::call:
        call(event);
        break;
      case Step::branch:
        blocks.push_back({std::nullopt, value_, kUnreached});
        break;
      case Step::loop:
        value_ = joined(value_, passed_back_.try_emplace(index, kUnreached).first->second);
        blocks.push_back({index, value_, kUnreached});
        break;
      case Step::alternative:
        if (blocks.empty()) break;
        blocks.back().ended = joined(blocks.back().ended, value_);
        value_ = blocks.back().entry;
        break;
      case Step::end_block:
        if (!blocks.empty()) end_block(blocks);
        break;
      case Step::jump:
        merge(now().jumped, value_);
        break;
      case Step::label:
        value_ = joined(value_, now().jumped);
        break;
      case Step::handler:
        value_ = joined(value_, now().seen);
        break;
    }
  }

  void end_block(std::vector<Block>& blocks) {
    const Block& block = blocks.back();
    if (block.loop) {
      value_ = joined(value_, now().jumped);
      merge(passed_back_[*block.loop], value_);
    }
    value_ = joined(joined(value_, block.ended), block.entry);
    blocks.pop_back();
  }

  void call(const Event& event) {
    int after = kUnreached;
    bool is_here = false;
    for (Routine& routine : routines_) {
      if (!is_meant(routine, event)) continue;
      is_here = true;
      merge(routine.entry, value_);
      after = joined(after, routine.end);
    }
    if (is_here) value_ = event.place.name.empty() ? joined(value_, after) : after;
  }

  const int initial_;
  std::vector<Event> events_;
  std::vector<Routine> routines_;
  std::map<size_t, int> passed_back_;  // to the begin of a loop
  std::vector<std::pair<size_t, int>> values_;
  std::vector<Open> open_;
  int value_ = kUnreached;
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
