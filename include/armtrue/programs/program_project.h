#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/programs/robot_program.h"

namespace armtrue {

// Programs that belong together: a backup of a controller, or a folder of programs.

/// The texts in which the controller looks up names that the program `path` does not declare
/// itself. `project`: all texts, their names with '/' between folders. KUKA: $config.dat and the
/// PUBLIC data lists of the same controller, which is the nearest folder around the program with a
/// $config.dat in it; of all, if there is none. ABB: the other modules of the same task (TASK1), or
/// of the same folder.
std::vector<ProgramText> texts_of_others(const Dialect& dialect,
                                         const std::vector<ProgramText>& project,
                                         const std::string& path);

/// What counts of the texts of others, given as they are: of KUKA data lists what is global, and of
/// programs where they give values; of ABB modules all; of the other makers nothing.
std::vector<ProgramText> what_others_declare(const Dialect& dialect,
                                             const std::vector<ProgramText>& others);

/// What calls between programs hand on, by the names of the programs that call others or that
/// others call. KUKA: $BASE, $TOOL and whether the tool stands in the room; a program that others
/// call begins with what its callers have, and they go on with what it leaves. Nothing is known of
/// who else may start it.
std::map<std::string, ProgramNeighbours> neighbours_in(const Dialect& dialect,
                                                       const std::vector<ProgramText>& project,
                                                       const KnownFrames& known);

/// Whether a text came with the controller and is nobody's program: bas.src of KUKA.
bool is_of_controller(const std::string& path);

/// A program with the commands for its targets.
struct ProjectProgram {
  RobotProgram program;
  std::vector<ProgramCommand> commands;
};

/// A point that one text declares and others use, and that the commands change.
struct SharedPoint {
  std::string name, text;             ///< the text that declares it
  int line = 0;                       ///< there
  std::vector<std::string> users;     ///< texts that name it
  bool is_written = false;            ///< where it is declared; else in the moves that use it
};

struct RewrittenProject {
  std::map<std::string, std::string> texts;  ///< those that change, by their names
  std::vector<RewrittenProgram> programs;    ///< their own texts do not hold the changes of others
  std::vector<SharedPoint> shared;
};

/// Rewrites programs that share points. A shared point changes once, where it is declared, if all
/// its moves in all programs need the same numbers and no other text names it; otherwise it stays,
/// and each move that needs other numbers gets a point of its own, as of rewrite(). With `by`, the
/// texts that change are marked. `project`: all texts.
RewrittenProject rewrite_project(std::vector<ProjectProgram> programs,
                                 const std::vector<ProgramText>& project,
                                 std::optional<Corrector> by = std::nullopt);

}  // namespace armtrue
