#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "programs/program_flow.h"

namespace armtrue {

/// The ways through the steps of a program. A node is the text behind a step, up to the next one;
/// node 0 is the text before all steps. More nodes are places where ways meet.
class FlowGraph {
 public:
  /// `steps`: in the order of the text. `is_behind_start`: whether an interrupt that steps start
  /// may run at a place; without it these interrupts never run.
  explicit FlowGraph(std::vector<ProgramFlow::Place> steps,
                     const std::function<bool(size_t)>& is_behind_start = nullptr);

  size_t size() const { return nodes_.size(); }
  /// Where the program begins: the node without a way to it that runs.
  int begin() const { return begin_; }
  /// Where another routine has ended and the first one begins: both are called by nothing here.
  int behind_first() const { return behind_first_; }
  /// The node whose text a place belongs to.
  int node_at(size_t place) const;
  /// Begin and end of the text of a node; equal if it has none.
  std::pair<size_t, size_t> text(int node) const;
  bool runs(int node) const { return nodes_[node].runs; }
  /// Whether anything runs the routine of a node.
  bool is_used(int node) const { return runs(routines_[nodes_[node].routine].begin); }
  /// Whether the ways to a node come from any place of the nodes before, not from their ends alone.
  bool is_from_within(int node) const { return nodes_[node].is_from_within; }
  /// The nodes from which the program comes to a node; what never runs comes from the text before.
  /// `changing`: routines whose calls count; the others hand on what each call has.
  std::vector<int> before(int node, const std::set<int>& changing) const;
  /// The routines with these nodes, and all that call them.
  std::set<int> with_callers(const std::vector<int>& nodes) const;
  bool has_interrupts() const { return !interrupts_.empty(); }
  /// Whether one of these routines is an interrupt that runs.
  bool has_interrupt(const std::set<int>& routines) const;

 private:
  using Step = ProgramFlow::Step;
  static constexpr int kNowhere = -1;
  struct Node {
    int routine = 0;
    int text_before = kNowhere;  // the node before it in the text of its routine
    std::vector<int> from{};
    std::vector<int> callees{};  // routines; then `from` is empty
    bool may_pass_over = false;  // the call
    bool is_from_within = false, runs = false;
  };
  struct Routine {
    Step step;
    int begin, end, jumped, within;  // nodes; the last one: any place of it
    bool is_called = false, is_started = false;
    std::set<int> callers{};
    std::map<std::string, int> labels{};
  };
  struct Block {
    int entry;  // kNowhere: no way passes over it
    int loop = kNowhere;
    std::vector<int> ends{};
  };
  // A routine that is gone through.
  struct Walk {
    int routine;
    int at;
    std::vector<Block> blocks{};
  };

  int add_node(int routine);
  int add_junction(std::vector<int> from);
  void add_way(int from, int to);
  void add_routine(Step step, int begin);
  void find_names();
  void take(const ProgramFlow::Place& step, int here, Walk& walk);
  void begin_routine(const ProgramFlow::Place& step, int here);
  void end_routine(int here);
  void call(const std::string& name, int here, Walk& walk);
  void exit_loop(Walk& walk, int here);
  void end_block(int here, Walk& walk);
  int label(int routine, const std::string& name);
  void begin_interrupts(const std::function<bool(size_t)>& is_behind_start);
  void begin_uncalled();
  void find_what_runs();
  void run_from(int node, const std::vector<std::vector<int>>& to);
  bool is_reached(const Node& node) const;

  const std::vector<ProgramFlow::Place> steps_;
  std::vector<Node> nodes_;
  std::vector<Routine> routines_;
  std::map<std::string, std::vector<int>> named_;  // routines; by "" all that have names
  std::set<std::string> started_;                  // names of interrupts
  std::set<int> interrupts_;
  std::vector<Walk> walks_;
  int begin_ = kNowhere, behind_first_ = kNowhere, next_routine_ = 1;
};

}  // namespace armtrue
