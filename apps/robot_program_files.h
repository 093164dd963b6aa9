#pragma once

#include <string>
#include <vector>

#include "armtrue/compensation/program_targets.h"
#include "armtrue/programs/robot_program.h"
#include "command_line.h"

namespace armtrue::app {

/// Options of a robot program that is read and written.
struct RobotProgramFiles {
  std::string path;  ///< empty: none is given
  std::string dat, out, dialect;
  std::vector<std::string> frames;  ///< NAME=x,y,z,a,b,c
  std::vector<std::string> with;    ///< files and folders that declare what the program uses
};

/// What --program takes, for its help: `KUKA .src, ABB .mod`. `with_data_list`: stands behind those
/// that have one.
std::string kinds_of_programs(const std::string& with_data_list = "");

/// --program, --program-out, --dat, --with, --dialect, --frame. Returns --program.
Option add_robot_program(Command& command, RobotProgramFiles& files);

/// --with, for `program`.
void add_texts_of_others(Command& command, const Option& program, std::vector<std::string>& with);

/// The texts of --with, but for those of the program itself.
std::vector<ProgramText> read_others(Command& command, const std::vector<ProgramText>& own,
                                     const std::vector<std::string>& with);

/// The program among them. The whole of a folder is searched as its controller does.
RobotProgram parse_with(const Dialect& dialect, std::vector<ProgramText> own,
                        const std::vector<ProgramText>& others, const KnownFrames& known,
                        TargetParts parts = TargetParts::pose);

/// The frames of --frame. Throws UsageError if one is given twice.
KnownFrames known_frames(const RobotProgramFiles& files);

/// Reads the program and checks that it can be written where it shall be. Throws UsageError if not.
RobotProgram read_robot_program(Command& command, const RobotProgramFiles& files);

/// The file for the .dat of a program that is written to `out`: beside it, or /dev/null too. Throws
/// UsageError if `out` has no name.
std::string dat_of_output(const RobotProgram& program, const std::string& out);

/// For that .dat, which no argument names: check_derived_output(). Throws UsageError if it is there
/// with another text than armtrue writes.
void check_dat_of_output(const Command& command, const RobotProgram& program,
                         const std::string& out);

/// Throws UsageError if the file of --program-out gives the program a name that its controller
/// refuses. Standard output and devices give none.
void refuse_illegal_name(const RobotProgram& program, const std::string& out);

/// Renames the program in its `texts` as its file is called. Standard output and devices leave the
/// name.
void rename_as_file(const RobotProgram& program, const std::string& out,
                    std::vector<std::string>& texts);

/// Writes the texts of a corrected program: the .src, or the only one, to `out`, and a .dat beside
/// it.
void write_program_texts(const RobotProgram& program, const std::vector<std::string>& texts,
                         const std::string& out);

/// Writes the program with the corrections and the points `between` targets, warns of what could
/// not be followed, and returns whether there was nothing of the kind.
bool write_robot_program(Command& command, const RobotProgram& program,
                         const ProgramCommands& commands,
                         const std::vector<ProgramPointBetween>& between,
                         const RobotProgramFiles& files);

}  // namespace armtrue::app
