#include "program_project.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "armtrue/io/output.h"
#include "armtrue/programs/program_project.h"
#include "armtrue/text/input_error.h"

namespace armtrue::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLeft = "left alone: ";

// A row of the table.
struct ProgramRow {
  std::string name;
  int moves = 0, corrected = 0;
  std::map<std::string, int> reasons;  // of the moves that are left, with their number
};

// A field of a CSV file.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c == '\n' ? ' ' : c);
  return quoted + '"';
}

// Of `FILE:12: left alone: REASON; also lines 13, 14 and 2 more`.
void add_reasons(const std::vector<std::string>& warnings, ProgramRow& row) {
  for (const std::string& warning : warnings) {
    const size_t at = warning.find(kLeft);
    if (at == std::string::npos) continue;
    std::string reason = warning.substr(at + std::string(kLeft).size());
    int count = 1;
    if (const size_t also = reason.find("; also lines "); also != std::string::npos) {
      const std::string lines = reason.substr(also);
      count += 1 + static_cast<int>(std::ranges::count(lines, ','));
      if (const size_t more = lines.find(" and "); more != std::string::npos)
        count += std::stoi(lines.substr(more + 5));
      reason.resize(also);
    }
    row.reasons[reason.substr(0, reason.find("; "))] += count;
  }
}

std::string table_of(const std::vector<ProgramRow>& rows) {
  std::string table = "program,moves,corrected,left,why\n";
  for (const ProgramRow& row : rows) {
    std::string why;
    for (const auto& [reason, count] : row.reasons)
      why += fmt::format("{}{}: {}", why.empty() ? "" : "; ", count, reason);
    table += fmt::format("{},{},{},{},{}\n", field(row.name), row.moves, row.corrected,
                         row.moves - row.corrected, field(why));
  }
  return table;
}

class Project {
 public:
  Project(Command& command, const ProjectFiles& files, const KnownFrames& known)
      : command_(command), files_(files), known_(known) {
    for (ProgramText& text : command.read_program_folder(files.folder)) {
      text.name = fs::path(text.name).lexically_relative(files.folder).generic_string();
      texts_.push_back(std::move(text));
    }
  }

  bool correct(const std::function<ProgramCommands(const RobotProgram&)>& commands_for) {
    for (const ProgramText& text : texts_)
      if (const auto dialect = dialect_of_file(text.name)) correct(*dialect, text, commands_for);
    if (rows_.empty())
      throw InputError(files_.folder + ": none of its programs has a move to a point with plain "
                       "numbers");
    write();
    write_output(command_.output, table_of(rows_));
    return std::ranges::all_of(rows_, [](const ProgramRow& row) {
      return row.moves == row.corrected && row.reasons.empty();
    });
  }

 private:
  void correct(Dialect dialect, const ProgramText& text,
               const std::function<ProgramCommands(const RobotProgram&)>& commands_for) {
    std::vector<ProgramText> own{text};
    if (dialect == Dialect::krl)
      if (const ProgramText* const dat = dat_of(text.name)) own.push_back(*dat);
    ProgramRow row{text.name, 0, 0, {}};
    RobotProgram program;
    try {
      program = parse_program(dialect, own, known_, TargetParts::pose,
                              texts_of_others(dialect, texts_, text.name));
    } catch (const InputError& error) {
      add_reasons({error.what()}, row);
      if (row.reasons.empty()) return;  // it does not move the arm
      for (const auto& [reason, count] : row.reasons) row.moves += count;
      command_.warn(error.what());
      rows_.push_back(row);
      return;
    }
    const auto targets = std::ranges::count_if(program.targets, [](const ProgramTarget& target) {
      return target.motion != MotionKind::via;
    });
    row.moves = static_cast<int>(targets) + program.left_alone;
    add_reasons(program.warnings, row);
    for (const std::string& warning : program.warnings) command_.warn(warning);
    try {
      refuse_frames_of_callers(program);
      ProgramCommands commands = commands_for(program);
      for (const std::string& warning : commands.warnings) command_.warn(warning);
      for (size_t k = 0; k < program.targets.size(); ++k) {
        if (program.targets[k].motion == MotionKind::via) continue;
        if (commands.list[k].is_corrected)
          ++row.corrected;
        else
          ++row.reasons["the correction is larger than --max-mm, or not possible"];
      }
      programs_.push_back({std::move(program), std::move(commands.list)});
    } catch (const InputError& error) {
      row.reasons[error.what()] += static_cast<int>(targets);
      command_.warn(fmt::format("{}; the program stays as it is", error.what()));
    }
    rows_.push_back(row);
  }

  const ProgramText* dat_of(const std::string& src) const {
    for (const char* ending : {".dat", ".DAT", ".Dat"}) {
      const std::string name = fs::path(src).replace_extension(ending).generic_string();
      const auto dat = std::ranges::find(texts_, name, &ProgramText::name);
      if (dat != texts_.end()) return &*dat;
    }
    return nullptr;
  }

  // A subprogram of KUKA that states neither has the $BASE and $TOOL of whoever calls it.
  void refuse_frames_of_callers(const RobotProgram& program) const {
    if (program.dialect != Dialect::krl) return;
    for (const ProgramTarget& target : program.targets)
      if (target.kind == TargetKind::cartesian && (target.base < 0 || target.tool < 0))
        throw InputError(fmt::format(
            "{}:{}: the program states no {} for this move, which is that of its caller; state it "
            "in the program, or correct it alone (--program) with --base and --tool",
            program.texts[0].name, target.line, target.base < 0 ? "$BASE" : "$TOOL"));
  }

  // All texts: those that are not corrected as they are.
  void write() {
    const RewrittenProject rewritten = rewrite_project(programs_, texts_);
    for (const RewrittenProgram& program : rewritten.programs)
      for (const std::string& warning : program.warnings) command_.warn(warning);
    for (const SharedPoint& point : rewritten.shared) tell(point);
    std::vector<Product> products;
    for (const ProgramText& text : texts_) {
      const auto changed = rewritten.texts.find(text.name);
      const std::string path = (fs::path(files_.out) / text.name).string();
      products.push_back({path, changed == rewritten.texts.end() ? text.text : changed->second});
      std::error_code error;
      fs::create_directories(fs::path(path).parent_path(), error);
      if (error)
        throw OutputError(fmt::format("{}: the folder cannot be made ({})",
                                      fs::path(path).parent_path().string(), error.message()));
    }
    write_outputs(products);
    command_.tell(fmt::format("{}: {} texts of {} changed\n", files_.out, rewritten.texts.size(),
                              texts_.size()));
  }

  void tell(const SharedPoint& point) {
    std::string users;
    constexpr size_t kShown = 5;
    for (size_t i = 0; i < std::min(point.users.size(), kShown); ++i)
      users += (i == 0 ? "" : ", ") + point.users[i];
    if (point.users.size() > kShown)
      users += fmt::format(" and {} more", point.users.size() - kShown);
    command_.warn(fmt::format(
        "{}:{}: {} is a point that other texts may use; {} ({})", point.text, point.line,
        point.name,
        point.is_written ? "it is changed here once, for all its moves"
                         : "it stays, and each move gets a corrected point of its own",
        users));
  }

  Command& command_;
  const ProjectFiles& files_;
  const KnownFrames known_;
  std::vector<ProgramText> texts_;  // named from the folder on
  std::vector<ProjectProgram> programs_;
  std::vector<ProgramRow> rows_;
};

void check_folders(const ProjectFiles& files) {
  std::error_code none;
  if (files.out.empty())
    throw UsageError("--project: give --project-out, the folder for the corrected programs");
  if (!fs::is_directory(files.folder, none))
    throw InputError(files.folder +
                     ": is no folder; name that of the programs, or give one program with "
                     "--program");
  const auto in = fs::weakly_canonical(files.folder, none);
  const auto out = fs::weakly_canonical(files.out, none);
  const auto [end_in, end_out] = std::mismatch(in.begin(), in.end(), out.begin(), out.end());
  if (end_in == in.end() || end_out == out.end())
    throw UsageError("--project-out: '" + files.out + "' and --project lie in one another; name a "
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
      "Folder of robot programs to correct together, such as a backup (KUKA KRC/R1, ABB HOME); "
      "names are looked up in it as the controller does");
  project.needs(command
                    .option("--project-out", files.out,
                            "Write the texts of the folder here, corrected: a new or empty folder")
                    .needs(project));
}

bool correct_project(Command& command, const ProjectFiles& project, const RobotProgramFiles& files,
                     const std::function<ProgramCommands(const RobotProgram&)>& commands_for) {
  if (command.input != "-")
    throw UsageError("'" + command.input +
                     "' and --project are given; correct one of them at a time");
  if (!files.path.empty())
    throw UsageError("--program and --project are given; correct one of them at a time");
  check_folders(project);
  return Project(command, project, known_frames(files)).correct(commands_for);
}

}  // namespace armtrue::app
