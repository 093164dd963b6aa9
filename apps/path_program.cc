#include "path_program.h"

#include <fmt/format.h>

#include <filesystem>

#include "armtrue/io/output.h"
#include "armtrue/io/program_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/programs/displacement.h"
#include "armtrue/text/input_error.h"

namespace armtrue::app {
namespace {

Dialect dialect_of(const PathProgramArguments& arguments) {
  return dialect_of_file(arguments.path).value_or(Dialect::krl);
}

// The file of the corrected program.
std::string program_out(const PathProgramArguments& arguments) {
  if (!arguments.out.empty()) return arguments.out;
  const std::filesystem::path program(arguments.path);
  // A program of the other makers has the name of its file, which must be legal.
  const char* const ending = dialect_of(arguments) == Dialect::krl ? "-corrected" : "_corrected";
  return std::filesystem::path(program)
      .replace_filename(program.stem().string() + ending + program.extension().string())
      .string();
}

// A program of another maker than KUKA.
RobotProgram read_other_program(Command& command, const PathProgramArguments& arguments) {
  RobotProgram program = parse_program(dialect_of(arguments),
                                       command.read_program_texts(arguments.path, "", false), {});
  const std::string out = program_out(arguments);
  const std::string wrong =
      why_illegal_name(program.dialect, std::filesystem::path(out).stem().string());
  if (out != "-" && !wrong.empty()) throw UsageError("--program-out: " + wrong);
  if (arguments.out.empty()) command.refuse_named(out);
  check_writable(out);
  return program;
}

// The names of the products follow from those of the arguments: they may be those of an input.
void check_program_out(const Command& command, const PathProgramArguments& arguments,
                       const KrlProgram& program) {
  const std::string out = program_out(arguments);
  if (arguments.out.empty()) command.refuse_named(out);
  check_writable(out);
  if (!program.dat) return;
  const std::string dat = dat_beside(out, program.dat->name);
  command.refuse_named(dat);
  if (same_file(dat, program.dat->name) || same_file(dat, out) || same_file(out, program.dat->name))
    throw InputError(out + ": the data list of the corrected program would be " + dat +
                     ", and that of the program, " + program.dat->name +
                     ", would be lost; give --program-out another name, such as corrected.src");
  check_writable(dat);
}

void tell_of_program(Command& command, const std::string& name,
                     const std::vector<std::string>& warnings, int corrected, int inserted,
                     int left_alone) {
  for (const std::string& warning : warnings) command.warn(warning);
  command.tell(fmt::format("{}: {} points corrected, {} moves inserted, {} moves left alone\n",
                           name, corrected, inserted, left_alone));
}

void correct_program(Command& command, const PathProgramArguments& arguments,
                     const KrlProgram& program, const Path& programmed,
                     const Eigen::Matrix3Xd& corrected) {
  KrlCorrectionOptions options;
  options.spacing = arguments.spacing_mm * kMillimetre;
  const CorrectedKrl rewritten = correct_krl(program, programmed, corrected, options);
  tell_of_program(command, program.src.name, rewritten.warnings, rewritten.corrected,
                  rewritten.inserted, rewritten.left_alone);
  write_krl(rewritten, program, program_out(arguments));
}

void correct_program(Command& command, const PathProgramArguments& arguments,
                     const RobotProgram& program, const Path& programmed,
                     const Eigen::Matrix3Xd& corrected) {
  DisplacementOptions options;
  options.spacing = arguments.spacing_mm * kMillimetre;
  DisplacedProgram displaced = displace_program(program, programmed, corrected, options);
  const std::string out = program_out(arguments);
  if (out != "-") rename(program, std::filesystem::path(out).stem().string(), displaced.text.texts);
  tell_of_program(command, program.texts[0].name, displaced.warnings, displaced.corrected,
                  displaced.text.inserted, displaced.left_alone);
  write_output(out, displaced.text.texts[0]);
}

}  // namespace

void add_path_program(Command& command, PathProgramArguments& arguments) {
  const Option program =
      command.file("--program", arguments.path,
                   "Robot program of the programmed path: KUKA .src with its .dat, ABB .mod, FANUC "
                   ".ls, UR .script");
  command
      .add_output(
          "--program-out", arguments.out,
          "Write the corrected program here, its .dat beside it [NAME-corrected.src; of the "
          "others NAME_corrected]")
      .needs(program);
  command
      .option("--spacing-mm", arguments.spacing_mm,
              "Least distance of the points that are inserted into the program")
      .check(in_range(0.0, 1000.0))
      .default_shown()
      .needs(program);
}

PathProgram read_path_program(Command& command, const PathProgramArguments& arguments) {
  PathProgram program;
  if (dialect_of(arguments) != Dialect::krl) {
    program.other = read_other_program(command, arguments);
    return program;
  }
  program.krl = read_krl(arguments.path);
  check_program_out(command, arguments, *program.krl);
  return program;
}

void write_path_program(Command& command, const PathProgramArguments& arguments,
                        const PathProgram& program, const Path& programmed,
                        const Eigen::Matrix3Xd& corrected) {
  if (program.krl) correct_program(command, arguments, *program.krl, programmed, corrected);
  if (program.other) correct_program(command, arguments, *program.other, programmed, corrected);
}

}  // namespace armtrue::app
