#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "armtrue/programs/program_project.h"
#include "programs/kuka/krl_parts.h"
#include "programs/kuka/krl_words.h"
#include "programs/path_name.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

enum class Gives { nothing, global, all };  // declarations that others see

// DEFDAT $CONFIG, DEFDAT NAME PUBLIC. A program need not name what it uses of $config.dat, such as
// TOOL_DATA[1] of an inline form, or of $machine.dat, which says where the arm stands.
Gives gives_to_others(const ProgramText& list) {
  const std::string file = name_in_folder(list.name);
  if (file == "$CONFIG.DAT" || file == "$MACHINE.DAT") return Gives::all;
  for (const Statement& line : lines_of(list.text)) {
    TextCursor cursor(list.text, line.begin, line.end);
    if (cursor.take_name() != "DEFDAT") continue;
    if (cursor.take_name() == "$CONFIG") return Gives::all;
    return cursor.take_name() == "PUBLIC" ? Gives::global : Gives::nothing;
  }
  return Gives::nothing;
}

// The names of DECL GLOBAL E6POS XP1={..},XP2; none if it is not global.
std::vector<std::string> global_names(std::string_view line) {
  TextCursor cursor(line, 0, line.size());
  bool is_global = false;
  std::string type = cursor.take_name();
  for (; contains({"DECL", "GLOBAL", "CONST"}, type); type = cursor.take_name())
    is_global |= type == "GLOBAL";
  std::vector<std::string> names;
  for (int depth = 0; is_global && !cursor.done();) {
    const std::string name = cursor.take_name();
    if (name.empty()) {
      depth += cursor.next() == '{' ? 1 : cursor.next() == '}' ? -1 : 0;
      cursor.step();
    } else if (depth == 0) {
      names.push_back(name);
    }
  }
  return names;
}

class KrlFolder : public FolderTexts {
 public:
  explicit KrlFolder(const std::vector<const ProgramText*>& texts) {
    for (const ProgramText* const text : texts) {
      const std::string ending = ending_of(text->name);
      if (ending == ".DAT") add_list(*text);
      if ((ending == ".SRC" || ending == ".SUB") && !is_of_controller(text->name))
        add_source(*text);
    }
  }

  std::vector<ProgramText> for_program(const std::vector<const ProgramText*>& own) const override {
    std::set<std::string> words{"TOOL_DATA", "BASE_DATA"};  // BAS and inline forms mean them, too
    for (const ProgramText* const text : own) {
      const std::string plain = masked(text->text, ';', "\"");
      each_word(plain, {0, 0, plain.size()},
                [&](const std::string& word, size_t, const TextCursor&) { words.insert(word); });
    }
    const auto is_own = [&](const ProgramText* text) {
      return std::ranges::find(own, text) != own.end();
    };
    std::set<size_t> lists = for_all_;
    std::string assignments;
    for (const std::string& word : words) {
      if (const auto found = declaring_.find(word); found != declaring_.end())
        lists.insert(found->second.begin(), found->second.end());
      if (const auto found = setting_.find(word); found != setting_.end())
        if (!std::ranges::all_of(found->second, is_own)) assignments += word + "=0\n";
    }
    std::vector<ProgramText> result;
    for (const size_t list : lists)
      if (!is_own(lists_[list])) result.push_back(*lists_[list]);
    if (!std::ranges::all_of(sources_, is_own))
      result.push_back({sources_.front()->name, "DEF OTHERS()\n" + assignments});
    return result;
  }

 private:
  void add_list(const ProgramText& list) {
    const Gives gives = gives_to_others(list);
    if (gives == Gives::nothing) return;
    const size_t index = lists_.size();
    lists_.push_back(&list);
    if (gives == Gives::all) {
      for_all_.insert(index);
      return;
    }
    const std::string plain = masked(list.text, ';', "\"");
    for (const auto& [line, begin, end] : lines_of(plain))
      for (const std::string& name :
           global_names(std::string_view(plain).substr(begin, end - begin)))
        declaring_[name].insert(index);
  }

  // NAME=.., NAME[3].X=.., line by line; of inline forms nothing.
  void add_source(const ProgramText& source) {
    sources_.push_back(&source);
    const std::string plain = masked(source.text, ';', "\"");
    for (const Statement& line : lines_of(plain)) {
      TextCursor cursor(plain, line.begin, line.end);
      const std::string word = cursor.take_name();
      if (word.empty() || word[0] == '$' || contains({"PDAT_ACT", "LDAT_ACT", "FDAT_ACT"}, word) ||
          !takes_krl_assignment(cursor))
        continue;
      std::vector<const ProgramText*>& setting = setting_[word];
      if (setting.empty() || setting.back() != &source) setting.push_back(&source);
    }
  }

  std::vector<const ProgramText*> lists_;
  std::set<size_t> for_all_;                           // lists
  std::map<std::string, std::set<size_t>> declaring_;  // lists, by global names
  std::vector<const ProgramText*> sources_;
  std::map<std::string, std::vector<const ProgramText*>> setting_;  // sources, by names
};

}  // namespace

std::unique_ptr<FolderTexts> krl_folder(const std::vector<const ProgramText*>& texts) {
  return std::make_unique<KrlFolder>(texts);
}

}  // namespace armtrue
