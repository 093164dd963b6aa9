#include "programs/kuka/krl_flow.h"

#include <algorithm>

#include "programs/kuka/krl_words.h"

namespace armtrue {

void KrlFlow::pass(std::string_view word, bool stays, size_t set_ups) {
  set_ups_ = set_ups;
  if (!stays) at_ = kElsewhere;
  if (begins_krl_routine(word)) {
    drop_blocks();
  } else if (word == "IF" || word == "SWITCH") {
    open(false, word == "IF");
  } else if (word == "ELSE" || word == "CASE" || word == "DEFAULT") {
    begin_branch(word != "CASE");
  } else if (begins_krl_loop(word)) {
    open(true, true);
  } else if (word == "ENDIF" || word == "ENDSWITCH") {
    close(false, word);
  } else if (ends_krl_loop(word)) {
    close(true, word);
  } else if (word == "EXIT") {
    leave_loop();
  } else if (word == "GOTO" || word == "RETURN" || word == "RESUME") {
    at_ = add({});
  }
}

void KrlFlow::add_move(int move) { at_ = add({at_}, move); }

int KrlFlow::add(std::vector<int> from, int move) {
  nodes_.push_back({std::move(from), set_ups_, move});
  return static_cast<int>(nodes_.size()) - 1;
}

void KrlFlow::open(bool is_loop, bool is_open) {
  if (is_loop) at_ = add({at_});
  loops_ += is_loop;
  blocks_.push_back({is_loop, at_, {}, is_open});
}

void KrlFlow::begin_branch(bool is_last) {
  if (blocks_.empty() || blocks_.back().is_loop) return;
  Block& block = blocks_.back();
  if (block.is_open) block.ends.push_back(at_);
  block.is_open = true;
  block.is_complete |= is_last;
  at_ = block.begin;
}

void KrlFlow::drop_blocks() {
  for (const Block& block : blocks_)
    if (block.is_loop) nodes_[block.begin].from.push_back(kElsewhere);
  blocks_.clear();
  loops_ = 0;
  at_ = kElsewhere;
}

// A block whose end does not match its beginning is no KRL: then nothing is certain.
void KrlFlow::close(bool is_loop, std::string_view word) {
  if (blocks_.empty() || blocks_.back().is_loop != is_loop) {
    drop_blocks();
    return;
  }
  Block block = std::move(blocks_.back());
  blocks_.pop_back();
  loops_ -= is_loop;
  if (is_loop) {
    at_ = add({at_});  // with the frames that the next turn begins with
    nodes_[block.begin].from.push_back(at_);
  }
  // FOR and WHILE end where they begin, REPEAT at UNTIL, LOOP only by EXIT.
  if (is_loop ? word == "UNTIL" : block.is_open) block.ends.push_back(at_);
  if (is_loop ? word == "ENDFOR" || word == "ENDWHILE" : !block.is_complete)
    block.ends.push_back(block.begin);
  at_ = add(std::move(block.ends));
}

void KrlFlow::leave_loop() {
  const auto loop = std::ranges::find(blocks_.rbegin(), blocks_.rend(), true, &Block::is_loop);
  if (loop != blocks_.rend()) loop->ends.push_back(at_);
  at_ = add({});
}

}  // namespace armtrue
