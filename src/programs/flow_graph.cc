#include "programs/flow_graph.h"

#include <algorithm>

namespace armtrue {
namespace {

bool begins_routine(ProgramFlow::Step step) {
  return step == ProgramFlow::Step::routine || step == ProgramFlow::Step::local_routine ||
         step == ProgramFlow::Step::interrupt;
}

}  // namespace

// Goes once through the text; where ways meet there is a junction, so the graph grows with the
// text.
FlowGraph::FlowGraph(std::vector<ProgramFlow::Place> steps,
                     const std::function<bool(size_t)>& is_behind_start)
    : steps_(std::move(steps)), nodes_(steps_.size() + 1) {
  begin_ = add_node(0);
  add_routine(Step::routine, 0);  // the text outside
  add_way(begin_, 0);
  find_names();
  walks_.push_back({0, 0});
  for (size_t i = 0; i < steps_.size(); ++i) {
    const int here = static_cast<int>(i) + 1;
    nodes_[here].routine = walks_.back().routine;
    nodes_[here].text_before = walks_.back().at;
    take(steps_[i], here, walks_.back());
    walks_.back().at = here;
  }
  while (walks_.size() > 1) end_routine(kNowhere);
  add_way(walks_[0].at, routines_[0].end);
  add_way(routines_[0].jumped, routines_[0].end);
  for (int node = 0; node <= static_cast<int>(steps_.size()); ++node)
    add_way(node, routines_[nodes_[node].routine].within);
  begin_interrupts(is_behind_start);
  begin_uncalled();
  find_what_runs();
}

int FlowGraph::add_node(int routine) {
  nodes_.push_back({routine});
  return static_cast<int>(nodes_.size()) - 1;
}

int FlowGraph::add_junction(std::vector<int> from) {
  const int node = add_node(0);
  nodes_[node].from = std::move(from);
  return node;
}

void FlowGraph::add_way(int from, int to) {
  if (from != kNowhere) nodes_[to].from.push_back(from);
}

void FlowGraph::add_routine(Step step, int begin) {
  const int index = static_cast<int>(routines_.size());
  routines_.push_back({step, begin, add_node(index), add_node(index), add_node(index)});
  nodes_[routines_.back().within].is_from_within = true;
  if (step == Step::interrupt) interrupts_.insert(index);
}

void FlowGraph::find_names() {
  for (size_t i = 0; i < steps_.size(); ++i) {
    const auto& [at, step, name] = steps_[i];
    if (step == Step::start) started_.insert(name);
    if (!begins_routine(step)) continue;
    add_routine(step, static_cast<int>(i) + 1);
    if (step == Step::interrupt || name.empty()) continue;
    named_[name].push_back(static_cast<int>(routines_.size()) - 1);
    named_[""].push_back(static_cast<int>(routines_.size()) - 1);
  }
}

// A routine within another one interrupts the text of the other.
void FlowGraph::begin_routine(const ProgramFlow::Place& step, int here) {
  routines_[next_routine_].is_started =
      step.step == Step::interrupt && started_.contains(step.name);
  nodes_[here].routine = next_routine_;
  nodes_[here].text_before = kNowhere;
  walks_.push_back({next_routine_++, here});
}

void FlowGraph::end_routine(int here) {
  const Walk walk = std::move(walks_.back());
  walks_.pop_back();
  add_way(walk.at, routines_[walk.routine].end);
  add_way(routines_[walk.routine].jumped, routines_[walk.routine].end);
  if (here == kNowhere) return;
  nodes_[here].routine = walks_.back().routine;
  nodes_[here].text_before = walks_.back().at;
  add_way(walks_.back().at, here);
}

void FlowGraph::take(const ProgramFlow::Place& step, int here, Walk& walk) {
  const Routine& routine = routines_[walk.routine];
  std::vector<Block>& blocks = walk.blocks;
  const auto go_on = [&] { add_way(walk.at, here); };
  switch (step.step) {
    case Step::routine:
    case Step::local_routine:
    case Step::interrupt:
      begin_routine(step, here);
      break;
    case Step::end_routine:
      walks_.size() > 1 ? end_routine(here) : go_on();
      break;
    case Step::start:
      go_on();
      break;
    case Step::call:
      call(step.name, here, walk);
      break;
    case Step::branch:
      blocks.push_back({walk.at});
      go_on();
      break;
    case Step::choice:
      blocks.push_back({walk.at});
      break;
    case Step::loop:
    case Step::repeat: {
      const int turn = add_node(walk.routine);
      nodes_[turn].text_before = walk.at;
      add_way(walk.at, turn);
      add_way(turn, here);
      blocks.push_back({step.step == Step::loop ? turn : kNowhere, turn});
      break;
    }
    case Step::alternative:
    case Step::otherwise:
      if (blocks.empty()) return go_on();
      blocks.back().ends.push_back(walk.at);
      add_way(blocks.back().entry, here);
      if (step.step == Step::otherwise) blocks.back().entry = kNowhere;
      break;
    case Step::end_block:
      blocks.empty() ? go_on() : end_block(here, walk);
      break;
    case Step::jump:
      add_way(walk.at, routine.jumped);
      go_on();
      break;
    case Step::go_to:
      add_way(walk.at, label(walk.routine, step.name));
      break;
    case Step::leave:
      add_way(walk.at, routine.end);
      break;
    case Step::stop:
      break;
    case Step::exit_loop:
      exit_loop(walk, here);
      break;
    case Step::label:
      go_on();
      add_way(label(walk.routine, step.name), here);
      add_way(routine.jumped, here);
      break;
    case Step::handler:
      add_way(walk.at, routine.end);
      add_way(routine.within, here);
      break;
  }
}

int FlowGraph::label(int routine, const std::string& name) {
  const auto [found, is_new] = routines_[routine].labels.try_emplace(name, kNowhere);
  if (is_new) found->second = add_node(routine);
  return found->second;
}

void FlowGraph::exit_loop(Walk& walk, int here) {
  const auto is_loop = [](const Block& block) { return block.loop != kNowhere; };
  const auto loop = std::ranges::find_if(walk.blocks.rbegin(), walk.blocks.rend(), is_loop);
  if (loop != walk.blocks.rend())
    loop->ends.push_back(walk.at);
  else
    add_way(walk.at, here);
}

void FlowGraph::end_block(int here, Walk& walk) {
  const Block block = std::move(walk.blocks.back());
  walk.blocks.pop_back();
  for (const int end : block.ends) add_way(end, here);
  add_way(block.entry, here);
  add_way(walk.at, here);
  if (block.loop == kNowhere) return;
  add_way(walk.at, block.loop);
  add_way(routines_[walk.routine].jumped, block.loop);
  add_way(routines_[walk.routine].jumped, here);
}

void FlowGraph::call(const std::string& name, int here, Walk& walk) {
  const auto found = named_.find(name);
  if (found == named_.end()) return add_way(walk.at, here);  // it stands in another text
  nodes_[here].callees = found->second;
  nodes_[here].may_pass_over = name.empty();
  for (const int callee : found->second) {
    add_way(walk.at, routines_[callee].begin);
    routines_[callee].is_called |= !name.empty() && callee != walk.routine;
    routines_[callee].callers.insert(walk.routine);
  }
}

void FlowGraph::begin_interrupts(const std::function<bool(size_t)>& is_behind_start) {
  if (interrupts_.empty()) return;
  const int anywhere = add_junction({}), behind_start = add_junction({});
  nodes_[behind_start].is_from_within = true;
  for (const Routine& routine : routines_)
    if (routine.step == Step::interrupt)
      add_way(routine.is_started ? behind_start : anywhere, routine.begin);
    else
      add_way(routine.within, anywhere);
  if (!is_behind_start) return;
  for (int node = 0; node <= static_cast<int>(steps_.size()); ++node)
    if (routines_[nodes_[node].routine].step != Step::interrupt &&
        is_behind_start(text(node).first))
      add_way(node, behind_start);
}

// What nothing calls begins with the program, or where another one of these ends.
void FlowGraph::begin_uncalled() {
  std::vector<int> open;
  for (size_t i = 0; i < routines_.size(); ++i)
    if (routines_[i].step == Step::routine && !routines_[i].is_called)
      open.push_back(static_cast<int>(i));
  int before = routines_[0].end, behind = kNowhere;  // ends of those before it, and behind it
  for (size_t i = 1; i < open.size(); ++i) {
    const Routine& routine = routines_[open[i]];
    add_way(begin_, routine.begin);
    add_way(before, routine.begin);
    before = add_junction({before, routine.end});
  }
  for (size_t i = open.size(); i-- > 2;) {
    const int end = routines_[open[i]].end;
    behind = add_junction(behind == kNowhere ? std::vector{end} : std::vector{end, behind});
    add_way(behind, routines_[open[i - 1]].begin);
  }
  behind_first_ = behind;
}

bool FlowGraph::is_reached(const Node& node) const {
  const auto runs = [&](int other) { return nodes_[other].runs; };
  if (node.callees.empty()) return std::ranges::any_of(node.from, runs);
  return runs(node.text_before) &&
         (node.may_pass_over || std::ranges::any_of(node.callees, [&](int callee) {
            return runs(routines_[callee].end);
          }));
}

void FlowGraph::run_from(int begin, const std::vector<std::vector<int>>& to) {
  nodes_[begin].runs = true;
  for (std::vector<int> open{begin}; !open.empty();) {
    const int node = open.back();
    open.pop_back();
    for (const int next : to[node])
      if (!nodes_[next].runs && is_reached(nodes_[next])) {
        nodes_[next].runs = true;
        open.push_back(next);
      }
  }
}

// Ways from what never runs are dropped.
void FlowGraph::find_what_runs() {
  std::vector<std::vector<int>> to(nodes_.size());
  for (int node = 0; node < static_cast<int>(nodes_.size()); ++node) {
    for (const int from : nodes_[node].from) to[from].push_back(node);
    for (const int callee : nodes_[node].callees) to[routines_[callee].end].push_back(node);
    if (!nodes_[node].callees.empty()) to[nodes_[node].text_before].push_back(node);
  }
  run_from(begin_, to);
  // Called by itself alone, or by what never runs: other programs may call it. Callers come first.
  std::vector<std::pair<size_t, int>> others;
  for (const Routine& routine : routines_)
    if (routine.step == Step::routine && !nodes_[routine.begin].runs)
      others.emplace_back(with_callers({routine.begin}).size(), routine.begin);
  std::ranges::stable_sort(others, {}, &std::pair<size_t, int>::first);
  for (const auto& [callers, begin] : others)
    if (!nodes_[begin].runs) {
      add_way(begin_, begin);
      run_from(begin, to);
    }
  for (Node& node : nodes_) {
    if (node.runs)
      std::erase_if(node.from, [&](int from) { return !nodes_[from].runs; });
    else if (node.text_before != kNowhere)
      node.from = {node.text_before};
    std::ranges::sort(node.from);
    node.from.erase(std::ranges::unique(node.from).begin(), node.from.end());
  }
}

int FlowGraph::node_at(size_t place) const {
  const auto behind = std::ranges::upper_bound(steps_, place, {}, &ProgramFlow::Place::at);
  return static_cast<int>(behind - steps_.begin());
}

std::pair<size_t, size_t> FlowGraph::text(int node) const {
  const size_t index = static_cast<size_t>(node);
  if (index > steps_.size()) return {0, 0};
  return {index == 0 ? 0 : steps_[index - 1].at,
          index == steps_.size() ? std::numeric_limits<size_t>::max() : steps_[index].at};
}

std::vector<int> FlowGraph::before(int node, const std::set<int>& changing) const {
  const Node& here = nodes_[node];
  if (here.callees.empty()) return here.from;
  std::vector<int> from;
  for (const int callee : here.callees)
    if (nodes_[routines_[callee].end].runs)
      from.push_back(changing.contains(callee) ? routines_[callee].end : here.text_before);
  if (here.may_pass_over) from.push_back(here.text_before);
  return from;
}

std::set<int> FlowGraph::with_callers(const std::vector<int>& nodes) const {
  std::set<int> all;
  std::vector<int> open;
  const auto add = [&](int routine) {
    if (all.insert(routine).second) open.push_back(routine);
  };
  for (const int node : nodes) add(nodes_[node].routine);
  while (!open.empty()) {
    const std::set<int>& callers = routines_[open.back()].callers;
    open.pop_back();
    std::ranges::for_each(callers, add);
  }
  return all;
}

bool FlowGraph::has_interrupt(const std::set<int>& routines) const {
  return std::ranges::any_of(routines, [&](int routine) {
    return interrupts_.contains(routine) && runs(routines_[routine].begin);
  });
}

}  // namespace armtrue
