#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "armtrue/programs/robot_program.h"
#include "programs/abb/rapid_words.h"
#include "programs/statement.h"

namespace armtrue {

/// A move as it stands in the program.
struct RapidMoveText {
  const RapidMove* kind_of = nullptr;
  size_t begin = 0, end = 0;
  bool is_first = false;         ///< of the words of its statement
  std::vector<Statement> parts;  ///< its arguments with their options
  std::vector<std::string> options;

  /// J, L or C; 0: joint angles.
  char kind() const {
    if (kind_of->is_joint_target) return 0;
    const std::string_view name = kind_of->name;
    for (const std::string_view family :
         {"MOVE", "TRIGG", "ARCMOVE", "ARC", "DISP", "SPOT", "PAINT", "CAP"})
      if (name.starts_with(family)) return name[family.size()];
    return 0;
  }
};

/// The external axes of each point, by its index, that has six numbers of them.
using RapidExternalAxes = std::map<int, std::vector<double>>;

/// Sets what stands beside the points of a move that is inserted before `move`, a MoveL or MoveC to
/// `points`; or the obstacle, if none can be. `masked`: the text by masked(). `arguments`: of the
/// move, without options.
void prepare_rapid_insertion(const RobotProgram& program, const std::string& masked,
                             const RapidMoveText& move, const RapidExternalAxes& external,
                             const std::vector<int>& points,
                             const std::vector<Statement>& arguments, ProgramTarget& target);

}  // namespace armtrue
