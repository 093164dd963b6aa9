#include "programs/program_flow.h"

#include <algorithm>
#include <set>

namespace armtrue {
namespace {

constexpr int kUncertain = ProgramFlow::kUncertain;
constexpr int kUnreached = kUncertain + 1;

bool begins_routine(ProgramFlow::Step step) {
  return step == ProgramFlow::Step::routine || step == ProgramFlow::Step::local_routine ||
         step == ProgramFlow::Step::interrupt;
}

int joined(int a, int b) {
  if (a == kUnreached || a == b) return b;
  return b == kUnreached ? a : kUncertain;
}

}  // namespace

// Follows each routine until no value changes any more: the end of a loop, or of a called routine,
// passes its value to an earlier place of the text. A value only changes from unreached to one
// value to uncertain, so each routine is followed a few times, in any order. A call follows the
// routine that it calls at once if that begins with another value than before: so a long list of
// calls, each of which has what the one before leaves, is followed once.
class FlowOfValue {
 public:
  FlowOfValue(const std::vector<const ProgramFlow::Place*>& steps,
              const std::vector<ProgramFlow::Setting>& settings, int initial)
      : initial_(initial) {
    for (const ProgramFlow::Place* step : steps) events_.push_back({step->at, step});
    for (const ProgramFlow::Setting& setting : settings)
      events_.push_back({setting.at, nullptr, setting.value});
    std::ranges::stable_sort(events_, {}, &Event::at);
    find_routines();
    find_starts(steps);
    find_calls();
    find_changing();
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
    int before = initial_;
    for (const Event& event : events_) {
      if (event.value != before) result.changes_.emplace_back(event.at, event.value);
      before = event.value;
    }
    return result;
  }

  // Whether a way leads to the end of each routine that begins; in the order of the text, the text
  // outside first.
  std::vector<bool> ends() const {
    std::vector<bool> all;
    for (const Routine& routine : routines_)
      all.push_back(routine.end != kUnreached || routine.entry == kUnreached);
    return all;
  }

 private:
  using Step = ProgramFlow::Step;
  struct Event {
    size_t at;
    const ProgramFlow::Place* step;  // null: a setting
    int setting = 0;
    int value = kUnreached;  // behind it
  };
  struct Routine {
    std::string name;
    bool is_interrupt = false, is_called = false;
    bool is_started = false;  // an interrupt that runs only behind a step that starts it
    bool is_local = false;    // nothing but calls of this text begins it
    bool changes = false;     // the value, by itself or by a call; else each call has it again
    int entry = kUnreached, end = kUnreached, jumped = kUnreached, seen = kUnreached;
    int left = kUnreached;                 // by Step::leave
    std::map<std::string, int> gone_to{};  // labels, by Step::go_to
    std::vector<size_t> events{};          // its own, in their order
    std::vector<size_t> callers{};         // routines that call it by name
    bool is_stale = true;                  // a value that it depends on has changed
    bool is_open = false;                  // it is being followed
  };
  struct Block {
    std::optional<size_t> loop;                  // the event that begins it
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

  // A routine within another one interrupts the text of the other.
  void find_routines() {
    routines_.push_back({"", false, false});  // the text outside
    std::vector<size_t> open{0};
    for (size_t i = 0; i < events_.size(); ++i) {
      const Event& event = events_[i];
      if (event.step && begins_routine(event.step->step)) {
        open.push_back(routines_.size());
        routines_.push_back({event.step->name, event.step->step == Step::interrupt, false});
        routines_.back().is_local = event.step->step == Step::local_routine;
      } else if (event.step && event.step->step == Step::end_routine && open.size() > 1) {
        open.pop_back();
      }
      routines_[open.back()].events.push_back(i);
    }
    for (size_t i = 1; i < routines_.size(); ++i)
      if (!routines_[i].is_interrupt && !routines_[i].name.empty())
        named_[routines_[i].name].push_back(i);
  }

  // Where a started interrupt may run: a flow of its own, in which each start is a setting. What
  // started interrupts start, or call, runs behind their own starts.
  void find_starts(const std::vector<const ProgramFlow::Place*>& steps) {
    std::set<std::string> names;
    for (const ProgramFlow::Place* const step : steps)
      if (step->step == Step::start) names.insert(step->name);
    if (names.empty()) return;
    for (Routine& routine : routines_)
      routine.is_started = routine.is_interrupt && names.contains(routine.name);
    std::vector<const ProgramFlow::Place*> others;
    std::vector<ProgramFlow::Setting> starts;
    int open = 0;  // routines, from a started interrupt on
    for (const ProgramFlow::Place* const step : steps) {
      const bool begins = step->step == Step::interrupt && names.contains(step->name);
      if (open > 0 || begins)
        open += begins_routine(step->step) ? 1 : step->step == Step::end_routine ? -1 : 0;
      else if (step->step == Step::start)
        starts.push_back({step->at, 1});
      else
        others.push_back(step);
    }
    started_ = FlowOfValue(others, starts, 0).run();
  }

  void find_calls() {
    bool is_any_called = false;
    for (size_t i = 0; i < routines_.size(); ++i)
      for (const size_t event : routines_[i].events) {
        const ProgramFlow::Place* const step = events_[event].step;
        if (!step || step->step != Step::call) continue;
        if (step->name.empty()) {
          is_any_called = true;
          callers_of_any_.push_back(i);
        } else if (const auto meant = named_.find(step->name); meant != named_.end()) {
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

  void find_changing() {
    std::vector<size_t> open = callers_of_any_;
    for (size_t i = 0; i < routines_.size(); ++i)
      if (std::ranges::any_of(routines_[i].events,
                              [&](size_t event) { return !events_[event].step; }))
        open.push_back(i);
    while (!open.empty()) {
      Routine& routine = routines_[open.back()];
      open.pop_back();
      if (!std::exchange(routine.changes, true))
        open.insert(open.end(), routine.callers.begin(), routine.callers.end());
    }
    // What an interrupt sets, itself or by a call, holds anywhere.
    is_spoiled_ = std::ranges::any_of(
        routines_, [](const Routine& routine) { return routine.is_interrupt && routine.changes; });
  }

  // Returns whether the value has changed.
  bool merge(int& into, int value) {
    if (value == kUnreached || into == value || into == kUncertain) return false;
    into = into == kUnreached ? value : kUncertain;
    return is_changed_ = true;
  }
  // What a routine begins with, but for its calls.
  void begin(size_t index) {
    Routine& routine = routines_[index];
    if (index == 0 || (routine.is_local && !routine.is_called)) return;
    if (!routine.is_called && !routine.is_started) enter(index, initial_);
    if (routine.is_interrupt)
      enter(index, routine.is_started ? seen_behind_starts_ : seen_);
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
    if (routine.is_local && routine.entry == kUnreached) return;
    Walk walk{index, routine.entry};
    for (const size_t i : routine.events) {
      Event& event = events_[i];
      if (event.step)
        take(*event.step, i, walk);
      else
        walk.value = event.setting;
      see(index, event.at, walk.value);
      event.value = walk.value;
    }
    end(routine, joined(joined(walk.alive(), routine.jumped), routine.left));
  }

  void see(size_t index, size_t at, int value) {
    Routine& routine = routines_[index];
    const bool may_be_started = started_ && started_->behind(at) != 0;
    if (may_be_started && !routine.is_interrupt) merge(seen_behind_starts_, value);
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

  void take(const ProgramFlow::Place& step, size_t index, Walk& walk) {
    Routine& routine = routines_[walk.routine];
    std::vector<Block>& blocks = walk.blocks;
    int& value = walk.value;
    switch (step.step) {
      case Step::routine:
      case Step::local_routine:
      case Step::interrupt:
      case Step::start:
      case Step::end_routine:
        break;
      case Step::call:
        call(step, walk);
        break;
      case Step::branch:
        blocks.push_back({std::nullopt, walk.alive(), kUnreached});
        break;
      case Step::choice:
        blocks.push_back({std::nullopt, walk.alive(), kUnreached});
        walk.is_dead = true;
        break;
      case Step::loop:
      case Step::repeat:
        walk.come_from(
            joined(walk.alive(), passed_back_.try_emplace(index, kUnreached).first->second));
        blocks.push_back({index, step.step == Step::loop ? walk.alive() : kUnreached, kUnreached});
        break;
      case Step::alternative:
      case Step::otherwise:
        if (blocks.empty()) break;
        blocks.back().ended = joined(blocks.back().ended, walk.alive());
        walk.is_dead = true;
        walk.come_from(blocks.back().entry);
        if (step.step == Step::otherwise) blocks.back().entry = kUnreached;
        break;
      case Step::end_block:
        if (!blocks.empty()) end_block(walk);
        break;
      case Step::jump:
        if (merge(routine.jumped, value)) make_stale(walk.routine);
        break;
      case Step::go_to:
        pass_on(routine.gone_to.try_emplace(step.name, kUnreached).first->second, walk);
        break;
      case Step::leave:
        pass_on(routine.left, walk);
        break;
      case Step::stop:
        walk.is_dead = true;
        break;
      case Step::exit_loop:
        exit_loop(walk);
        break;
      case Step::label: {
        const auto gone = routine.gone_to.find(step.name);
        const int from = gone == routine.gone_to.end() ? kUnreached : gone->second;
        walk.come_from(joined(joined(walk.alive(), routine.jumped), from));
        break;
      }
      case Step::handler:
        pass_on(routine.left, walk);
        walk.come_from(routine.seen);
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

  void call(const ProgramFlow::Place& step, Walk& walk) {
    if (step.name.empty()) {
      merge(value_of_any_call_, walk.value);
      walk.value = joined(walk.value, end_of_any_);
      return;
    }
    const auto meant = named_.find(step.name);
    if (meant == named_.end()) return;  // it stands in another text
    int after = kUnreached;
    for (const size_t callee : meant->second) {
      enter(callee, walk.value);
      follow(callee);
      const Routine& called = routines_[callee];
      const bool hands_on = !called.changes && called.end != kUnreached;
      after = joined(after, hands_on ? walk.value : called.end);
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
  std::optional<ProgramFlow::Values> started_;  // 0 where no interrupt was started
  int seen_behind_starts_ = kUnreached;
  int value_of_any_call_ = kUnreached, end_of_any_ = kUnreached;
  int depth_ = 0;
  bool is_changed_ = false, is_spoiled_ = false;
};

int ProgramFlow::Values::behind(size_t place) const {
  const auto behind = std::ranges::upper_bound(changes_, place, {}, &std::pair<size_t, int>::first);
  return behind == changes_.begin() ? initial_ : std::prev(behind)->second;
}

int ProgramFlow::Values::at(size_t place) const {
  const int value = behind(place);
  return value == kUnreached ? kUncertain : value;
}

namespace {

template <class Places>
auto in_order(const Places& places) {
  std::vector<decltype(&places.front())> steps;
  for (const auto& place : places) steps.push_back(&place);
  std::ranges::stable_sort(steps, {}, [](const auto* step) { return step->at; });
  return steps;
}

}  // namespace

ProgramFlow::Values ProgramFlow::follow(const std::vector<Setting>& settings, int initial) const {
  if (!settings.empty()) return FlowOfValue(in_order(steps_), settings, initial).run();
  Values result;
  result.initial_ = initial;
  return result;
}

FlowOfVariables::FlowOfVariables(const ProgramFlow& flow)
    : flow_(flow), steps_(in_order(flow.steps_)) {
  using Step = ProgramFlow::Step;
  routines_.push_back({""});  // the text outside
  std::vector<int> open{0};
  for (const Place* step : steps_) {
    const int within = open.back();
    if (begins_routine(step->step)) {
      is_simple_ &= step->step != Step::interrupt;
      open.push_back(static_cast<int>(routines_.size()));
      if (!step->name.empty()) named_[step->name].push_back(open.back());
      routines_.push_back({step->name});
    } else if (step->step == Step::end_routine && open.size() > 1) {
      open.pop_back();
    }
    routine_behind_.push_back(open.back());
    if (step->step != Step::branch) joins_.push_back(step->at);
    if (step->step == Step::call) {
      is_simple_ &= !step->name.empty();
      calls_[step->name].push_back({step, within});
    } else {
      // The end of a routine belongs to it, as its begin does.
      routines_[std::max(within, open.back())].steps.push_back(step);
    }
  }
  FlowOfValue reached(steps_, {}, 0);
  reached.run();
  const std::vector<bool> ends = reached.ends();
  for (size_t r = 0; r < ends.size(); ++r)
    if (!ends[r]) endless_.push_back(static_cast<int>(r));
}

int FlowOfVariables::routine_at(size_t place) const {
  const auto at = [](const Place* step) { return step->at; };
  const auto behind = std::ranges::upper_bound(steps_, place, {}, at);
  return behind == steps_.begin() ? 0 : routine_behind_[behind - steps_.begin() - 1];
}

// Those that change the variable, those that never end, and all that call them.
std::vector<int> FlowOfVariables::routines_to_follow(
    const std::vector<ProgramFlow::Setting>& settings) const {
  std::vector<int> open = endless_, all;
  for (const ProgramFlow::Setting& setting : settings) open.push_back(routine_at(setting.at));
  std::set<int> known(open.begin(), open.end());
  const auto add = [&](int routine) {
    if (known.insert(routine).second) open.push_back(routine);
  };
  while (!open.empty()) {
    const std::string& name = routines_[open.back()].name;
    open.pop_back();
    if (const auto meant = named_.find(name); meant != named_.end())
      std::ranges::for_each(meant->second, add);
    if (const auto calls = calls_.find(name); !name.empty() && calls != calls_.end())
      for (const Call& call : calls->second) add(call.caller);
  }
  return {known.begin(), known.end()};
}

FlowOfVariables::Values FlowOfVariables::follow(std::vector<ProgramFlow::Setting> settings) const {
  Values result;
  result.flow_ = this;
  std::ranges::stable_sort(settings, {}, &ProgramFlow::Setting::at);
  result.settings_ = std::move(settings);
  return result;
}

// The value that the text gives the variable before a place, if only the text leads there.
std::optional<int> FlowOfVariables::Values::given_at(size_t place) const {
  const auto behind = std::ranges::upper_bound(settings_, place, {}, &ProgramFlow::Setting::at);
  if (!flow_->is_simple_ || behind == settings_.begin()) return std::nullopt;
  const ProgramFlow::Setting& setting = *std::prev(behind);
  const auto join = std::ranges::lower_bound(flow_->joins_, setting.at);
  if (join != flow_->joins_.end() && *join <= place) return std::nullopt;
  return setting.value;
}

void FlowOfVariables::Values::follow() const {
  is_known_ = true;
  if (!flow_->is_simple_ || settings_.empty()) {
    for (size_t r = 0; r < flow_->routines_.size(); ++r) followed_.push_back(static_cast<int>(r));
    values_ = flow_->flow_.follow(settings_, ProgramFlow::kUncertain);
    return;
  }
  followed_ = flow_->routines_to_follow(settings_);
  std::vector<const Place*> steps;
  std::set<std::string> names;
  for (const int r : followed_) {
    const Routine& routine = flow_->routines_[r];
    steps.insert(steps.end(), routine.steps.begin(), routine.steps.end());
    if (const auto calls = flow_->calls_.find(routine.name);
        calls != flow_->calls_.end() && names.insert(routine.name).second)
      for (const Call& call : calls->second) steps.push_back(call.step);
  }
  std::ranges::sort(steps, {}, [](const Place* step) { return std::pair(step->at, step); });
  values_ = FlowOfValue(steps, settings_, ProgramFlow::kUncertain).run();
}

bool FlowOfVariables::Values::is_followed(int routine) const {
  return std::ranges::binary_search(followed_, routine);
}

int FlowOfVariables::Values::at(size_t place) const {
  if (!flow_) return kUncertain;
  if (const auto given = given_at(place)) return *given;
  if (!is_known_) follow();
  const int routine = flow_->routine_at(place);
  const int value = is_followed(routine) ? values_.behind(place) : entry(routine);
  return value == kUnreached ? kUncertain : value;
}

// The values that all calls of a routine hand to it, also through routines that hand on their own.
// A routine that nothing calls begins with any value.
int FlowOfVariables::Values::entry(int routine) const {
  if (const auto known = entries_.find(routine); known != entries_.end()) return known->second;
  int all = kUnreached;
  std::set<int> seen{routine};
  std::vector<int> open{routine};
  while (!open.empty() && all != kUncertain) {
    const std::string& name = flow_->routines_[open.back()].name;
    open.pop_back();
    const auto calls = flow_->calls_.find(name);
    if (name.empty() || calls == flow_->calls_.end()) {
      all = kUncertain;
      break;
    }
    for (const auto& [step, caller] : calls->second)
      if (is_followed(caller))
        all = joined(all, values_.behind(step->at));
      else if (seen.insert(caller).second)
        open.push_back(caller);
  }
  return entries_[routine] = all;
}

}  // namespace armtrue
