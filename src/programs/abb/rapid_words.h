#pragma once

#include <string>

#include "armtrue/programs/robot_program.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

namespace armtrue {

/// An instruction that moves the arm.
struct RapidMove {
  static constexpr int kLast = -1;
  const char* name;
  int points;
  int tool;  ///< position of the tool among the arguments; kLast in a process move
  bool is_joint_target;

  bool is_process() const { return tool == kLast; }
};

/// The instruction with this name in capitals; null if there is none that is followed.
const RapidMove* find_rapid_move(const std::string& name);

/// Whether a word in capitals looks like a move and is not followed: other process moves have
/// arguments of their own. `cursor`: behind it.
bool is_other_rapid_move(const std::string& word, TextCursor cursor);

/// Whether an instruction leaves the arm where it is and does not branch.
bool stands_between_rapid_moves(const std::string& word);

/// PROC, FUNC or TRAP.
bool begins_rapid_routine(const std::string& word);
/// Their ends.
bool ends_rapid_routine(const std::string& word);

/// Calls with(word, at, cursor) for each word of a statement, in capitals, until it returns true.
/// Options (\WObj), components (.trans) and the heads of routines are passed over, but for the word
/// that a head begins with. `cursor` stands behind the word and may be moved.
template <class With>
void each_rapid_word(std::string_view text, const Statement& statement, With with) {
  TextCursor cursor(text, statement.begin, statement.end);
  char before = ' ';
  while (!cursor.done()) {
    const size_t at = cursor.at();
    const std::string word = cursor.take_name();
    if (word.empty()) {
      before = cursor.next();
      cursor.step();
      continue;
    }
    const bool is_part = before == '\\' || before == '.';
    before = ' ';
    if (is_part) continue;
    if (with(word, at, cursor)) return;
    if (!begins_rapid_routine(word)) continue;
    while (!cursor.take_name().empty()) continue;
    if (cursor.take('(')) cursor.skip_to(")");
  }
}

/// A module by masked(), and blanks for the brackets about the argument of a procedure that it
/// declares, pick(p10); such an expression is what stands in it.
std::string masked_rapid(const std::string& module);

/// Whether a datum, whose name the cursor has taken, is given a value: NAME := ..,
/// NAME.trans.x := .., NAME{2} := ..
bool takes_rapid_assignment(TextCursor& cursor);

/// Whether what stands at `at`, before a `:=`, is no datum but the name of a parameter of the
/// routine that the statement calls: `rMove x:=1, p10`. Options (\x:=1) are others.
bool names_rapid_parameter(std::string_view text, const Statement& statement, size_t at);

/// What CirPathMode sets; `cursor`: behind its name. Without options, as from the start, the tool
/// turns with the path (RAPID reference manual, CirPathMode, MoveC).
ArcTurning rapid_turning(TextCursor cursor);

/// Radius of a zone that RAPID defines itself [m]; 0 of any other (RAPID reference manual,
/// zonedata).
double radius_of_rapid_zone(const std::string& zone);

}  // namespace armtrue
