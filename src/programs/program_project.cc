#include "armtrue/programs/program_project.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "programs/fanuc_registers.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"
#include "programs/text_edit.h"

namespace armtrue {
namespace {

std::string folder_of(const std::string& path) {
  const size_t slash = path.rfind('/');
  return slash == std::string::npos ? "" : path.substr(0, slash + 1);
}

std::string name_in_folder(const std::string& path) {
  return upper(std::string_view(path).substr(folder_of(path).size()));
}

bool is_config(const std::string& path) { return name_in_folder(path) == "$CONFIG.DAT"; }

std::string ending_of(const std::string& path) {
  const size_t point = path.rfind('.');
  return point == std::string::npos ? "" : upper(std::string_view(path).substr(point));
}

// DEFDAT $CONFIG, DEFDAT NAME PUBLIC
bool gives_to_others(const ProgramText& text) {
  if (is_config(text.name)) return true;
  for (size_t begin = 0; begin < text.text.size();) {
    const size_t end = std::min(text.text.find('\n', begin), text.text.size());
    TextCursor cursor(text.text, begin, end);
    begin = end + 1;
    if (cursor.take_name() != "DEFDAT") continue;
    return cursor.take_name() == "$CONFIG" || cursor.take_name() == "PUBLIC";
  }
  return false;
}

// What the source of another program gives values to, line by line: all that counts of it.
ProgramText assignments_of(const ProgramText& source) {
  ProgramText result{source.name, "DEF OTHER()\n"};
  for (size_t begin = 0; begin < source.text.size();) {
    const size_t end = std::min(source.text.find('\n', begin), source.text.size());
    TextCursor cursor(source.text, begin, end);
    const std::string word = cursor.take_name();
    const bool is_of_inline_form = word == "PDAT_ACT" || word == "LDAT_ACT" || word == "FDAT_ACT";
    if (!word.empty() && word[0] != '$' && !is_of_inline_form &&
        (cursor.next() == '=' || cursor.next() == '[' || cursor.next() == '.'))
      result.text += source.text.substr(begin, end - begin) + "\n";
    begin = end + 1;
  }
  return result;
}

ProgramText lines_with(const ProgramText& program, std::string_view word) {
  ProgramText result{program.name, ""};
  for (size_t begin = 0; begin < program.text.size();) {
    const size_t end = std::min(program.text.find('\n', begin), program.text.size());
    const std::string line = program.text.substr(begin, end - begin);
    if (upper(line).find(word) != std::string::npos) result.text += line + "\n";
    begin = end + 1;
  }
  return result;
}

// The folder of the controller of a KUKA program, with the slash at its end.
std::string controller_of(const std::vector<ProgramText>& project, const std::string& path) {
  std::string folder = folder_of(path);
  while (!folder.empty()) {
    const bool has_config = std::ranges::any_of(project, [&](const ProgramText& text) {
      return is_config(text.name) && text.name.starts_with(folder);
    });
    if (has_config) break;
    folder = folder_of(folder.substr(0, folder.size() - 1));
  }
  return folder;
}

// The folder of the task of an ABB module, or that of the module.
std::string task_of(const std::string& path) {
  for (size_t slash = path.find('/'); slash != std::string::npos;
       slash = path.find('/', slash + 1)) {
    const std::string folder = path.substr(0, slash);
    if (name_in_folder(folder).starts_with("TASK")) return folder + "/";
  }
  return folder_of(path);
}

char comment_of(Dialect dialect) {
  return dialect == Dialect::krl ? ';' : dialect == Dialect::urscript ? '#' : '!';
}

// Of a text that no ending of its own tells: a KUKA data list.
Dialect dialect_of(const std::string& path) {
  return dialect_of_file(path).value_or(Dialect::krl);
}

// The names that a text holds outside of comments, in capitals.
std::set<std::string> names_in(Dialect dialect, const std::string& text) {
  std::set<std::string> names;
  const std::string plain = masked(text, comment_of(dialect), "\"");
  each_word(plain, {0, 0, plain.size()},
            [&](const std::string& word, size_t, const TextCursor&) { names.insert(word); });
  return names;
}

// XP1 of XP1[3], p10 of p10{2}.
std::string plain_name(const std::string& name) {
  return TextCursor(name, 0, name.size()).take_name();
}

class ProjectRewriter {
 public:
  ProjectRewriter(std::vector<ProjectProgram> programs, const std::vector<ProgramText>& project,
                  std::optional<Corrector> by)
      : programs_(std::move(programs)), by_(by) {
    for (size_t i = 0; i < programs_.size(); ++i)
      for (size_t k = 0; k < programs_[i].program.own_texts; ++k)
        program_of_text_[programs_[i].program.texts[k].name] = i;
    for (const ProgramText& text : project) {
      texts_[text.name] = &text.text;
      names_[text.name] = names_in(dialect_of(text.name), text.text);
    }
  }

  RewrittenProject run() {
    for (size_t i = 0; i < programs_.size(); ++i) claim(i);
    decide();
    for (size_t i = 0; i < programs_.size(); ++i) {
      result_.programs.push_back(rewrite(programs_[i].program, programs_[i].commands, {}, by_));
      take_edits(i);
    }
    for (const auto& [name, edits] : edits_) {
      std::vector<TextEdit> list;
      for (const auto& [place, edit] : edits) list.push_back(edit);
      std::string text = apply_edits(*texts_.at(name), list, 0);
      if (by_) mark_corrected(dialect_of(name), *by_, text);
      result_.texts[name] = std::move(text);
    }
    return std::move(result_);
  }

 private:
  using Key = std::tuple<size_t, size_t, size_t>;  // of an edit: begin, end, order of insertions
  using Place = std::pair<std::string, size_t>;  // text, begin of the declaration
  // What the programs need of a shared point.
  struct Shared {
    std::string name;
    int line = 0;
    std::set<size_t> programs;
    std::vector<std::pair<size_t, int>> points;  // program and its point
    std::vector<std::string> changes;            // by each of them, as one text
    bool must_stay = false, is_changed = false;
  };

  // As if every shared point could be written where it is declared.
  void claim(size_t index) {
    RobotProgram& program = programs_[index].program;
    std::vector<size_t> points;
    for (size_t i = 0; i < program.points.size(); ++i)
      if (std::exchange(program.points[i].is_of_others, false) && !program.points[i].is_expression)
        points.push_back(i);
    if (points.empty()) return;
    const RewrittenProgram rewritten = rewrite(program, programs_[index].commands, {}, by_);
    for (const size_t i : points) {
      const ProgramPoint& point = program.points[i];
      Shared& shared = shared_[{program.texts[point.text].name, point.begin}];
      shared.name = point.name;
      shared.line = point.line;
      shared.programs.insert(index);
      shared.points.emplace_back(index, static_cast<int>(i));
      shared.must_stay |= point.is_shared;
      std::string changes;
      for (const TextEdit& edit : rewritten.edits) {
        if (edit.file == point.text && edit.begin >= point.begin && edit.end <= point.end)
          changes += std::to_string(edit.begin) + " " + edit.text + "\n";
        for (const ProgramTarget& target : program.targets)
          if (target.point == static_cast<int>(i) && edit.file == 0 && edit.begin == target.begin &&
              edit.end == target.end)
            shared.must_stay = shared.is_changed = true;  // its moves need several numbers
      }
      shared.is_changed |= !changes.empty();
      shared.changes.push_back(changes);
    }
  }

  void decide() {
    for (auto& [place, shared] : shared_) {
      const std::vector<std::string> others = others_that_name(place.first, shared);
      const bool is_agreed =
          std::ranges::all_of(shared.changes, [&](const std::string& changes) {
            return changes == shared.changes.front();
          });
      const bool is_written = is_agreed && !shared.must_stay && others.empty();
      for (const auto& [program, point] : shared.points)
        programs_[program].program.points[point].is_of_others = !is_written;
      if (!shared.is_changed) continue;
      std::vector<std::string> users;
      for (const size_t program : shared.programs)
        users.push_back(programs_[program].program.texts[0].name);
      users.insert(users.end(), others.begin(), others.end());
      result_.shared.push_back({shared.name, place.first, shared.line, users, is_written});
    }
  }

  // Texts that name a point, and whose moves do not say what they need of it.
  std::vector<std::string> others_that_name(const std::string& declaring,
                                            const Shared& shared) const {
    const std::string name = plain_name(shared.name);
    std::vector<std::string> others;
    for (const auto& [text, names] : names_) {
      if (text == declaring || is_of_controller(text) || !names.contains(name)) continue;
      const auto program = program_of_text_.find(text);
      if (program != program_of_text_.end() && shared.programs.contains(program->second)) continue;
      if (!declares_itself(text, name, declaring)) others.push_back(text);
    }
    return others;
  }

  // A KUKA program whose own .dat has the name means that.
  bool declares_itself(const std::string& text, const std::string& name,
                       const std::string& declaring) const {
    if (ending_of(text) == ".DAT") return true;  // only data
    const std::string begin = text.substr(0, text.size() - ending_of(text).size());
    for (const char* ending : {".dat", ".DAT", ".Dat"})
      if (const auto dat = names_.find(begin + ending);
          dat != names_.end() && dat->first != declaring && dat->second.contains(name))
        return ending_of(text) == ".SRC" || ending_of(text) == ".SUB";
    return false;
  }

  void take_edits(size_t index) {
    const RobotProgram& program = programs_[index].program;
    for (const TextEdit& edit : result_.programs.back().edits) {
      const std::string& name = program.texts[edit.file].name;
      std::map<Key, TextEdit>& of_text = edits_[name];
      // Insertions at one place keep their order; a shared declaration changes once.
      const bool is_insertion = edit.begin == edit.end;
      const Key key{edit.begin, edit.end, is_insertion ? 1 + of_text.size() : 0};
      of_text.try_emplace(key, TextEdit{0, edit.begin, edit.end, edit.text});
    }
  }

  std::vector<ProjectProgram> programs_;
  std::optional<Corrector> by_;
  std::map<std::string, size_t> program_of_text_;
  std::map<std::string, const std::string*> texts_;
  std::map<std::string, std::set<std::string>> names_;
  std::map<Place, Shared> shared_;
  std::map<std::string, std::map<Key, TextEdit>> edits_;  // of each text
  RewrittenProject result_;
};

}  // namespace

// It sets XHOME where nobody has taught it, of deltas and palletizers.
bool is_of_controller(const std::string& path) { return name_in_folder(path) == "BAS.SRC"; }

std::vector<ProgramText> what_others_declare(Dialect dialect,
                                             const std::vector<ProgramText>& others) {
  std::vector<ProgramText> result;
  for (const ProgramText& text : others) {
    const std::string ending = ending_of(text.name);
    if (dialect == Dialect::krl) {
      if (ending == ".DAT" && gives_to_others(text)) result.push_back(text);
      if ((ending == ".SRC" || ending == ".SUB") && !is_of_controller(text.name))
        result.push_back(assignments_of(text));
    } else if (dialect == Dialect::rapid && dialect_of_file(text.name) == Dialect::rapid) {
      result.push_back(text);
    } else if (dialect == Dialect::fanuc && ending == ".LS") {
      result.push_back(lines_with(text, "PR["));
    } else if (dialect == Dialect::fanuc && is_fanuc_listing(text.text)) {
      result.push_back(text);
    }
  }
  return result;
}

std::vector<ProgramText> texts_of_others(Dialect dialect, const std::vector<ProgramText>& project,
                                         const std::string& path) {
  const bool is_rapid = dialect == Dialect::rapid;
  const std::string folder = dialect == Dialect::krl ? controller_of(project, path)
                             : is_rapid              ? task_of(path)
                                                     : folder_of(path);
  const std::string own = upper(path.substr(0, path.size() - ending_of(path).size()));
  std::vector<ProgramText> others;
  for (const ProgramText& text : project) {
    const std::string name = upper(text.name);
    const bool is_own = dialect == Dialect::krl ? name == own + ".DAT" || name == own + ".SRC"
                                                : text.name == path;
    const bool is_of_task = folder != folder_of(path) || folder_of(text.name) == folder;
    if (text.name.starts_with(folder) && !is_own && (is_of_task || !is_rapid))
      others.push_back(text);
  }
  return what_others_declare(dialect, others);
}

RewrittenProject rewrite_project(std::vector<ProjectProgram> programs,
                                 const std::vector<ProgramText>& project,
                                 std::optional<Corrector> by) {
  return ProjectRewriter(std::move(programs), project, by).run();
}

}  // namespace armtrue
