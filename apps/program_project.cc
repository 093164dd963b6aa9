#include "program_project.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "armtrue/io/archive.h"
#include "armtrue/io/output.h"
#include "armtrue/io/program_io.h"
#include "armtrue/programs/corrected_already.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/programs/program_project.h"
#include "armtrue/text/edit_distance.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"

namespace armtrue::app {
namespace {

namespace fs = std::filesystem;

// A row of the table.
struct ProgramRow {
  std::string name;
  CorrectedMoves moves;
};

// A field of a CSV file.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c == '\n' ? ' ' : c);
  return quoted + '"';
}

std::string table_of(const std::vector<ProgramRow>& rows) {
  std::string table = "program,moves,corrected,left,why\n";
  for (const ProgramRow& row : rows) {
    std::string why;
    for (const auto& [reason, count] : row.moves.reasons)
      why += fmt::format("{}{}: {}", why.empty() ? "" : "; ", count, reason);
    table += fmt::format("{},{},{},{},{}\n", field(row.name), row.moves.all, row.moves.corrected,
                         row.moves.all - row.moves.corrected, field(why));
  }
  return table;
}

// Files of a folder that are no texts of programs, such as .pgf, named from the folder on.
std::vector<std::string> files_beside_texts(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder, none))
    if (entry.is_regular_file(none) && !is_program_text(entry.path().string()))
      names.push_back(entry.path().lexically_relative(folder).generic_string());
  return names;
}

class Project {
 public:
  Project(Command& command, const ProjectFiles& files, const KnownFrames& known)
      : command_(command), files_(files), known_(known) {
    if (fs::is_directory(files.folder)) {
      for (ProgramText& text : command.read_program_folder(files.folder)) {
        text.name = fs::path(text.name).lexically_relative(files.folder).generic_string();
        texts_.push_back(std::move(text));
      }
      beside_texts_ = files_beside_texts(files.folder);
    } else {
      archive_.emplace(files.folder);
      texts_ = command.read_program_archive(*archive_, files.folder);
    }
    refuse_corrected_texts(texts_);
    for (const Dialect* dialect : dialects()) {
      neighbours_.merge(neighbours_in(*dialect, texts_, known_));
      others_.try_emplace(dialect, *dialect, texts_);
    }
    for (const ProgramText& text : texts_) by_name_[text.name] = &text;
  }

  bool correct(const CommandsFor& commands_for) {
    commands_for_ = commands_for;
    for (const ProgramText& text : texts_) correct_once(text);
    put_in_order();
    warn_of_several_arms();
    if (rows_.empty())
      throw InputError(files_.folder +
                       ": none of its programs has a move to a point with plain "
                       "numbers");
    if (programs_.empty() && !why_not_.empty())
      throw InputError(fmt::format("{}: none of its programs can be corrected: {}", files_.folder,
                                   why_not_.begin()->second));
    write();
    write_output(command_.output, table_of(rows_));
    return std::ranges::all_of(
        rows_, [](const ProgramRow& row) { return row.moves.corrected == row.moves.all; });
  }

 private:
  // A program that others call may ask for these first.
  void correct_once(const ProgramText& text) {
    if (const auto dialect = dialect_of_file(text.name); dialect && !is_of_controller(text.name))
      if (begun_.insert(text.name).second) correct(*dialect, text);
  }

  void correct(const Dialect& dialect, const ProgramText& text) {
    std::vector<ProgramText> own{text};
    if (!dialect.facts().data_list.empty())
      if (const ProgramText* const dat = dat_of(text.name)) own.push_back(*dat);
    RobotProgram program;
    try {
      refuse_cut_off(dialect, own);
      program = parse_program(dialect, own, known_, TargetParts::pose,
                              others_.at(&dialect).of(text.name), neighbours_[text.name]);
    } catch (const NoTargets& error) {
      if (error.why_left_alone.empty()) return;  // it does not move the arm
      command_.warn(error.what());
      rows_.push_back({text.name, moves_left_alone(error.why_left_alone)});
      return;
    } catch (const InputError& error) {
      return stays(text.name, {}, error);
    }
    try {
      leave_frames_of_callers(program);
      warn_of_all(command_, program.warnings);
      program.warnings.clear();
      refuse_corrected_points(program);
      ProjectCommands found = commands_for_(program, [&] { return postures_at_calls(program); });
      warn_of_all(command_, program.warnings);
      warn_of_all(command_, found.commands.warnings);
      rows_.push_back({text.name, found.moves});
      corrected_[text.name] = programs_.size();
      programs_.push_back({std::move(program), std::move(found.commands.list)});
    } catch (const CorrectedAlready&) {
      throw;
    } catch (const InputError& error) {
      stays(text.name, program, error);
    }
  }

  // In that of the texts.
  void put_in_order() {
    std::ranges::stable_sort(rows_, {},
                             [&](const ProgramRow& row) { return by_name_.at(row.name); });
    std::ranges::stable_sort(programs_, {}, [&](const ProjectProgram& program) {
      return by_name_.at(program.program.texts[0].name);
    });
  }

  // Texts that name a routine of a program may call it. None of the postures counts if one of
  // these is not known.
  PosturesAtCalls postures_at_calls(const RobotProgram& called) {
    PosturesAtCalls all;
    for (const ProgramText& text : texts_) {
      if (text.name == called.texts[0].name || dialect_of_file(text.name) != called.dialect ||
          is_of_controller(text.name) || !names_one(text.text, called.routines))
        continue;
      correct_once(text);
      const auto caller = corrected_.find(text.name);
      if (caller == corrected_.end()) return {};
      const std::vector<ProgramCall> calls = programs_[caller->second].program.calls_of_others;
      for (const ProgramCall& call : calls) {
        if (!called.routines.contains(call.routine)) continue;
        if (!add_postures_before(caller->second, call.node, all.angles)) return {};
        all.callers +=
            fmt::format("{}{}:{}", all.callers.empty() ? "" : ", ", text.name, call.line);
      }
    }
    return all;
  }

  // Of the moves before a node of a program, and of the programs that it calls between. Returns
  // whether all are known.
  bool add_postures_before(size_t index, int node, std::vector<JointVector>& postures) {
    std::map<int, size_t> targets;
    std::map<int, std::string> calls;
    const RobotProgram& program = programs_[index].program;
    for (size_t k = 0; k < program.targets.size(); ++k) targets[program.targets[k].node] = k;
    for (const ProgramCall& call : program.calls_of_others) calls[call.node] = call.routine;
    const std::vector<std::vector<int>> ways = program.ways;  // programs_ may grow
    std::set<int> seen;
    std::vector<int> open{node};
    while (!open.empty()) {
      const int at = open.back();
      open.pop_back();
      if (ways[at].empty()) return false;  // the program begins
      for (const int before : ways[at]) {
        if (!seen.insert(before).second) continue;
        if (const auto target = targets.find(before); target != targets.end()) {
          postures.push_back(programs_[index].commands[target->second].programmed);
          continue;
        }
        if (const auto call = calls.find(before);
            call != calls.end() && !add_postures_of(call->second, postures))
          return false;
        open.push_back(before);
      }
    }
    return true;
  }

  // All of the program that has the name of a routine, if it moves the arm.
  bool add_postures_of(const std::string& routine, std::vector<JointVector>& postures) {
    for (const ProgramText& text : texts_) {
      if (upper_case(fs::path(text.name).stem().string()) != routine ||
          !dialect_of_file(text.name) || is_of_controller(text.name))
        continue;
      correct_once(text);
      const auto called = corrected_.find(text.name);
      if (called == corrected_.end()) return false;
      for (const ProgramCommand& command : programs_[called->second].commands)
        postures.push_back(command.programmed);
    }
    return true;
  }

  static bool names_one(const std::string& text, const std::set<std::string>& names) {
    const std::string capitals = upper_case(text);
    return std::ranges::any_of(names, [&](const std::string& name) {
      return !name.empty() && capitals.find(name) != std::string::npos;
    });
  }

  // One model is given, and each of them may move another arm.
  void warn_of_several_arms() {
    std::set<std::string> folders;
    for (const ProgramRow& row : rows_)
      if (const std::string folder = others_.at(dialect_of_file(row.name)).controller_of(row.name);
          !folder.empty())
        folders.insert(folder);
    if (folders.size() < 2) return;
    std::string names;
    for (const std::string& folder : folders) names += (names.empty() ? "" : ", ") + folder;
    command_.warn(fmt::format(
        "{}: has the programs of {} controllers or tasks ({}); all are corrected for the one "
        "arm of --robot and --controller; if they move several, give --project one of these "
        "folders",
        files_.folder, folders.size(), names));
  }

  void stays(const std::string& name, const RobotProgram& program, const InputError& error) {
    command_.warn(fmt::format("{}; the program stays as it is", error.what()));
    rows_.push_back({name, moves_left_alone(program, error.what())});
    why_not_[by_name_.at(name)] = error.what();
  }

  const ProgramText* dat_of(const std::string& src) const {
    for (const char* ending : {".dat", ".DAT", ".Dat"}) {
      const std::string name = fs::path(src).replace_extension(ending).generic_string();
      if (const auto dat = by_name_.find(name); dat != by_name_.end()) return dat->second;
    }
    return nullptr;
  }

  // A subprogram that states neither has those of whoever calls it: nobody knows, unless they are
  // given.
  void leave_frames_of_callers(RobotProgram& program) const {
    const DialectFacts& facts = program.dialect->facts();
    if (!facts.has_frames_of_caller) return;
    std::map<size_t, std::string> why;
    std::set<size_t> left;  // an arc goes with either of its points
    for (size_t k = 0; k < program.targets.size(); ++k) {
      const ProgramTarget& target = program.targets[k];
      if (target.kind != TargetKind::cartesian) continue;
      if (target.base < 0 && !files_.has_base)
        why[k] = why_left_to_caller(facts.frame, "--base");
      else if (target.tool < 0 && !files_.has_tool)
        why[k] = why_left_to_caller(facts.tool, "--tool");
      if (!why.contains(k)) continue;
      for (const size_t of_move : targets_of_move(program, k)) left.insert(of_move);
    }
    if (why.empty()) return;
    if (left.size() == program.targets.size())
      throw InputError(fmt::format("{}:{}: {}", program.texts[0].name, program.targets[0].line,
                                   why.begin()->second));
    leave_alone(program, why);
  }

  static std::string why_left_to_caller(const std::string& what, const char* option) {
    return fmt::format(
        "the program states no {} for this move, which is that of its caller; state it in the "
        "program, or give it for all such programs: {}",
        what, option);
  }

  // All texts, and all other files of the folder or archive: those that are not corrected as they
  // are.
  void write() {
    const RewrittenProject rewritten =
        rewrite_project(std::move(programs_), texts_, Corrector::compensate);
    for (const RewrittenProgram& program : rewritten.programs)
      warn_of_all(command_, program.warnings);
    for (const SharedPoint& point : rewritten.shared) tell(point);
    std::map<std::string, std::string> changed;
    for (const ProgramText& text : texts_)
      if (const auto now = rewritten.texts.find(text.name); now != rewritten.texts.end())
        changed[text.name] = bytes_of_text(text, now->second);
    std::string ending;
    if (archive_ && is_archive_name(files_.out, ending)) {
      write_output(files_.out, archive_->with(changed));
    } else {
      write_folder(changed);
    }
    command_.tell(fmt::format("{}: {} of {} changed\n", files_.out,
                              counted(rewritten.texts.size(), "text"), texts_.size()));
  }

  void write_folder(const std::map<std::string, std::string>& changed) {
    std::map<std::string, std::string> all;
    for (const ProgramText& text : texts_) all[text.name] = bytes_of_text(text, text.text);
    if (archive_)
      for (const ArchiveMember& member : archive_->members())
        if (!member.is_folder) all[member.path] = member.content;
    for (const auto& [name, text] : changed) all[name] = text;
    for (const std::string& name : beside_texts_) copy(name);
    std::vector<Product> products;
    for (const auto& [name, text] : all) products.push_back(Product::bytes(place_of(name), text));
    write_outputs(products);
  }

  // Where a text or another file is written; makes its folder.
  std::string place_of(const std::string& name) const {
    const fs::path path = fs::path(files_.out) / name;
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    if (error)
      throw OutputError(fmt::format("{}: the folder cannot be made ({})",
                                    path.parent_path().string(), error.message()));
    return path.string();
  }

  void copy(const std::string& name) const {
    const std::string from = (fs::path(files_.folder) / name).string();
    std::error_code error;
    fs::copy_file(from, place_of(name), error);
    if (error)
      throw OutputError(fmt::format(
          "{}: cannot be copied to {} ({}); make it readable, or remove it from the folder", from,
          files_.out, error.message()));
  }

  void tell(const SharedPoint& point) {
    std::string users;
    constexpr size_t kShown = 5;
    for (size_t i = 0; i < std::min(point.users.size(), kShown); ++i)
      users += (i == 0 ? "" : ", ") + point.users[i];
    if (point.users.size() > kShown)
      users += fmt::format(" and {} more", point.users.size() - kShown);
    command_.warn(fmt::format("{}:{}: {} is a point that other texts may use; {} ({})", point.text,
                              point.line, point.name,
                              point.is_written
                                  ? "it is changed here once, for all its moves"
                                  : "it stays, and each move gets a corrected point of its own",
                              users));
  }

  Command& command_;
  const ProjectFiles& files_;
  const KnownFrames known_;
  std::optional<Archive> archive_;  // in place of a folder
  std::vector<ProgramText> texts_;  // named from the folder on
  std::vector<std::string> beside_texts_;  // other files of the folder
  std::map<std::string, const ProgramText*> by_name_;
  std::map<const Dialect*, TextsOfOthers> others_;
  std::map<std::string, ProgramNeighbours> neighbours_;  // of the programs
  CommandsFor commands_for_;
  std::set<std::string> begun_;              // texts
  std::map<std::string, size_t> corrected_;  // of the text of each of programs_ its index
  std::vector<ProjectProgram> programs_;
  std::vector<ProgramRow> rows_;
  // Why programs cannot be corrected, in the order of the texts.
  std::map<const ProgramText*, std::string> why_not_;
};

void check_folders(const ProjectFiles& files) {
  std::error_code none;
  if (files.out.empty())
    throw UsageError("--project: give --project-out, the folder for the corrected programs");
  std::string kind, out_kind;
  const bool is_folder = fs::is_directory(files.folder, none);
  if (!is_folder && !is_archive_name(files.folder, kind))
    throw InputError(
        files.folder +
        ": is no folder and no archive (.zip, .tar, .tgz); name that of the programs, or "
        "give one program with --program");
  if (is_archive_name(files.out, out_kind) && out_kind != kind)
    throw UsageError(
        fmt::format("--project-out: '{}' is a {} file, and --project {}; name a new "
                    "folder, or a file of the same kind",
                    files.out, out_kind, is_folder ? "is a folder" : "a " + kind + " file"));
  const auto in = fs::weakly_canonical(fs::absolute(files.folder, none), none);
  const auto out = fs::weakly_canonical(fs::absolute(files.out, none), none);
  const auto [end_in, end_out] = std::mismatch(in.begin(), in.end(), out.begin(), out.end());
  if (end_in == in.end() || end_out == out.end())
    throw UsageError("--project-out: '" + files.out +
                     "' and --project lie in one another; name a "
                     "folder beside it");
  const bool is_empty = fs::is_directory(files.out, none) && fs::is_empty(files.out, none);
  if (fs::exists(files.out, none) && !is_empty)
    throw UsageError("--project-out: '" + files.out +
                     "' exists and is not an empty folder; name a new one");
}

}  // namespace

void add_project(Command& command, ProjectFiles& files) {
  const Option project = command.option(
      "--project", files.folder,
      "Folder of robot programs to correct together, such as a backup (KUKA KRC/R1, ABB HOME), or "
      "its "
      "archive (.zip, .tar, .tgz); names are looked up in it as the controller does");
  project.needs(command
                    .option("--project-out", files.out,
                            "Write the folder here, its programs corrected: a new or empty folder; "
                            "of an archive also a new archive of the same kind")
                    .needs(project));
}

bool correct_project(Command& command, const ProjectFiles& project, const RobotProgramFiles& files,
                     const CommandsFor& commands_for) {
  if (command.input != "-")
    throw UsageError("'" + command.input +
                     "' and --project are given; correct one of them at a time");
  if (!files.path.empty())
    throw UsageError("--program and --project are given; correct one of them at a time");
  check_folders(project);
  return Project(command, project, known_frames(files)).correct(commands_for);
}

}  // namespace armtrue::app
