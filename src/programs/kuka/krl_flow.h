#pragma once

#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

namespace armtrue {

/// A place in a KRL program to which the arm comes from others: a move, or where ways meet.
struct KrlNode {
  std::vector<int> from;  ///< nodes; none: nothing leads here
  size_t set_ups = 0;     ///< statements in KrlSyntax::set_ups before it; not of a move
  int move = -1;          ///< -1: no move
};

/// Follows branches, loops, jumps and calls of a KRL program: from which moves the arm may come to
/// another one (KUKA, KSS 8.x operating and programming instructions, program execution control).
class KrlFlow {
 public:
  /// The node for an unknown place from which the arm comes.
  static constexpr int kElsewhere = 0;

  /// A statement that is no move and begins with `word`. `stays`: it calls nothing that may move
  /// the arm. `set_ups`: those before it.
  void pass(std::string_view word, bool stays, size_t set_ups);
  void add_move(int move);

  bool is_in_loop() const { return loops_ > 0; }
  std::vector<KrlNode> take_nodes() { return std::move(nodes_); }

 private:
  // IF or SWITCH, or a loop, that is not closed yet.
  struct Block {
    bool is_loop;
    int begin;                 // node: before the branches, or where the turns of a loop meet
    std::vector<int> ends{};   // nodes from which the block is left
    bool is_open = true;       // a branch is; not between SWITCH and CASE
    bool is_complete = false;  // there is ELSE or DEFAULT
  };

  int add(std::vector<int> from, int move = -1);
  void open(bool is_loop, bool is_open);
  void begin_branch(bool is_last);
  void close(bool is_loop, std::string_view word);
  void leave_loop();
  void drop_blocks();

  std::vector<KrlNode> nodes_{{}};
  std::vector<Block> blocks_;
  int loops_ = 0;  // of the blocks
  int at_ = kElsewhere;
  size_t set_ups_ = 0;
};

}  // namespace armtrue
