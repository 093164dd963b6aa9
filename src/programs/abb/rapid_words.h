#pragma once

#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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
/// CONST, PERS or VAR.
bool is_rapid_declaration(const std::string& word);
/// The ends of routines.
bool ends_rapid_routine(const std::string& word);

/// Takes the name of a routine behind the word that begins it: a FUNC has a type before its name,
/// and what follows the name of a TRAP is its first statement.
std::string take_rapid_routine(const std::string& word, TextCursor& cursor);

/// Behind the name of a datum: goes behind its components and indices.
void skip_rapid_part(TextCursor& cursor);

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
    take_rapid_routine(word, cursor);
    if (cursor.take('(')) cursor.skip_to(")");
  }
}

/// A parameter of a routine: `PERS robtarget point`, `num n`, `\switch fast`.
struct RapidParameter {
  std::string mode;  ///< VAR, PERS or INOUT; empty: the routine gets a copy
  std::string type, name;
  bool is_optional = false;
};

/// Calls with(parameter) for each parameter of a routine; `cursor`: behind its name.
template <class With>
void each_rapid_parameter(std::string_view text, TextCursor cursor, With with) {
  if (!cursor.take('(')) return;
  const size_t begin = cursor.at();
  cursor.skip_to(")");
  for (const Statement& part : split_arguments(text, begin, cursor.at(), ",|\\")) {
    TextCursor words(text, part.begin, part.end);
    RapidParameter parameter;
    for (std::string word = words.take_name(); !word.empty(); word = words.take_name()) {
      parameter.mode = std::exchange(parameter.type, parameter.name);
      parameter.name = word;
    }
    if (parameter.name.empty()) continue;
    size_t before = part.begin;
    while (before > begin && is_blank(text[before - 1])) --before;
    parameter.is_optional = text[before - 1] == '\\' || text[before - 1] == '|';
    with(parameter);
  }
}

/// Calls with(statement, word, at, cursor) for each word of a module as each_rapid_word() does, but
/// for declarations and for what the routine around it declares itself.
template <class With>
void each_rapid_use(std::string_view text, const std::vector<Statement>& statements, With with) {
  std::set<std::string> of_routine;
  for (const Statement& statement : statements)
    each_rapid_word(text, statement, [&](const std::string& word, size_t at, TextCursor& cursor) {
      if (begins_rapid_routine(word) || ends_rapid_routine(word)) of_routine.clear();
      if (begins_rapid_routine(word)) {
        TextCursor head = cursor;
        take_rapid_routine(word, head);
        each_rapid_parameter(text, head, [&](const RapidParameter& parameter) {
          of_routine.insert(parameter.name);
        });
      } else if (is_rapid_declaration(word)) {
        cursor.take_name();
        of_routine.insert(cursor.take_name());
      } else if (!of_routine.contains(word)) {
        with(statement, word, at, cursor);
      }
      return false;
    });
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
