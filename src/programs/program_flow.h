#pragma once

#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace armtrue {

class FlowGraph;

/// The order in which the statements of a program run, as far as its text says: routines, calls,
/// branches, loops, jumps. It shows where a setting of the program (a tool, a frame) holds for
/// certain.
class ProgramFlow {
 public:
  enum class Step {
    routine,
    local_routine,  ///< that only calls of this text begin
    interrupt,  ///< a routine that may run at any time; if steps start it: from the first of them
    start,      ///< of the interrupt with this name
    end_routine,
    call,         ///< without a name: of any routine
    branch,       ///< begins a block that may be passed over
    choice,       ///< begins a block of alternatives, before the first of them
    alternative,  ///< begins another one in its place
    otherwise,    ///< begins the last one: no way passes over all of them
    loop,
    repeat,     ///< a loop whose turns begin at least once
    end_block,  ///< of a branch or loop
    jump,       ///< perhaps: to a label, out of a loop or out of the routine
    go_to,      ///< always, to the label with this name
    exit_loop,  ///< always, out of the innermost loop
    leave,      ///< always, out of the routine
    stop,       ///< always: the program ends
    label,
    handler  ///< of errors: comes from any place of its routine, whose other text ends before it
  };
  void add(Step step, size_t at, const std::string& name = "") {
    steps_.push_back({at, step, name});
    graph_.reset();
  }

  static constexpr int kUncertain = std::numeric_limits<int>::min();
  struct Setting {
    size_t at = 0;
    int value = 0;  ///< or kUncertain
    bool operator==(const Setting&) const = default;
  };

  /// The values of a setting by place. Only what is asked for is followed, against the ways, up to
  /// the settings; mostly the text continues from one of them, and nothing is followed.
  class Values {
   public:
    /// kUncertain where it has several, or where nothing in the text leads.
    int at(size_t place) const;

   private:
    friend class ProgramFlow;
    std::span<const Setting> settings_in(int node) const;
    void find_changing() const;
    int join_of_ways(int node) const;
    void follow(int node) const;

    std::shared_ptr<const FlowGraph> graph_;
    std::vector<Setting> settings_;  // in the order of the text
    int initial_ = kUncertain;
    // Once a place asked for them:
    mutable std::optional<std::set<int>> changing_;  // routines, themselves or by their calls
    mutable std::map<int, int> known_;               // nodes: the value where each begins
  };
  /// `initial`: the value with which the program begins. A routine that nothing here calls begins
  /// with it, or with what another one of these leaves.
  Values follow(std::vector<Setting> settings, int initial = kUncertain) const;

  /// Whether a way leads to a place. A step that stands there has not run yet.
  bool leads_to(size_t place) const;

  /// The ways between places, as a graph: of each node those from which the program comes to it.
  /// The first nodes are the places, then comes the begin of the program; the others are junctions.
  /// A place to which nothing leads has none. A routine that nothing here calls begins with the
  /// program; all of these but the first one also where another one ends.
  /// `passed`: more places, behind the first ones, at which nothing happens.
  std::vector<std::vector<int>> ways(const std::vector<size_t>& places,
                                     const std::vector<size_t>& passed = {}) const;

  /// The names of its routines, and its calls of routines with other names.
  std::set<std::string> routine_names() const;
  std::vector<std::pair<size_t, std::string>> calls_of_others() const;

 private:
  friend class FlowGraph;
  struct Place {
    size_t at;
    Step step;
    std::string name;
  };
  std::shared_ptr<const FlowGraph> graph() const;

  std::vector<Place> steps_;
  mutable std::shared_ptr<const FlowGraph> graph_;  // of these steps, once it was asked for
};

}  // namespace armtrue
