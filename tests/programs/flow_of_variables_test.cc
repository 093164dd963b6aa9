#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>
#include <tuple>

#include "programs/program_flow.h"

// FlowOfVariables against random programs that are run many times, each time by other ways, and
// against ProgramFlow, which follows every routine for every variable.

namespace armtrue {
namespace {

using Step = ProgramFlow::Step;
constexpr int kUncertain = ProgramFlow::kUncertain, kOfLastRun = -1;

// What a statement does; `value` 0: nothing.
struct Statement {
  Step step = Step::label;
  int callee = -1, value = 0;
};

struct Program {
  ProgramFlow flow;
  std::vector<ProgramFlow::Setting> settings;
  std::vector<Statement> statements;  // by place
  std::vector<size_t> begins;         // of the routines
};

std::string name_of(int routine) { return "SUB" + std::to_string(routine); }

class Writer {
 public:
  explicit Writer(unsigned seed) : random_(seed) {}

  Program write() {
    constexpr int kRoutines = 6;
    program_.statements.emplace_back();
    for (int r = 0; r < kRoutines; ++r) {
      program_.begins.push_back(program_.statements.size());
      add({Step::routine}, name_of(r));
      block(3, r + 1, kRoutines, false);
      add({Step::end_routine});
    }
    return std::move(program_);
  }

 private:
  int below(int count) { return std::uniform_int_distribution(0, count - 1)(random_); }

  void add(const Statement& statement, const std::string& name = "") {
    program_.flow.add(statement.step, program_.statements.size(), name);
    program_.statements.push_back(statement);
  }

  void block(int depth, int first, int routines, bool in_loop) {
    const int count = 1 + below(4);
    for (int k = 0; k < count; ++k) {
      const int kind = below(12);
      if (kind < 2) {
        const int value = 1 + below(2);
        program_.settings.push_back({program_.statements.size(), value});
        program_.statements.push_back({Step::label, -1, value});
      } else if (kind < 7 && first < routines) {
        const int callee = first + below(routines - first);
        add({Step::call, callee}, name_of(callee));
      } else if (kind < 9 && depth > 0) {
        add({Step::branch});
        block(depth - 1, first, routines, in_loop);
        if (below(2) == 0) {
          add({Step::alternative});
          block(depth - 1, first, routines, in_loop);
        }
        add({Step::end_block});
      } else if (kind == 9 && depth > 0) {
        add({Step::loop});
        block(depth - 1, first, routines, true);
        add({Step::end_block});
      } else if (kind == 10 && in_loop) {
        add({Step::exit_loop});
      } else if (kind == 11 && below(4) == 0) {
        add({Step::leave});
      } else {
        program_.statements.emplace_back();
      }
    }
  }

  std::mt19937 random_;
  Program program_;
};

// Runs a program by random ways; notes the values that the variable has behind each place.
class Runner {
 public:
  Runner(const Program& program, unsigned seed) : program_(program), random_(seed) {}

  std::map<size_t, std::set<int>> run(int times) {
    for (int time = 0; time < times; ++time) {
      value_ = kOfLastRun;
      left_ = 2000;
      routine(0);
    }
    return seen_;
  }

 private:
  enum class Way { on, out_of_loop, out };

  bool toss() { return std::uniform_int_distribution(0, 1)(random_) == 1; }

  void routine(int index) {
    size_t place = program_.begins[index];
    seen_[place].insert(value_);
    ++place;
    block(place);
  }

  // The end of the block that begins before `place`, or its next alternative.
  size_t behind_block(size_t place, bool stops_at_alternative) const {
    for (int depth = 0;; ++place) {
      const Step step = program_.statements[place].step;
      if (step == Step::branch || step == Step::loop) ++depth;
      if (depth == 0 && step == Step::alternative && stops_at_alternative) return place;
      if (step == Step::end_block && depth-- == 0) return place;
    }
  }

  // Runs on from `place` to the end of the block; leaves `place` there.
  Way block(size_t& place) {
    for (;; ++place) {
      if (--left_ < 0) return Way::out;
      const Statement& now = program_.statements[place];
      if (now.step == Step::end_block || now.step == Step::alternative) return Way::on;
      if (now.step == Step::end_routine) return Way::on;
      if (now.value != 0) value_ = now.value;
      Way way = Way::on;
      if (now.step == Step::leave) way = Way::out;
      if (now.step == Step::exit_loop) way = Way::out_of_loop;
      if (now.step == Step::call) routine(now.callee);
      if (left_ < 0) return Way::out;
      if (way == Way::on) seen_[place].insert(value_);
      const size_t begin = place;
      if (now.step == Step::branch) {
        size_t inner = begin;
        if (!toss()) inner = behind_block(begin + 1, true);
        if (program_.statements[inner].step != Step::end_block) {
          seen_[inner].insert(value_);
          way = block(++inner);
        }
        place = behind_block(begin + 1, false);
      } else if (now.step == Step::loop) {
        while (way == Way::on && toss()) {
          size_t inner = begin + 1;
          way = block(inner);
        }
        if (way == Way::out_of_loop) way = Way::on;
        place = behind_block(begin + 1, false);
      }
      if (way != Way::on) return way;
      seen_[place].insert(value_);
    }
  }

  const Program& program_;
  std::mt19937 random_;
  int value_ = 0, left_ = 0;
  std::map<size_t, std::set<int>> seen_;
};

TEST(FlowOfVariables, KnowsWhatAllWaysHaveAsTheFlowOfAllRoutinesDoes) {
  int certain = 0, certain_in_all = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    const Program program = Writer(seed).write();
    const FlowOfVariables flow(program.flow);
    const FlowOfVariables::Values values = flow.follow(program.settings);
    const ProgramFlow::Values of_all = program.flow.follow(program.settings, kUncertain);
    for (const auto& [place, seen] : Runner(program, seed).run(200)) {
      const int value = values.at(place);
      if (of_all.at(place) != kUncertain) {
        ++certain_in_all;
        EXPECT_EQ(value, of_all.at(place)) << "program " << seed << ", place " << place;
      }
      if (value == kUncertain) continue;
      ++certain;
      EXPECT_EQ(seen, std::set<int>{value}) << "program " << seed << ", place " << place;
    }
  }
  EXPECT_GT(certain_in_all, 500);
  EXPECT_EQ(certain, certain_in_all);
}

// A calls B and B calls A; both have what either is called with.
TEST(FlowOfVariables, RoutinesThatCallEachOtherHandOnTheSame) {
  ProgramFlow flow;
  const auto call = [&](size_t at, const char* name) { flow.add(Step::call, at, name); };
  flow.add(Step::routine, 1, "MAIN");
  call(3, "A");
  call(5, "B");
  flow.add(Step::end_routine, 6);
  for (const auto& [at, own, other] : {std::tuple(10, "A", "B"), {20, "B", "A"}}) {
    flow.add(Step::routine, at, own);
    flow.add(Step::branch, at + 1);
    call(at + 2, other);
    flow.add(Step::end_block, at + 3);
    flow.add(Step::end_routine, at + 5);
  }
  const FlowOfVariables variables(flow);
  const FlowOfVariables::Values two = variables.follow({{2, 1}, {4, 2}});
  EXPECT_EQ(two.at(14), kUncertain);
  EXPECT_EQ(two.at(24), kUncertain);
  EXPECT_EQ(two.at(3), 1);  // A changes nothing
  const FlowOfVariables::Values one = variables.follow({{2, 1}, {4, 1}});
  EXPECT_EQ(one.at(14), 1);
  EXPECT_EQ(one.at(24), 1);
}

TEST(FlowOfVariables, BehindARoutineThatNeverEndsNothingIsKnown) {
  for (const bool ends : {true, false}) {
    ProgramFlow flow;
    flow.add(Step::routine, 1, "MAIN");
    flow.add(Step::call, 3, "WAIT");
    flow.add(Step::end_routine, 5);
    flow.add(Step::routine, 10, "WAIT");
    flow.add(Step::label, 11, "AGAIN");
    if (!ends) flow.add(Step::go_to, 12, "AGAIN");
    flow.add(Step::end_routine, 13);
    const FlowOfVariables variables(flow);
    const FlowOfVariables::Values values = variables.follow({{2, 1}});
    EXPECT_EQ(values.at(11), 1);
    EXPECT_EQ(values.at(4), ends ? 1 : kUncertain);
  }
}

}  // namespace
}  // namespace armtrue
