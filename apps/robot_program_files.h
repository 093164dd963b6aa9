#pragma once

#include <string>
#include <vector>

#include "armtrue/compensation/program_targets.h"
#include "armtrue/programs/robot_program.h"
#include "armtrue/text/input_error.h"
#include "command_line.h"

namespace armtrue::app {

/// What to do in place of correcting again what compensate corrected.
inline constexpr const char* kInsteadOfCompensated =
    "give the original one, also after a new calibration; what a pass of the corrected program "
    "still shows is for mirror-correct --program";

/// A program is corrected already.
class CorrectedAlready : public InputError {
  using InputError::InputError;
};

/// Throws CorrectedAlready if a program is marked as corrected, or its numbers have check digits.
/// `instead`: what to give.
void refuse_mark(const std::vector<ProgramText>& texts, Corrector by, const std::string& instead);
void refuse_check_digits(const RobotProgram& program, Corrector by, const std::string& instead);

/// The same of what either corrector marks: of texts, and of a program's numbers and those texts of
/// others that declare its points.
void refuse_corrected_texts(const std::vector<ProgramText>& texts);
void refuse_corrected_points(const RobotProgram& program);

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

/// The frames of --frame. Throws UsageError if one is given twice.
KnownFrames known_frames(const RobotProgramFiles& files);

/// Reads the program and checks that it can be written where it shall be. Throws UsageError if not.
RobotProgram read_robot_program(Command& command, const RobotProgramFiles& files);

/// The file for the .dat of a program that is written to `out`: beside it, or /dev/null too. Throws
/// UsageError if `out` has no name.
std::string dat_of_output(const RobotProgram& program, const std::string& out);

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
