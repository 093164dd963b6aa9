#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "programs/statement.h"

// What a job does to others: it calls them, and gives values to variables, frames and tools.

namespace armtrue {

/// One for each instruction behind `begin` of a job, which is given by masked(); a line that begins
/// with + moves another group together with the line before.
std::vector<Statement> inform_lines(std::string_view job, size_t begin);
/// Where //INST begins, or the end of the job.
size_t inform_instructions(std::string_view job);
/// Of //NAME; nothing if there is none.
std::optional<std::string> inform_job_name(std::string_view job);
/// Of ///GROUP1: 1 of RB1, also if there is none; nothing of another kind.
std::optional<int> inform_robot(std::string_view job);

/// MOVJ, MOVL, MOVC, MOVS, and SMOVL, SMOVC, SMOVS, which are coordinated with a station or with
/// another robot.
bool is_inform_move(const std::string& word);
/// Motions that are not followed.
bool is_other_inform_motion(const std::string& word);

/// What jobs give values to as they run.
struct InformChanges {
  static constexpr int kAnyFrame = 1000;  ///< frames have numbers below 64
  std::set<std::string> variables;        ///< by inform_position_name()
  bool is_any_variable = false;           ///< P[..]
  std::set<int> users, tools;
};
/// Adds what a statement changes; frames and tools if they count.
void note_inform_changes(std::string_view job, const Statement& statement, bool with_frames,
                         InformChanges& changes);

/// The names of the jobs that a statement calls, CALL JOB:NAME ARGF1 IF B000=1; empty where a
/// variable names the job.
std::vector<std::string> inform_calls(std::string_view job, const Statement& statement);

}  // namespace armtrue
