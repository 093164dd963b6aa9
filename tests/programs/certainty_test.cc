#include <gtest/gtest.h>

#include "programs/program_flow.h"

namespace armtrue::certainty_test {
namespace {

TEST(Certainty, AFlowEndsWhereNothingChanges) {
  using Step = ProgramFlow::Step;
  ProgramFlow flow;  // two routines that call each other, and a thread
  flow.add(Step::routine, 1, "a");
  flow.add(Step::call, 3, "b");
  flow.add(Step::end_routine, 5);
  flow.add(Step::routine, 6, "b");
  flow.add(Step::branch, 7);
  flow.add(Step::call, 8, "a");
  flow.add(Step::end_block, 9);
  flow.add(Step::end_routine, 10);
  flow.add(Step::call, 12, "a");
  EXPECT_EQ(flow.follow({}, 5).at(4), 5);
  const ProgramFlow::Values once = flow.follow({{2, 1}}, 0);
  EXPECT_EQ(once.at(7), 1);
  EXPECT_EQ(once.at(13), 1);
  EXPECT_EQ(once.at(1), ProgramFlow::kUncertain);
  flow.add(Step::interrupt, 20, "t");
  flow.add(Step::end_routine, 25);
  EXPECT_EQ(flow.follow({{2, 1}}, 0).at(22), ProgramFlow::kUncertain);
  EXPECT_EQ(flow.follow({{21, 1}}, 0).at(0), ProgramFlow::kUncertain);
}

}  // namespace
}  // namespace armtrue::certainty_test
