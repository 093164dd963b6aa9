#include "path_program.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "armtrue/io/output.h"
#include "armtrue/io/program_io.h"
#include "armtrue/programs/corrected_already.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "robot_program_files.h"

namespace armtrue::app {
namespace {

// The file of the corrected program.
std::string program_out(const PathProgramArguments& arguments) {
  if (!arguments.out.empty()) return arguments.out;
  if (arguments.path == "-" || is_device_or_pipe(arguments.path))
    throw UsageError("--program-out: '" + arguments.path +
                     "' has no name from which that of the corrected program follows; give it");
  const std::filesystem::path program(arguments.path);
  // An underscore, because the name of the file is that of the program.
  return std::filesystem::path(program)
      .replace_filename(program.stem().string() + "_corrected" + program.extension().string())
      .string();
}

constexpr const char* kInsteadOfCorrected =
    "give the original program, and the corrected path that the passes ran as --previous";

// The arguments give the names of the products: a product may have the name of an input.
void check_program_out(const Command& command, const PathProgramArguments& arguments,
                       const RobotProgram& program) {
  const std::string out = program_out(arguments);
  refuse_illegal_name(program, out);
  if (arguments.out.empty()) command.check_derived_output(out);
  if (program.own_texts < 2) return;
  const std::string& original = program.texts[1].name;
  const std::string dat = dat_of_output(program, out);
  if (is_device_or_pipe(out)) return;
  if (same_file(dat, original) || same_file(dat, out) || same_file(out, original))
    throw InputError(out + ": the data list of the corrected program would be " + dat +
                     ", and that of the program, " + original +
                     ", would be lost; give --program-out another name, such as corrected.src");
  check_dat_of_output(command, program, out);
}

}  // namespace

void add_path_program(Command& command, PathProgramArguments& arguments) {
  const Option program =
      command.file("--program", arguments.path,
                   "Robot program of the programmed path: " + kinds_of_programs(" with its .dat"));
  command
      .add_output(
          "--program-out", arguments.out,
          "Write the corrected program here, its .dat beside it; it gets the name of this file "
          "[NAME_corrected]")
      .needs(program);
  add_texts_of_others(command, program, arguments.with);
  command
      .option("--spacing-mm", arguments.spacing_mm,
              "Least distance of the points that are inserted into the program")
      .check(in_range(0.0, 1000.0))
      .default_shown()
      .needs(program);
}

RobotProgram read_original_program(Command& command, const std::string& path,
                                   const std::vector<std::string>& with, const char* remedy) {
  const Dialect& dialect = likely_dialect(path);
  std::vector<ProgramText> texts =
      command.read_program_texts(path, "", !dialect.facts().data_list.empty());
  refuse_mark(texts, Corrector::mirror, remedy);
  refuse_cut_off(dialect, texts);
  const std::vector<ProgramText> others = read_others(command, texts, with);
  RobotProgram program = parse_with(dialect, std::move(texts), others, {}, TargetParts::position);
  refuse_check_digits(program, Corrector::mirror, remedy);
  return program;
}

RobotProgram read_path_program(Command& command, const PathProgramArguments& arguments) {
  program_out(arguments);  // throws if there is none
  RobotProgram program =
      read_original_program(command, arguments.path, arguments.with, kInsteadOfCorrected);
  check_program_out(command, arguments, program);
  return program;
}

void write_path_program(Command& command, const PathProgramArguments& arguments,
                        const RobotProgram& program, const Path& programmed,
                        const Eigen::Matrix3Xd& corrected,
                        const std::optional<Eigen::Matrix3Xd>& previous) {
  for (const Eigen::Matrix3Xd* path : {&corrected, previous ? &*previous : nullptr})
    if (path && lies_on_corrected(program, programmed.position, *path))
      throw InputError(fmt::format(
          "{}: its points lie on the corrected path: it is corrected already; corrected twice, it "
          "would be wrong: {}",
          program.texts[0].name, kInsteadOfCorrected));
  DisplacementOptions options;
  options.spacing = arguments.spacing_mm * kMillimetre;
  options.by = Corrector::mirror;
  DisplacedProgram displaced = displace_program(program, programmed, corrected, options);
  std::vector<std::string>& texts = displaced.text.texts;
  mark_corrected(program, Corrector::mirror, texts);
  const std::string out = program_out(arguments);
  rename_as_file(program, out, texts);
  warn_of_all(command, displaced.warnings);
  command.tell(fmt::format("{}: {} corrected, {} inserted, {} left alone\n", program.texts[0].name,
                           counted(displaced.corrected, "point"),
                           counted(displaced.text.inserted, "move"),
                           counted(displaced.left_alone, "move")));
  write_program_texts(program, texts, out);
}

}  // namespace armtrue::app
