#include "compensation/arms.h"

namespace armtrue {

std::deque<Arms> arms_of(const Robot& identified, const Robot& controller, const Program& program,
                         const CompensationOptions& options) {
  std::vector<ProgramSetUp> set_ups = program.set_ups;
  if (set_ups.empty()) set_ups.push_back({options.base, options.tool});
  std::deque<Arms> arms;
  for (const ProgramSetUp& set_up : set_ups) {
    CompensationOptions own = options;
    own.base = set_up.base;
    own.tool = set_up.tool;
    arms.emplace_back(identified, controller, program, own);
  }
  return arms;
}

Program select(const Program& program, const std::vector<int>& rows) {
  Program chosen;  // no copy of all: each block of a long program selects its rows
  chosen.visits = program.visits.select(rows);
  chosen.set_ups = program.set_ups;
  chosen.states_external = program.states_external;
  const auto pick = [&](const auto& from, auto& to) {
    if (from.empty()) return;
    for (int row : rows) to.push_back(from[row]);
  };
  pick(program.poses, chosen.poses);
  pick(program.hinted, chosen.hinted);
  pick(program.turns, chosen.turns);
  pick(program.joints, chosen.joints);
  pick(program.configurations, chosen.configurations);
  pick(program.motions, chosen.motions);
  pick(program.set_up, chosen.set_up);
  return chosen;
}

Program with_measured_tool(const Robot& identified, Program program, CompensationOptions& options) {
  options.tool = identified.chain.tool;
  for (ProgramSetUp& set_up : program.set_ups) set_up.tool = options.tool;
  return program;
}

}  // namespace armtrue
