#include "programs/program_flow.h"

#include <algorithm>

#include "programs/flow_graph.h"

namespace armtrue {
namespace {

constexpr int kUncertain = ProgramFlow::kUncertain;
constexpr int kUnreached = kUncertain + 1;

int joined(int a, int b) {
  if (a == kUnreached || a == b) return b;
  return b == kUnreached ? a : kUncertain;
}

void sort_once(std::vector<int>& nodes) {
  std::ranges::sort(nodes);
  nodes.erase(std::ranges::unique(nodes).begin(), nodes.end());
}

// `ways`: of each node those before it. Nodes from `first` on are junctions: those with one way to
// them give way to the node before, and those to which nothing refers go.
std::vector<std::vector<int>> without_plain_junctions(std::vector<std::vector<int>> ways,
                                                      int first) {
  const auto before = [&](int node) {
    while (node >= first && ways[node].size() == 1) node = ways[node][0];
    return node;
  };
  for (std::vector<int>& from : ways) {
    for (int& node : from) node = before(node);
    sort_once(from);
  }
  std::vector<std::vector<int>> result(ways.begin(), ways.begin() + first);
  std::map<int, int> kept;  // junctions, and what they are in the result
  for (size_t i = 0; i < result.size(); ++i) {
    std::vector<int> from = std::move(result[i]);
    for (int& node : from) {
      if (node < first) continue;
      const auto [found, is_new] = kept.try_emplace(node, static_cast<int>(result.size()));
      if (is_new) result.push_back(ways[node]);
      node = found->second;
    }
    result[i] = std::move(from);
  }
  return result;
}

}  // namespace

std::shared_ptr<const FlowGraph> ProgramFlow::graph() const {
  if (graph_) return graph_;
  std::vector<Place> steps = steps_;
  std::ranges::stable_sort(steps, {}, &Place::at);
  graph_ = std::make_shared<FlowGraph>(steps);
  Values started;
  started.graph_ = graph_;
  started.initial_ = 0;
  for (const Place& step : steps)
    if (step.step == Step::start) started.settings_.push_back({step.at, 1});
  if (!started.settings_.empty())
    graph_ = std::make_shared<FlowGraph>(std::move(steps), [&](size_t place) {
      return started.graph_->runs(started.graph_->node_at(place)) && started.at(place) != 0;
    });
  return graph_;
}

ProgramFlow::Values ProgramFlow::follow(std::vector<Setting> settings, int initial) const {
  Values result;
  result.graph_ = graph();
  result.initial_ = initial;
  std::ranges::stable_sort(settings, {}, &Setting::at);
  result.settings_ = std::move(settings);
  return result;
}

// What an interrupt sets, itself or by a call, holds anywhere.
int ProgramFlow::Values::at(size_t place) const {
  if (settings_.empty()) return initial_;
  if (graph_->has_interrupts()) {
    find_changing();
    if (graph_->has_interrupt(*changing_)) return kUncertain;
  }
  const int node = graph_->node_at(place);
  if (!graph_->is_used(node)) return kUncertain;
  const auto behind = std::ranges::upper_bound(settings_, place, {}, &Setting::at);
  if (behind != settings_.begin() && std::prev(behind)->at >= graph_->text(node).first)
    return std::prev(behind)->value;
  if (!known_.contains(node)) follow(node);
  const int value = known_.at(node);
  return value == kUnreached ? kUncertain : value;
}

std::span<const ProgramFlow::Setting> ProgramFlow::Values::settings_in(int node) const {
  const auto [begin, end] = graph_->text(node);
  return {std::ranges::lower_bound(settings_, begin, {}, &Setting::at),
          std::ranges::lower_bound(settings_, end, {}, &Setting::at)};
}

void ProgramFlow::Values::find_changing() const {
  if (changing_) return;
  std::vector<int> nodes;
  for (const Setting& setting : settings_) nodes.push_back(graph_->node_at(setting.at));
  changing_ = graph_->with_callers(nodes);
}

// From the values where the nodes before it begin.
int ProgramFlow::Values::join_of_ways(int node) const {
  if (node == graph_->begin()) return initial_;
  const bool is_from_within = graph_->is_from_within(node);
  int all = kUnreached;
  for (const int from : graph_->before(node, *changing_)) {
    const auto settings = settings_in(from);
    if (is_from_within)
      for (const Setting& setting : settings) all = joined(all, setting.value);
    if (is_from_within || settings.empty())
      all = joined(all, known_.at(from));
    else
      all = joined(all, settings.back().value);
  }
  return all;
}

// Finds the value where a node begins, and those on which it depends. A value only changes from
// unreached to one value to uncertain, so each is found a few times, in any order.
void ProgramFlow::Values::follow(int node) const {
  find_changing();
  std::map<int, std::vector<int>> dependent;
  std::vector<int> stale{node};
  known_.emplace(node, kUnreached);
  for (size_t i = 0; i < stale.size(); ++i)
    for (const int from : graph_->before(stale[i], *changing_)) {
      if (!graph_->is_from_within(stale[i]) && !settings_in(from).empty()) continue;
      dependent[from].push_back(stale[i]);
      if (known_.emplace(from, kUnreached).second) stale.push_back(from);
    }
  while (!stale.empty()) {
    const int here = stale.back();
    stale.pop_back();
    const int value = join_of_ways(here);
    if (std::exchange(known_.at(here), value) == value) continue;
    const std::vector<int>& next = dependent[here];
    stale.insert(stale.end(), next.begin(), next.end());
  }
}

bool ProgramFlow::leads_to(size_t place) const {
  return graph()->runs(place == 0 ? 0 : graph()->node_at(place - 1));
}

// Nodes of the graph become junctions, and between those the places stand; then junctions with one
// way to them are passed over.
std::vector<std::vector<int>> ProgramFlow::ways(const std::vector<size_t>& places,
                                                const std::vector<size_t>& passed) const {
  const std::shared_ptr<const FlowGraph> graph = this->graph();
  const int count = static_cast<int>(places.size() + passed.size());
  std::vector<std::vector<int>> within(graph->size());  // places, in the order of the text
  std::vector<size_t> all = places;
  all.insert(all.end(), passed.begin(), passed.end());
  std::vector<int> nodes, order(all.size());
  for (size_t i = 0; i < all.size(); ++i) order[i] = static_cast<int>(i);
  std::ranges::stable_sort(order, {}, [&](int place) { return all[place]; });
  for (const int place : order) within[graph->node_at(all[place])].push_back(place);
  for (const size_t place : places) nodes.push_back(graph->node_at(place));
  const std::set<int> changing = graph->with_callers(nodes);

  const auto begin_of = [&](int node) { return node == graph->begin() ? count : count + 1 + node; };
  std::vector<std::vector<int>> ways(begin_of(static_cast<int>(graph->size())));
  for (int node = 0; node < static_cast<int>(graph->size()); ++node) {
    if (!graph->runs(node)) continue;
    std::vector<int>& here = ways[begin_of(node)];
    for (const int from : graph->before(node, changing)) {
      if (from == graph->behind_first()) continue;
      const std::vector<int>& between = within[from];
      here.push_back(between.empty() ? begin_of(from) : between.back());
      if (!graph->is_from_within(node) || between.empty()) continue;
      here.push_back(begin_of(from));
      here.insert(here.end(), between.begin(), between.end());
    }
    int last = begin_of(node);
    for (const int place : within[node]) ways[place] = {std::exchange(last, place)};
  }
  return without_plain_junctions(std::move(ways), count + 1);
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
