#pragma once

#include <limits>
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
    interrupt,  ///< a routine that may run at any time
    end_routine,
    call,         ///< without a name: of any routine
    branch,       ///< begins a block that may be passed over
    alternative,  ///< begins another one in its place
    loop,
    end_block,  ///< of a branch or loop
    jump,       ///< perhaps: to a label, out of a loop or out of the routine
    go_to,      ///< always, to the label with this name
    exit_loop,  ///< always, out of the innermost loop
    leave,      ///< always, out of the routine
    label,
    handler  ///< of errors: comes from any place of its routine
  };
  void add(Step step, size_t at, const std::string& name = "") {
    steps_.push_back({at, step, name});
  }

  static constexpr int kUncertain = std::numeric_limits<int>::min();
  struct Setting {
    size_t at = 0;
    int value = 0;  ///< or kUncertain
  };

  /// The values of a setting by place.
  class Values {
   public:
    /// kUncertain where it has several, or where nothing in the text leads.
    int at(size_t place) const;

   private:
    friend class FlowOfValue;
    friend class ProgramFlow;
    int initial_ = 0;
    std::vector<std::pair<size_t, int>> changes_;  // from this place on: this value
  };
  /// `initial`: the value with which the program begins. A routine that nothing here calls begins
  /// with it, or with what another one of these leaves.
  Values follow(const std::vector<Setting>& settings, int initial) const;

 private:
  friend class FlowOfValue;
  struct Place {
    size_t at;
    Step step;
    std::string name;
  };
  std::vector<Place> steps_;
};

}  // namespace armtrue
