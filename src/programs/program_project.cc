#include "armtrue/programs/program_project.h"

#include <algorithm>
#include <set>
#include <tuple>

#include "programs/path_name.h"
#include "programs/routine_copies.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"
#include "programs/text_edit.h"

namespace armtrue {
namespace {

// The names that a text holds outside of comments, in capitals.
std::set<std::string> names_in(const std::string& name, const std::string& text) {
  std::set<std::string> names;
  const std::string plain = masked(text, likely_dialect(name).facts().comment, "\"");
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
      for (const std::string& name : names_in(text.name, text.text))
        naming_[name].insert(text.name);
      in_capitals_.emplace(upper(text.name), text.name);
    }
    for (const Dialect* const dialect : dialects())
      if (!dialect->facts().controller_mark.empty())
        marks_[dialect] = controller_marks(*dialect, project);
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
      if (by_) mark_corrected(likely_dialect(name), *by_, text);
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
    std::multimap<std::pair<int, size_t>, const TextEdit*> edits;  // by text and begin
    std::set<std::pair<size_t, size_t>> in_program;                // from where to where
    for (const TextEdit& edit : rewritten.edits) {
      edits.emplace(std::pair(edit.file, edit.begin), &edit);
      if (edit.file == 0) in_program.emplace(edit.begin, edit.end);
    }
    std::set<int> in_moves;  // points of which a move gets another
    for (const ProgramTarget& target : program.targets)
      if (in_program.contains({target.begin, target.end})) in_moves.insert(target.point);
    for (const size_t i : points) {
      const ProgramPoint& point = program.points[i];
      const size_t begin =
          point.text == 0 ? place_without_copies(program, point.begin) : point.begin;
      Shared& shared = shared_[{program.texts[point.text].name, begin}];
      shared.name = point.name;
      shared.line = point.line;
      shared.programs.insert(index);
      shared.points.emplace_back(index, i);
      shared.must_stay |= point.is_shared;
      if (in_moves.contains(static_cast<int>(i)))
        shared.must_stay = shared.is_changed = true;  // its moves need several numbers
      std::string changes;
      const auto last = edits.upper_bound({point.text, point.end});
      for (auto edit = edits.lower_bound({point.text, point.begin}); edit != last; ++edit)
        if (edit->second->end <= point.end)
          changes += std::to_string(edit->second->begin) + " " + edit->second->text + "\n";
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
    for (const std::string& text : texts_that_name(name)) {
      if (text == declaring || is_of_controller(text) || is_of_another_controller(text, declaring))
        continue;
      const auto program = program_of_text_.find(text);
      if (program != program_of_text_.end() && shared.programs.contains(program->second)) continue;
      if (!declares_itself(text, name, declaring)) others.push_back(text);
    }
    return others;
  }

  // Tasks of one controller, as ABB's, may share data.
  bool is_of_another_controller(const std::string& text, const std::string& declaring) const {
    const Dialect& dialect = likely_dialect(declaring);
    const auto marks = marks_.find(&dialect);
    if (marks == marks_.end()) return false;
    const std::string a = dialect.search_folder(marks->second, text).folder;
    const std::string b = dialect.search_folder(marks->second, declaring).folder;
    return !a.starts_with(b) && !b.starts_with(a);  // R1/System/ lies in R1/
  }

  // A program whose own data list has the name means that.
  bool declares_itself(const std::string& text, const std::string& name,
                       const std::string& declaring) const {
    const DialectFacts& facts = likely_dialect(text).facts();
    const std::string ending = ending_of(text);
    if (facts.data_list.empty()) return false;
    if (ending == facts.data_list) return true;  // only data
    if (std::ranges::find(facts.with_data_list, ending) == facts.with_data_list.end()) return false;
    const auto [first, last] = in_capitals_.equal_range(
        upper(text.substr(0, text.size() - ending.size())) + facts.data_list);
    return std::any_of(first, last, [&](const auto& dat) {
      return dat.second != declaring && texts_that_name(name).contains(dat.second);
    });
  }

  const std::set<std::string>& texts_that_name(const std::string& name) const {
    static const std::set<std::string> kNone;
    const auto found = naming_.find(name);
    return found == naming_.end() ? kNone : found->second;
  }

  void take_edits(size_t index) {
    const RobotProgram& program = programs_[index].program;
    std::vector<size_t> kept;
    std::map<std::pair<int, size_t>, size_t> insertions;  // of this program, by text and place
    for (const TextEdit& edit :
         edits_without_copies(program, result_.programs.back().edits, kept)) {
      const std::string& name = program.texts[edit.file].name;
      std::map<Key, TextEdit>& of_text = edits_[name];
      // Insertions at one place keep their order; a shared declaration changes once.
      const bool is_insertion = edit.begin == edit.end;
      const Key key{edit.begin, edit.end, is_insertion ? ++insertions[{edit.file, edit.begin}] : 0};
      of_text.try_emplace(key, TextEdit{0, edit.begin, edit.end, edit.text});
    }
  }

  std::vector<ProjectProgram> programs_;
  std::optional<Corrector> by_;
  std::map<std::string, size_t> program_of_text_;
  std::map<std::string, const std::string*> texts_;
  std::map<const Dialect*, std::vector<std::string>> marks_;  // of the controllers
  std::map<std::string, std::set<std::string>> naming_;  // the texts that have a name
  std::multimap<std::string, std::string> in_capitals_;  // names of texts
  std::map<Place, Shared> shared_;
  std::map<std::string, std::map<Key, TextEdit>> edits_;  // of each text
  RewrittenProject result_;
};

}  // namespace

bool is_of_controller(const std::string& path) {
  return std::ranges::any_of(dialects(), [&](const Dialect* dialect) {
    const std::vector<std::string>& names = dialect->facts().controller_texts;
    return std::ranges::find(names, name_in_folder(path)) != names.end();
  });
}

std::vector<std::string> controller_marks(const Dialect& dialect,
                                          const std::vector<ProgramText>& project) {
  std::vector<std::string> marks;
  for (const ProgramText& text : project)
    if (name_in_folder(text.name) == dialect.facts().controller_mark) marks.push_back(text.name);
  return marks;
}

std::vector<ProgramText> what_others_declare(const Dialect& dialect,
                                             const std::vector<ProgramText>& own,
                                             const std::vector<ProgramText>& others) {
  std::vector<const ProgramText*> program, all;
  for (const ProgramText& text : own) program.push_back(&text);
  all = program;
  for (const ProgramText& text : others) all.push_back(&text);
  const auto folder = dialect.folder_texts(all);
  return folder ? folder->for_program(program) : std::vector<ProgramText>{};
}

TextsOfOthers::TextsOfOthers(const Dialect& dialect, const std::vector<ProgramText>& project)
    : dialect_(dialect), project_(project), marks_(controller_marks(dialect, project)) {
  for (const ProgramText& text : project) by_name_.emplace(upper(text.name), &text);
}

std::vector<const ProgramText*> TextsOfOthers::own(const std::string& path) const {
  const DialectFacts& facts = dialect_.facts();
  const std::string stem = upper(path.substr(0, path.size() - ending_of(path).size()));
  std::vector<const ProgramText*> texts;
  if (facts.data_list.empty()) {
    const auto [first, last] = by_name_.equal_range(upper(path));
    for (auto text = first; text != last; ++text)
      if (text->second->name == path) texts.push_back(text->second);
    return texts;
  }
  for (const std::string& ending : {facts.endings.front(), facts.data_list}) {
    const auto [first, last] = by_name_.equal_range(stem + ending);
    for (auto text = first; text != last; ++text) texts.push_back(text->second);
  }
  return texts;
}

std::vector<ProgramText> TextsOfOthers::of(const std::string& path) {
  const auto [folder, is_deep] = dialect_.search_folder(marks_, path);
  const FolderTexts* const texts = texts_in({folder, is_deep});
  return texts ? texts->for_program(own(path)) : std::vector<ProgramText>{};
}

std::string TextsOfOthers::controller_of(const std::string& path) const {
  const auto [folder, is_deep] = dialect_.search_folder(marks_, path);
  return is_deep && folder != folder_of(path) ? folder : "";
}

const FolderTexts* TextsOfOthers::texts_in(const Folder& folder) {
  const auto [known, is_new] = folders_.try_emplace(folder);
  if (!is_new) return known->second.get();
  std::vector<const ProgramText*> texts;
  for (const ProgramText& text : project_)
    if (text.name.starts_with(folder.first) &&
        (folder.second || folder_of(text.name) == folder.first))
      texts.push_back(&text);
  known->second = dialect_.folder_texts(texts);
  return known->second.get();
}

std::map<std::string, ProgramNeighbours> neighbours_in(const Dialect& dialect,
                                                       const std::vector<ProgramText>& project,
                                                       const KnownFrames& known) {
  return dialect.neighbours(project, known);
}

RewrittenProject rewrite_project(std::vector<ProjectProgram> programs,
                                 const std::vector<ProgramText>& project,
                                 std::optional<Corrector> by) {
  return ProjectRewriter(std::move(programs), project, by).run();
}

}  // namespace armtrue
