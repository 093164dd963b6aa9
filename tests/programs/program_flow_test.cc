#include "programs/program_flow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>

// ProgramFlow against random programs that are run many times, each time by other ways: a value
// that it knows must be the only one that a run sees, and a way that a run takes must be among its
// ways.

namespace armtrue {
namespace {

using Step = ProgramFlow::Step;
constexpr int kUncertain = ProgramFlow::kUncertain, kInitial = 7, kBegin = -1;
constexpr int kRoutines = 5;

// A step, a move, or a setting.
struct Statement {
  std::optional<Step> step;
  std::string name = "";
  int value = 0;  // 0: a move
};

struct Program {
  std::vector<Statement> statements;  // by place
  ProgramFlow flow;
  std::vector<ProgramFlow::Setting> settings;
  std::vector<size_t> moves;
  std::map<std::string, size_t> routines;  // where each begins
  // Of each step of a block: the next alternative, or the end of the block; of the end: its begin.
  std::map<size_t, size_t> next;

  void add(Step step, const std::string& name = "") {
    flow.add(step, statements.size(), name);
    statements.push_back({step, name});
  }
  void set(int value) {
    settings.push_back({statements.size(), value});
    statements.push_back({std::nullopt, "", value});
  }
  void move() {
    moves.push_back(statements.size());
    statements.push_back({std::nullopt});
  }
};

std::string name_of(int routine) { return "SUB" + std::to_string(routine); }

// `is_wild`: with jumps, labels, handlers, calls of any routine, and routines that call each other.
class Writer {
 public:
  Writer(unsigned seed, bool is_wild) : random_(seed), is_wild_(is_wild) {}

  Program write() {
    for (int r = 0; r < kRoutines; ++r) {
      program_.routines[name_of(r)] = program_.statements.size();
      program_.add(Step::routine, name_of(r));
      block(3, is_wild_ && below(4) == 0 ? std::min(r, 1) : r + 1, false);
      program_.add(Step::end_routine);
    }
    find_blocks();
    return std::move(program_);
  }

 private:
  int below(int count) { return std::uniform_int_distribution(0, count - 1)(random_); }

  void block(int depth, int first_callee, bool in_loop) {
    const auto inner = [&](bool is_loop) { block(depth - 1, first_callee, in_loop || is_loop); };
    for (int left = 1 + below(4); left > 0; --left) switch (below(is_wild_ ? 18 : 13)) {
        case 0:
        case 1:
          program_.set(1 + below(2));
          break;
        case 2:
        case 3:
        case 4:
          if (first_callee < kRoutines)
            program_.add(Step::call, name_of(first_callee + below(kRoutines - first_callee)));
          break;
        case 5:
        case 6:
          if (depth > 0) choice(inner);
          break;
        case 7:
        case 8:
          if (depth == 0) break;
          program_.add(below(2) == 0 ? Step::loop : Step::repeat);
          inner(true);
          program_.add(Step::end_block);
          break;
        case 9:
          if (in_loop) program_.add(Step::exit_loop);
          break;
        case 10:
          if (below(3) == 0) program_.add(Step::leave);
          break;
        case 13:
          program_.add(Step::jump);
          break;
        case 14:
          program_.add(Step::go_to, "L");
          break;
        case 15:
          program_.add(Step::label, "L");
          break;
        case 16:
          program_.add(below(2) == 0 ? Step::stop : Step::handler);
          break;
        case 17:
          if (below(4) == 0) program_.add(Step::call);
          break;
        default:
          program_.move();
      }
  }

  template <class Inner>
  void choice(const Inner& inner) {
    const bool is_choice = below(2) == 0;
    program_.add(is_choice ? Step::choice : Step::branch);
    if (!is_choice) inner(false);
    for (int others = below(2) + is_choice; others > 0; --others) {
      program_.add(Step::alternative);
      inner(false);
    }
    if (below(2) == 0) {
      program_.add(Step::otherwise);
      inner(false);
    }
    program_.add(Step::end_block);
  }

  void find_blocks() {
    std::vector<std::pair<size_t, size_t>> open;  // begin, last alternative
    for (size_t at = 0; at < program_.statements.size(); ++at)
      switch (program_.statements[at].step.value_or(Step::jump)) {
        case Step::branch:
        case Step::choice:
        case Step::loop:
        case Step::repeat:
          open.emplace_back(at, at);
          break;
        case Step::alternative:
        case Step::otherwise:
          program_.next[std::exchange(open.back().second, at)] = at;
          break;
        case Step::end_block:
          program_.next[open.back().second] = at;
          program_.next[at] = open.back().first;
          open.pop_back();
          break;
        default:
          break;
      }
  }

  std::mt19937 random_;
  const bool is_wild_;
  Program program_;
};

// Runs a program by random ways, from one of the routines that nothing calls.
class Runner {
 public:
  Runner(const Program& program, unsigned seed) : program_(program), random_(seed) {}

  void run(const std::string& routine) {
    value_ = kInitial;
    last_move_ = kBegin;
    left_ = 400;
    this->routine(program_.routines.at(routine));
  }

  std::map<size_t, std::set<int>> values;     // by place: behind it
  std::map<size_t, std::set<int>> move_from;  // moves before each

 private:
  static constexpr size_t kEnd = 0;

  int below(int count) { return std::uniform_int_distribution(0, count - 1)(random_); }
  Step step_at(size_t at) const { return program_.statements[at].step.value_or(Step::jump); }
  bool is_loop(size_t at) const { return step_at(at) == Step::loop || step_at(at) == Step::repeat; }

  size_t end_of(size_t at) const {
    while (step_at(at) != Step::end_block) at = program_.next.at(at);
    return at;
  }
  // To one of the alternatives of a block, or past them all.
  size_t branch(size_t at) {
    if (step_at(at) == Step::branch && below(2) == 0) return at + 1;
    for (;;) {
      at = program_.next.at(at);
      if (step_at(at) == Step::end_block) see(at);
      if (step_at(at) != Step::alternative || below(2) == 0) break;
    }
    see(at);
    return at + 1;
  }
  // Behind the loop around a place.
  size_t behind_loop(size_t at) const {
    for (size_t begin = at; begin-- > 0;)
      if (is_loop(begin) && end_of(begin) > at) return end_of(begin);
    return kEnd;
  }
  size_t any_of(Step step, size_t at) {
    std::vector<size_t> found;
    size_t begin = at, end = at;
    while (step_at(begin) != Step::routine) --begin;
    while (step_at(end) != Step::end_routine) ++end;
    for (size_t i = begin; i < end; ++i)
      if (program_.statements[i].step == step) found.push_back(i);
    return found.empty() ? kEnd : found[below(static_cast<int>(found.size()))];
  }

  void see(size_t at) { values[at].insert(value_); }

  void routine(size_t begin) {
    see(begin);
    for (size_t at = begin + 1; at != kEnd;) {
      if (--left_ < 0 || program_.statements[at].step == Step::end_routine) return;
      at = behind(at);
      const size_t handler =
          below(20) == 0 && left_ >= 0 && at != kEnd ? any_of(Step::handler, at) : kEnd;
      if (handler == kEnd) continue;
      see(handler);
      at = handler + 1;
    }
  }

  // Runs one statement; returns the place of the next one.
  size_t behind(size_t at) {
    const Statement& now = program_.statements[at];
    if (!now.step) {
      if (now.value != 0) {
        value_ = now.value;
      } else {
        move_from[at].insert(last_move_);
        last_move_ = static_cast<int>(at);
      }
      see(at);
      return at + 1;
    }
    switch (*now.step) {
      case Step::leave:
      case Step::handler:
        return kEnd;
      case Step::stop:
        left_ = 0;
        return kEnd;
      case Step::call:
        call(now.name);
        if (left_ <= 0) return kEnd;
        break;
      case Step::branch:
      case Step::choice:
        see(at);
        return branch(at);
      case Step::alternative:
      case Step::otherwise:
        see(end_of(at));
        return end_of(at) + 1;
      case Step::loop:
        see(at);
        if (below(2) == 0) see(at = end_of(at));
        return at + 1;
      case Step::end_block:
        if (const size_t begin = program_.next.at(at); is_loop(begin) && below(2) == 0)
          return begin;
        break;
      case Step::exit_loop:
        if (const size_t end = behind_loop(at); end != kEnd) {
          see(end);
          return end + 1;
        }
        break;
      case Step::go_to:
      case Step::jump: {
        const bool jumps = *now.step == Step::go_to || below(2) == 0;
        if (!jumps) break;
        const size_t label = any_of(Step::label, at);
        if (label == kEnd && *now.step == Step::go_to) left_ = 0;
        if (label == kEnd) return kEnd;
        see(label);
        return label + 1;
      }
      default:
        break;
    }
    see(at);
    return at + 1;
  }

  void call(std::string name) {
    if (name.empty() && below(2) == 0) return;
    routine(program_.routines.at(name.empty() ? name_of(below(kRoutines)) : name));
  }

  const Program& program_;
  std::mt19937 random_;
  int value_ = 0, last_move_ = 0, left_ = 0;
};

// The moves before each, through junctions.
std::vector<std::set<int>> moves_before(const Program& program) {
  const std::vector<std::vector<int>> ways = program.flow.ways(program.moves);
  const int begin = static_cast<int>(program.moves.size());
  std::vector<std::set<int>> all(begin);
  for (int move = 0; move < begin; ++move) {
    std::set<int> seen;
    for (std::vector<int> open = ways[move]; !open.empty();) {
      const int node = open.back();
      open.pop_back();
      if (!seen.insert(node).second) continue;
      if (node < begin)
        all[move].insert(static_cast<int>(program.moves[node]));
      else if (node == begin)
        all[move].insert(kBegin);
      else
        open.insert(open.end(), ways[node].begin(), ways[node].end());
    }
  }
  return all;
}

TEST(ProgramFlow, KnowsNoMoreThanRunsShowAndMissesNoWay) {
  for (const bool is_wild : {false, true}) {
    int certain = 0, seen_once = 0, taken = 0, ways = 0;
    for (unsigned seed = 0; seed < 1500; ++seed) {
      const Program program = Writer(seed, is_wild).write();
      const ProgramFlow::Values values = program.flow.follow(program.settings, kInitial);
      std::set<std::string> called;
      for (const Statement& statement : program.statements)
        if (statement.step == Step::call) called.insert(statement.name);
      Runner runner(program, seed);
      for (int run = 0; run < 150; ++run)
        for (const auto& [name, begin] : program.routines)
          if (name == name_of(0) || !called.contains(name)) runner.run(name);
      for (const auto& [place, seen] : runner.values) {
        const int value = values.at(place);
        seen_once += seen.size() == 1;
        certain += value != kUncertain;
        if (value != kUncertain)
          EXPECT_EQ(seen, std::set<int>{value}) << "program " << seed << ", place " << place;
      }
      const std::vector<std::set<int>> before = moves_before(program);
      for (size_t i = 0; i < program.moves.size(); ++i) {
        ways += static_cast<int>(before[i].size());
        for (const int from : runner.move_from[program.moves[i]]) {
          ++taken;
          EXPECT_TRUE(before[i].contains(from))
              << "program " << seed << ", from " << from << " to " << program.moves[i];
        }
      }
    }
    EXPECT_GT(certain, seen_once / 2);
    EXPECT_GT(taken, ways / 3);
  }
}

}  // namespace
}  // namespace armtrue
