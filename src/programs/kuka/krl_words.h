#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "programs/kuka/krl_syntax.h"
#include "programs/text_cursor.h"

namespace armtrue {

/// A word that begins a move.
struct KrlKeyword {
  std::string_view name;
  KrlMotion motion;
  bool spline;
  bool relative;
};

/// The keyword with this name in capitals; null if there is none.
const KrlKeyword* find_krl_motion(std::string_view name);

/// Whether a mode has this value somewhere in a text: $CIRC_TYPE=#PATH or, of the data of an inline
/// form, CIRC_TYP #PATH. `name`: CIRC_TYP.
bool krl_states_mode(std::string_view text, std::string_view name, std::string_view value);

/// Reads LCPDAT1={VEL 2.0,ACC 100.0,APO_DIST 50.0,..} behind DECL LDAT: its APO_DIST [mm].
void take_krl_ldat(TextCursor& cursor, std::unordered_map<std::string, double>& ldats);

/// What is to be added behind a move, whose words behind its target are `rest`, so that the arm
/// does not stop there: C_DIS or C_SPL, or nothing if it does not stop.
std::string krl_blending(std::string_view rest, const KrlMove& move);

/// A name before a bracket, which calls a routine if there is one with this name.
struct KrlCall {
  std::string name;  ///< in capitals
  int line = 0;
  size_t statement = 0;       ///< where the statement begins that it stands in
  bool is_statement = false;  ///< else it stands in an expression

  /// Where it runs: before the statement of an expression.
  size_t place() const { return is_statement || statement == 0 ? statement : statement - 1; }
};
/// The calls of a source, given by masked(). What declares routines or lets an interrupt or a
/// TRIGGER call them is no call.
std::vector<KrlCall> krl_calls(std::string_view source);

/// The line that begins a routine or a data list: DEF NAME( ), GLOBAL DEFFCT INT NAME( ), DEFDAT
/// NAME.
struct KrlHead {
  std::string word;  ///< DEF, DEFFCT or DEFDAT
  bool is_global = false;
  std::string name;           ///< in capitals; empty if there is none
  size_t begin = 0, end = 0;  ///< of the name
};
/// Nothing of a line that begins neither.
std::optional<KrlHead> krl_head(std::string_view text, const Statement& line);

/// DEF or DEFFCT.
bool begins_krl_routine(std::string_view word);

/// BASE_DATA[3], TOOL_DATA[1]: the same in all programs of a controller.
bool is_krl_frame_list(std::string_view name);

/// Whether a word in capitals begins or ends a loop.
bool begins_krl_loop(std::string_view word);
bool ends_krl_loop(std::string_view word);

/// Whether a variable, whose name the cursor has taken, is set: NAME=.., NAME[3].X=..
bool takes_krl_assignment(TextCursor& cursor);

/// Whether a statement is an assignment that calls nothing but functions of KRL itself.
bool is_krl_assignment(std::string_view statement);

/// Whether a statement that begins with a word in capitals, and is no move, leaves the arm where it
/// is: it waits, assigns, branches or repeats, and calls nothing but functions of KRL itself.
bool leaves_krl_arm(std::string_view statement, std::string_view word);

}  // namespace armtrue
