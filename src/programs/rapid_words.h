#pragma once

#include <string>

#include "armtrue/programs/robot_program.h"
#include "programs/text_cursor.h"

namespace armtrue {

/// An instruction that moves the arm.
struct RapidMove {
  const char* name;
  int points;
  int tool;  // position of the tool among the arguments
  bool is_joint_target;
};

/// The instruction with this name in capitals; null if there is none that is followed.
const RapidMove* find_rapid_move(const std::string& name);

/// Whether a word in capitals looks like a move and is not followed: process moves have arguments
/// of their own.
bool is_other_rapid_move(const std::string& word);

/// Whether an instruction leaves the arm where it is and does not branch.
bool stands_between_rapid_moves(const std::string& word);

/// What CirPathMode sets; `cursor`: behind its name. Without options, as from the start, the tool
/// turns with the path (RAPID reference manual, CirPathMode, MoveC).
ArcTurning rapid_turning(TextCursor cursor);

/// Radius of a zone that RAPID defines itself [m]; 0 of any other (RAPID reference manual,
/// zonedata).
double radius_of_zone(const std::string& zone);

}  // namespace armtrue
