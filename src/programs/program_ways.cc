#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "programs/program_flow.h"

namespace armtrue {

// Goes once through the text; where ways meet there is a junction, so the graph grows with the
// text.
class WaysOfFlow {
 public:
  WaysOfFlow(const std::vector<ProgramFlow::Place>& steps, const std::vector<size_t>& places,
             size_t passed)
      : ways_(places.size() + 1),
        begin_(static_cast<int>(places.size())),
        first_passed_(static_cast<int>(places.size() - passed)) {
    for (const ProgramFlow::Place& step : steps) events_.push_back({step.at, &step});
    for (size_t i = 0; i < places.size(); ++i)
      events_.push_back({places[i], nullptr, static_cast<int>(i)});
    std::ranges::stable_sort(events_, {}, &Event::at);
    find_routines();
  }

  std::vector<std::vector<int>> run() {
    add_way(begin_, routines_[0].begin);
    walks_.push_back({0, routines_[0].begin});
    for (const Event& event : events_)
      if (event.step)
        take(*event.step);
      else
        pass(event.place);
    while (!walks_.empty()) end_routine();
    begin_routines();
    drop_what_never_runs();
    return std::move(ways_);
  }

 private:
  using Step = ProgramFlow::Step;
  static constexpr int kNowhere = -1;
  struct Event {
    size_t at;
    const ProgramFlow::Place* step;  // null: a place
    int place = kNowhere;
  };
  struct Routine {
    std::string name;
    Step step;
    int begin, end, jumped, seen;  // nodes
    bool is_called = false;
    bool has_places = false;  // itself, or what it calls
    std::vector<size_t> callers{};
    std::map<std::string, int> labels{};
  };
  struct Block {
    int entry;  // kNowhere: no way passes over it
    int loop = kNowhere;
    std::vector<int> ends{};
  };
  // A routine that is gone through.
  struct Walk {
    size_t routine;
    int at;
    std::vector<Block> blocks{};
  };

  static bool begins_routine(Step step) {
    return step == Step::routine || step == Step::local_routine || step == Step::interrupt;
  }

  void add_routine(const std::string& name, Step step) {
    routines_.push_back({name, step, add_node(), add_node(), add_node(), add_node()});
    add_way(routines_.back().begin, routines_.back().seen);
  }

  void find_routines() {
    add_routine("", Step::routine);  // the text outside
    std::vector<size_t> open{0};
    std::vector<std::pair<size_t, std::string>> calls;
    for (const Event& event : events_) {
      if (!event.step) {
        routines_[open.back()].has_places |= event.place < first_passed_;
      } else if (begins_routine(event.step->step)) {
        open.push_back(routines_.size());
        if (!event.step->name.empty() && event.step->step != Step::interrupt)
          named_[event.step->name].push_back(open.back());
        add_routine(event.step->name, event.step->step);
      } else if (event.step->step == Step::end_routine && open.size() > 1) {
        open.pop_back();
      } else if (event.step->step == Step::call) {
        calls.emplace_back(open.back(), event.step->name);
      }
    }
    for (const auto& [caller, name] : calls)
      for (const size_t callee : called(name)) {
        routines_[callee].is_called |= !name.empty();
        routines_[callee].callers.push_back(caller);
      }
    find_places_of_calls();
  }

  void find_places_of_calls() {
    std::vector<size_t> open;
    for (size_t i = 0; i < routines_.size(); ++i)
      if (routines_[i].has_places) open.push_back(i);
    while (!open.empty()) {
      const size_t routine = open.back();
      open.pop_back();
      for (const size_t caller : routines_[routine].callers)
        if (!std::exchange(routines_[caller].has_places, true)) open.push_back(caller);
    }
  }

  // Routines that a name calls; without a name, any.
  std::vector<size_t> called(const std::string& name) const {
    if (const auto found = named_.find(name); found != named_.end()) return found->second;
    std::vector<size_t> all;
    if (name.empty())
      for (const auto& [other, meant] : named_) all.insert(all.end(), meant.begin(), meant.end());
    return all;
  }

  int add_node() {
    ways_.emplace_back();
    return static_cast<int>(ways_.size()) - 1;
  }

  void add_way(int from, int to) {
    if (from != kNowhere) ways_[to].push_back(from);
  }

  int junction(std::vector<int> from) {
    std::ranges::sort(from);
    const auto twice = std::ranges::unique(from);
    from.erase(twice.begin(), twice.end());
    std::erase(from, kNowhere);
    if (from.size() < 2) return from.empty() ? kNowhere : from[0];
    const int node = add_node();
    ways_[node] = std::move(from);
    return node;
  }

  int label(Routine& routine, const std::string& name) {
    const auto [found, is_new] = routine.labels.try_emplace(name, kNowhere);
    if (is_new) found->second = add_node();
    return found->second;
  }

  void pass(int place) {
    Walk& walk = walks_.back();
    add_way(walk.at, place);
    if (walk.at == kNowhere) return;
    walk.at = place;
    add_way(place, routines_[walk.routine].seen);
  }

  void take(const ProgramFlow::Place& step) {
    Walk& walk = walks_.back();
    Routine& routine = routines_[walk.routine];
    std::vector<Block>& blocks = walk.blocks;
    switch (step.step) {
      case Step::routine:
      case Step::local_routine:
      case Step::interrupt:
        ++last_routine_;
        walks_.push_back({last_routine_, routines_[last_routine_].begin});
        break;
      case Step::start:
        break;
      case Step::end_routine:
        if (walks_.size() > 1) end_routine();
        break;
      case Step::call:
        call(step.name, walk);
        break;
      case Step::branch:
        blocks.push_back({walk.at});
        break;
      case Step::choice:
        blocks.push_back({std::exchange(walk.at, kNowhere)});
        break;
      case Step::loop:
      case Step::repeat: {
        const int turn = add_node();
        add_way(std::exchange(walk.at, turn), turn);
        blocks.push_back({step.step == Step::loop ? turn : kNowhere, turn});
        break;
      }
      case Step::alternative:
      case Step::otherwise:
        if (blocks.empty()) break;
        blocks.back().ends.push_back(std::exchange(walk.at, blocks.back().entry));
        if (step.step == Step::otherwise) blocks.back().entry = kNowhere;
        break;
      case Step::end_block:
        if (!blocks.empty()) end_block(walk);
        break;
      case Step::jump:
        add_way(walk.at, routine.jumped);
        break;
      case Step::go_to:
        add_way(std::exchange(walk.at, kNowhere), label(routine, step.name));
        break;
      case Step::leave:
        add_way(std::exchange(walk.at, kNowhere), routine.end);
        break;
      case Step::stop:
        walk.at = kNowhere;
        break;
      case Step::exit_loop:
        exit_loop(walk);
        break;
      case Step::label: {
        const int here = label(routine, step.name);
        add_way(std::exchange(walk.at, here), here);
        add_way(routine.jumped, here);
        break;
      }
      case Step::handler:
        add_way(std::exchange(walk.at, routine.seen), routine.end);
        break;
    }
  }

  void end_routine() {
    const Walk& walk = walks_.back();
    add_way(walk.at, routines_[walk.routine].end);
    add_way(routines_[walk.routine].jumped, routines_[walk.routine].end);
    walks_.pop_back();
  }

  static void exit_loop(Walk& walk) {
    const auto is_loop = [](const Block& block) { return block.loop != kNowhere; };
    const auto loop = std::ranges::find_if(walk.blocks.rbegin(), walk.blocks.rend(), is_loop);
    if (loop != walk.blocks.rend()) loop->ends.push_back(std::exchange(walk.at, kNowhere));
  }

  void end_block(Walk& walk) {
    Block block = std::move(walk.blocks.back());
    walk.blocks.pop_back();
    block.ends.push_back(block.entry);
    block.ends.push_back(walk.at);
    if (block.loop != kNowhere) {
      add_way(walk.at, block.loop);
      add_way(routines_[walk.routine].jumped, block.loop);
      block.ends.push_back(routines_[walk.routine].jumped);
    }
    walk.at = junction(std::move(block.ends));
  }

  // Behind a call of a routine without places stands what was there before it.
  void call(const std::string& name, Walk& walk) {
    std::vector<int> behind;
    for (const size_t callee : called(name)) {
      add_way(walk.at, routines_[callee].begin);
      behind.push_back(routines_[callee].has_places ? routines_[callee].end : walk.at);
    }
    if (behind.empty() || walk.at == kNowhere) return;  // it stands in another text
    if (name.empty()) behind.push_back(walk.at);
    walk.at = junction(std::move(behind));
  }

  // What nothing calls, and interrupts.
  void begin_routines() {
    std::vector<const Routine*> open;
    const int anywhere = add_node();
    for (const Routine& routine : routines_) {
      if (routine.step == Step::interrupt)
        add_way(anywhere, routine.begin);
      else
        add_way(routine.seen, anywhere);
      if (routine.step == Step::routine && !routine.is_called) open.push_back(&routine);
    }
    int before = open[0]->end, behind = kNowhere;  // ends of those before it, and behind it
    for (size_t i = 1; i < open.size(); ++i) {
      add_way(begin_, open[i]->begin);
      add_way(before, open[i]->begin);
      before = junction({before, open[i]->end});
    }
    for (size_t i = open.size(); i-- > 2;) {
      behind = junction({behind, i + 1 < open.size() ? open[i + 1]->end : kNowhere});
      add_way(behind, open[i]->begin);
    }
  }

  void drop_what_never_runs() {
    std::vector<std::vector<int>> to(ways_.size());
    for (size_t node = 0; node < ways_.size(); ++node)
      for (const int from : ways_[node]) to[from].push_back(static_cast<int>(node));
    std::vector<char> runs(ways_.size(), false);
    const auto run_from = [&](int begin) {
      runs[begin] = true;
      for (std::vector<int> open{begin}; !open.empty();) {
        const int node = open.back();
        open.pop_back();
        for (const int next : to[node])
          if (!std::exchange(runs[next], true)) open.push_back(next);
      }
    };
    run_from(begin_);
    // Called by itself alone, or by what never runs: other programs may call it.
    for (const Routine& routine : routines_)
      if (routine.step == Step::routine && !runs[routine.begin]) {
        add_way(begin_, routine.begin);
        run_from(routine.begin);
      }
    for (std::vector<int>& from : ways_) std::erase_if(from, [&](int node) { return !runs[node]; });
  }

  std::vector<std::vector<int>> ways_;
  const int begin_, first_passed_;
  std::vector<Event> events_;
  std::vector<Routine> routines_;
  size_t last_routine_ = 0;
  std::map<std::string, std::vector<size_t>> named_;
  std::vector<Walk> walks_;
};

std::vector<std::vector<int>> ProgramFlow::ways(const std::vector<size_t>& places,
                                                const std::vector<size_t>& passed) const {
  std::vector<size_t> all = places;
  all.insert(all.end(), passed.begin(), passed.end());
  return WaysOfFlow(steps_, all, passed.size()).run();
}

std::set<std::string> ProgramFlow::routine_names() const {
  std::set<std::string> names;
  for (const Place& step : steps_)
    if (step.step == Step::routine || step.step == Step::local_routine) names.insert(step.name);
  return names;
}

std::vector<std::pair<size_t, std::string>> ProgramFlow::calls_of_others() const {
  const std::set<std::string> own = routine_names();
  std::vector<std::pair<size_t, std::string>> calls;
  for (const Place& step : steps_)
    if (step.step == Step::call && !step.name.empty() && !own.contains(step.name))
      calls.emplace_back(step.at, step.name);
  return calls;
}

}  // namespace armtrue
