#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/programs/dialect.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

// Programs that belong together: a backup of a controller, or a folder of programs.

/// The texts in which a controller looks up names that a program does not declare itself. KUKA:
/// $config.dat and the PUBLIC data lists of the same controller, which is the nearest folder around
/// the program with a $config.dat in it; of all, if there is none. ABB: the other modules of the
/// same task (TASK1), or of the same folder. FANUC: listings of registers, frames and tools. Also a
/// short text of what other programs do to the names of the program. Each folder is read once.
class TextsOfOthers {
 public:
  /// `project`: all texts, their names with '/' between folders. Both must outlive this.
  TextsOfOthers(const Dialect& dialect, const std::vector<ProgramText>& project);

  /// The texts of others for the program `path`, which is one of the texts.
  std::vector<ProgramText> of(const std::string& path);
  /// The folder of the controller or task that a program lies in, if it lies deeper; else empty.
  std::string controller_of(const std::string& path) const;
  /// The program and its data lists.
  std::vector<const ProgramText*> own(const std::string& path) const;

 private:
  using Folder = std::pair<std::string, bool>;  // and whether those within it count, too
  const FolderTexts* texts_in(const Folder& folder);

  const Dialect& dialect_;
  const std::vector<ProgramText>& project_;
  std::vector<std::string> marks_;
  std::multimap<std::string, const ProgramText*> by_name_;  // in capitals
  std::map<Folder, std::unique_ptr<FolderTexts>> folders_;
};

/// The same for a program whose texts `own` belong together with `others`, in any folder.
std::vector<ProgramText> what_others_declare(const Dialect& dialect,
                                             const std::vector<ProgramText>& own,
                                             const std::vector<ProgramText>& others);

/// The texts that DialectFacts::controller_mark names.
std::vector<std::string> controller_marks(const Dialect& dialect,
                                          const std::vector<ProgramText>& project);

/// Frames and tools that calls hand on between programs, by the names of programs that call others
/// or that others call. KUKA: $BASE, $TOOL and whether the tool stands in the room; a called
/// program begins with those of its callers, and they go on with those at its end. Other starts of
/// a program are not known.
std::map<std::string, ProgramNeighbours> neighbours_in(const Dialect& dialect,
                                                       const std::vector<ProgramText>& project,
                                                       const KnownFrames& known);

/// Whether a text came with the controller and is no user's program: bas.src of KUKA.
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

/// The result of rewrite_project().
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
