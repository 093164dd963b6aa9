#include "robot_program_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "armtrue/io/output.h"
#include "armtrue/io/program_io.h"
#include "armtrue/io/source.h"
#include "armtrue/programs/corrected_already.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/programs/program_project.h"
#include "armtrue/text/edit_distance.h"
#include "armtrue/text/number_text.h"
#include "option_text.h"
#include "program_arguments.h"

namespace armtrue::app {
namespace {

namespace fs = std::filesystem;

// `NAME=x,y,z,a,b,c`; the name may hold brackets.
std::pair<std::string, Pose> frame_from_text(const std::string& text) {
  const size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0)
    throw std::invalid_argument("'" + text + "' is no frame; give NAME=" + kPoseForm);
  return {text.substr(0, equals),
          pose_from_numbers(numbers_from_text(text.substr(equals + 1), 6, kPoseForm))};
}

Check frame_check() {
  return {"", [](const std::string& text) {
            try {
              frame_from_text(text);
              return std::string();
            } catch (const std::invalid_argument& error) {
              return std::string(error.what());
            }
          }};
}

// Standard output, a device or a pipe has no name.
bool has_name(const std::string& output) { return output != "-" && !is_device_or_pipe(output); }

const Dialect& dialect_of(const RobotProgramFiles& files) {
  if (!files.dialect.empty()) return *find_dialect(files.dialect);
  if (const auto dialect = dialect_of_file(files.path)) return *dialect;
  std::vector<std::string> endings;
  for (const Dialect* dialect : dialects())
    for (const std::string& ending : dialect->facts().endings)
      endings.push_back(lower_case(ending));
  throw UsageError(fmt::format(
      "--program: '{}' does not end as a program does ({}); say what it is with --dialect",
      files.path, fmt::join(endings, ", ")));
}

void refuse_outputs(const Command& command, const RobotProgram& program,
                    const RobotProgramFiles& files) {
  const bool has_dat = program.own_texts > 1;
  const std::string dat = has_dat ? dat_of_output(program, files.out) : "";
  if (!has_name(files.out)) return;
  refuse_illegal_name(program, files.out);
  std::vector<std::string> outputs{files.out};
  if (has_dat) outputs.push_back(dat);
  if (has_dat && same_file(outputs[0], outputs[1]))
    throw UsageError("--program-out: '" + files.out + "' is the name of a .dat; name a .src");
  for (const std::string& output : outputs)
    for (const ProgramText& text : program.texts)
      if (!text.name.empty() && same_file(output, text.name))
        throw UsageError("--program-out: '" + output +
                         "' is a file of the program itself; give the corrected program another "
                         "name or folder");
  if (has_dat) check_dat_of_output(command, program, files.out);
}

// A name that is misspelt says nothing of the program.
void warn_of_unused(Command& command, const RobotProgram& program, const KnownFrames& known) {
  std::vector<std::string> names;
  for (const ProgramFrame& frame : program.frames) names.push_back(frame.name);
  for (const auto& [name, pose] : known)
    if (std::ranges::none_of(
            names, [&](const std::string& used) { return lower_case(used) == lower_case(name); }))
      command.warn(fmt::format("--frame: no move of {} uses '{}'; its frames and tools are {}",
                               program.texts[0].name, name,
                               names.empty() ? "none" : fmt::to_string(fmt::join(names, ", "))));
}

}  // namespace

std::string kinds_of_programs(const std::string& with_data_list) {
  std::vector<std::string> kinds;
  for (const Dialect* dialect : dialects()) {
    const DialectFacts& facts = dialect->facts();
    kinds.push_back(facts.maker + " " + lower_case(facts.endings.front()) +
                    (facts.data_list.empty() ? "" : with_data_list));
  }
  return fmt::format("{}", fmt::join(kinds, ", "));
}

Option add_robot_program(Command& command, RobotProgramFiles& files) {
  std::vector<std::string> names;
  for (const Dialect* dialect : dialects()) names.push_back(dialect->facts().name);
  const Option program =
      command.file("--program", files.path,
                   "Robot program to correct instead of a file of targets: " + kinds_of_programs());
  program.needs(command
                    .add_output("--program-out", files.out,
                                "Write the corrected program here, a .dat beside it")
                    .needs(program));
  command.file("--dat", files.dat, "The .dat of a KUKA program; that beside the .src if absent")
      .needs(program);
  add_texts_of_others(command, program, files.with);
  command
      .option("--dialect", files.dialect,
              "Language of the program, if the file name does not show it")
      .check(one_of(names))
      .needs(program);
  command
      .option(
          "--frame", files.frames,
          "Values of a frame or tool that the program only names, as NAME=x,y,z,a,b,c in mm and "
          "deg: BASE_DATA[1], TOOL_DATA[1], wobj1, UF[1], UT[1]; may be given several times")
      .check(frame_check());
  return program;
}

std::vector<ProgramText> read_others(Command& command, const std::vector<ProgramText>& own,
                                     const std::vector<std::string>& with) {
  std::vector<ProgramText> others;
  for (const std::string& path : with)
    for (const ProgramText& text : command.read_program_folder(path)) {
      const auto is_this = [&](const ProgramText& other) {
        return same_file(other.name, text.name);
      };
      if (std::ranges::none_of(own, is_this) && std::ranges::none_of(others, is_this))
        others.push_back(text);
    }
  return others;
}

RobotProgram parse_with(const Dialect& dialect, std::vector<ProgramText> own,
                        const std::vector<ProgramText>& others, const KnownFrames& known,
                        TargetParts parts) {
  std::vector<ProgramText> project = own;
  project.insert(project.end(), others.begin(), others.end());
  ProgramNeighbours neighbours = neighbours_in(dialect, project, known)[own[0].name];
  std::vector<ProgramText> declared = what_others_declare(dialect, own, others);
  return parse_program(dialect, std::move(own), known, parts, std::move(declared),
                       std::move(neighbours));
}

void add_texts_of_others(Command& command, const Option& program, std::vector<std::string>& with) {
  command
      .option("--with", with,
              "A file that declares points, tools or frames that the program uses, or a folder "
              "with such files: $config.dat and other data lists of KUKA, modules of ABB, "
              "POSREG.VA and SYSFRAME.VA of FANUC, RC.PRM, TOOL.CND and UFRAME.CND of Yaskawa, a "
              "backup; may be given several times")
      .one_each()
      .needs(program);
}

KnownFrames known_frames(const RobotProgramFiles& files) {
  KnownFrames known;
  for (const std::string& frame : files.frames)
    if (!known.insert(frame_from_text(frame)).second)
      throw UsageError("--frame: '" + frame + "' gives a frame that is given already");
  return known;
}

RobotProgram read_robot_program(Command& command, const RobotProgramFiles& files) {
  if (command.input != "-")
    throw UsageError("'" + command.input +
                     "' and --program are given; correct one of them at a time");
  const Dialect& dialect = dialect_of(files);
  const bool has_data_list = !dialect.facts().data_list.empty();
  if (!files.dat.empty() && !has_data_list)
    throw UsageError("--dat: only a KUKA program has a .dat");
  const KnownFrames known = known_frames(files);
  if (const auto other = dialect_of_file(files.out); other && other != &dialect)
    throw UsageError("--program-out: '" + files.out + "' ends as a program of " +
                     other->facts().name + " does, and " + files.path + " is one of " +
                     dialect.facts().name + "; give it an ending of this language");
  std::vector<ProgramText> texts = command.read_program_texts(files.path, files.dat, has_data_list);
  refuse_corrected_texts(texts);
  refuse_cut_off(dialect, texts);
  const std::vector<ProgramText> others = read_others(command, texts, files.with);
  RobotProgram program = parse_with(dialect, std::move(texts), others, known);
  warn_of_unused(command, program, known);
  refuse_corrected_points(program);
  refuse_outputs(command, program, files);
  return program;
}

std::string dat_of_output(const RobotProgram& program, const std::string& out) {
  if (same_file(out, "/dev/null")) return out;
  if (!has_name(out))
    throw UsageError(
        "--program-out: the program has a .dat, which needs a file beside it; name a file");
  return dat_beside(out, program.texts[1].name);
}

namespace {

// What an output would replace. It is no input: a Source would keep it from being written.
std::string text_there(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace

void check_dat_of_output(const Command& command, const RobotProgram& program,
                         const std::string& out) {
  const std::string dat = dat_of_output(program, out);
  command.check_derived_output(dat);
  if (!fs::is_regular_file(dat)) return;
  std::vector<ProgramText> there{{dat, text_there(dat)}};
  std::vector<std::string> unchanged;
  for (size_t i = 0; i < program.own_texts; ++i) unchanged.push_back(program.texts[i].text);
  rename_as_file(program, out, unchanged);
  if (there[0].text.empty() || there[0].text == unchanged[1]) return;
  if (fs::is_regular_file(out)) there.push_back({out, text_there(out)});
  for (const Corrector by : {Corrector::compensate, Corrector::mirror})
    if (find_correction_mark(there, by)) return;
  throw UsageError("--program-out: beside it stands " + dat +
                   ", which the .dat of the corrected program would replace, and armtrue did not "
                   "write it; give another name or folder, or remove it");
}

void refuse_illegal_name(const RobotProgram& program, const std::string& out) {
  if (!has_name(out)) return;
  const std::string wrong = why_illegal_name(*program.dialect, fs::path(out).stem().string());
  if (!wrong.empty()) throw UsageError("--program-out: " + wrong);
}

void rename_as_file(const RobotProgram& program, const std::string& out,
                    std::vector<std::string>& texts) {
  if (has_name(out)) rename(program, fs::path(out).stem().string(), texts);
}

// The .src is the last, because it refers to the points of the .dat.
void write_program_texts(const RobotProgram& program, const std::vector<std::string>& texts,
                         const std::string& out) {
  std::vector<Product> products;
  if (program.own_texts > 1)
    products.push_back({dat_of_output(program, out), bytes_of_text(program.texts[1], texts[1])});
  products.push_back({out, bytes_of_text(program.texts[0], texts[0])});
  write_outputs(products);
}

bool write_robot_program(Command& command, const RobotProgram& program,
                         const ProgramCommands& commands,
                         const std::vector<ProgramPointBetween>& between,
                         const RobotProgramFiles& files) {
  RewrittenProgram rewritten = rewrite(program, commands.list, between, Corrector::compensate);
  mark_corrected(program, Corrector::compensate, rewritten.texts);
  rename_as_file(program, files.out, rewritten.texts);
  for (const auto& list : {program.warnings, commands.warnings, rewritten.warnings})
    warn_of_all(command, list);
  bool is_followed =
      program.warnings.empty() && commands.warnings.empty() && rewritten.warnings.empty();
  if (const auto lost = moves_of(between) - rewritten.inserted; lost > 0) {
    command.warn(
        fmt::format("{}: {} not inserted, because an end of their move stays as "
                    "programmed",
                    program.texts[0].name, counted(lost, "point")));
    is_followed = false;
  }
  command.tell(fmt::format("{}: {} changed, {} inserted, {} left alone\n", program.texts[0].name,
                           counted(rewritten.changed, "point"), rewritten.inserted,
                           counted(program.left_alone, "move")));
  write_program_texts(program, rewritten.texts, files.out);
  return is_followed;
}

}  // namespace armtrue::app
