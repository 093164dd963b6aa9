#pragma once

#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace armtrue {

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
  }

  static constexpr int kUncertain = std::numeric_limits<int>::min();
  struct Setting {
    size_t at = 0;
    int value = 0;  ///< or kUncertain
    bool operator==(const Setting&) const = default;
  };

  /// The values of a setting by place.
  class Values {
   public:
    /// kUncertain where it has several, or where nothing in the text leads.
    int at(size_t place) const;

   private:
    friend class FlowOfValue;
    friend class FlowOfVariables;
    friend class ProgramFlow;
    int behind(size_t place) const;  // also that of no way that leads there

    int initial_ = 0;
    std::vector<std::pair<size_t, int>> changes_;  // from this place on: this value
  };
  /// `initial`: the value with which the program begins. A routine that nothing here calls begins
  /// with it, or with what another one of these leaves.
  Values follow(const std::vector<Setting>& settings, int initial) const;

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
  friend class FlowOfValue;
  friend class FlowOfVariables;
  friend class WaysOfFlow;
  struct Place {
    size_t at;
    Step step;
    std::string name;
  };
  std::vector<Place> steps_;
};

/// Follows many variables through one program, whose values at its beginning nobody knows. A
/// routine that changes a variable neither itself nor by its calls hands on the value with which it
/// is called, so only the others are followed: the cost of a variable grows with the routines that
/// change it and those that call them, not with the program. Mostly a variable is used where the
/// text continues from its assignment; then nothing is followed.
class FlowOfVariables {
 public:
  /// `flow`: all its steps; it must outlive this.
  explicit FlowOfVariables(const ProgramFlow& flow);

  /// The values of one variable by place.
  class Values {
   public:
    /// ProgramFlow::kUncertain where it has several, or where nothing in the text leads.
    int at(size_t place) const;

   private:
    friend class FlowOfVariables;
    std::optional<int> given_at(size_t place) const;
    void follow() const;
    bool is_followed(int routine) const;
    int entry(int routine) const;

    const FlowOfVariables* flow_ = nullptr;
    std::vector<ProgramFlow::Setting> settings_;  // in the order of the text
    // Once a place asked for them:
    mutable bool is_known_ = false;
    mutable std::vector<int> followed_;   // routines, in ascending order
    mutable ProgramFlow::Values values_;  // in them
    mutable std::map<int, int> entries_;  // of the others, as far as they were asked for
  };
  /// The values must not outlive this.
  Values follow(std::vector<ProgramFlow::Setting> settings) const;

 private:
  using Place = ProgramFlow::Place;
  struct Routine {
    std::string name;
    std::vector<const Place*> steps{};  // but for its calls
  };
  struct Call {
    const Place* step;
    int caller;
  };

  int routine_at(size_t place) const;
  std::vector<int> routines_to_follow(const std::vector<ProgramFlow::Setting>& settings) const;

  const ProgramFlow& flow_;
  std::vector<const Place*> steps_;  // in their order
  std::vector<int> routine_behind_;  // of each step
  std::vector<size_t> joins_;        // places to which a way may lead that is not the text before
  std::vector<Routine> routines_;
  std::map<std::string, std::vector<int>> named_;   // routines
  std::map<std::string, std::vector<Call>> calls_;  // by the name that they call
  std::vector<int> endless_;
  bool is_simple_ = true;  // no calls without a name, no interrupts
};

}  // namespace armtrue
