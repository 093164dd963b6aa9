#include "programs/kuka/krl_shared_variables.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "programs/kuka/krl_words.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

using Names = std::set<std::string>;

struct RoutineText {
  std::string name;
  bool is_exported = false;  // others may call it
  Names words, sets;
};

struct SourceText {
  std::vector<RoutineText> routines;
  Names interrupts;  // routines that interrupts and triggers call
};

// NAME=.., NAME[3].X=.., and what FOR counts.
std::string name_set_by(TextCursor cursor, std::string word) {
  if (word == "FOR") word = cursor.take_name();
  return takes_krl_assignment(cursor) ? word : "";
}

void read_line(std::string_view text, const Statement& line, SourceText& source) {
  if (const auto head = krl_head(text, line); head && begins_krl_routine(head->word)) {
    source.routines.push_back({head->name, head->is_global || source.routines.empty(), {}, {}});
    return;
  }
  if (source.routines.empty()) return;
  RoutineText& routine = source.routines.back();
  TextCursor cursor(text, line.begin, line.end);
  std::string word = cursor.take_name();
  if (word == "GLOBAL") word = cursor.take_name();
  const bool is_declaration = word == "EXT" || word == "EXTFCT";
  // A routine may set what it is given.
  const bool hands_on = text.substr(0, line.end).find('(', line.begin) != std::string_view::npos;
  if (const std::string name = name_set_by(cursor, word); !name.empty()) routine.sets.insert(name);
  std::string before;
  each_word(text, line, [&](const std::string& name, size_t, const TextCursor&) {
    if (before == "DO") source.interrupts.insert(name);
    before = name;
    if (is_declaration) return;
    routine.words.insert(name);
    if (hands_on) routine.sets.insert(name);
  });
}

SourceText read(std::string_view text) {
  SourceText source;
  for (const Statement& line : lines_of(text)) read_line(text, line, source);
  return source;
}

class SharedVariablesReader {
 public:
  explicit SharedVariablesReader(const std::vector<KrlSourceText>& texts) {
    for (const KrlSourceText& text : texts) sources_.push_back(read(text.text));
    for (const SourceText& source : sources_)
      for (const RoutineText& routine : source.routines)
        if (routine.is_exported) exported_[routine.name].push_back({&source, &routine});
    find_shared();
  }

  std::vector<ProgramNeighbours::SharedVariables> run(const std::vector<KrlSourceText>& texts) {
    Names at_any_time;
    for (size_t i = 0; i < sources_.size(); ++i) {
      for (const std::string& name : sources_[i].interrupts)
        at_any_time.merge(set_by(meant(name, sources_[i])));
      for (const RoutineText& routine : sources_[i].routines)
        if (texts[i].is_submit) at_any_time.merge(set_by({{&sources_[i], &routine}}));
    }
    std::map<std::string, Names> known;
    std::vector<ProgramNeighbours::SharedVariables> all(sources_.size());
    for (size_t i = 0; i < sources_.size(); ++i) {
      all[i].set_at_any_time = at_any_time;
      if (shared_.empty()) continue;
      for (const RoutineText& routine : sources_[i].routines)
        for (const std::string& word : routine.words)
          if (const auto found = exported_.find(word); found != exported_.end()) {
            const auto [names, is_new] = known.try_emplace(word);
            if (is_new) names->second = set_by(found->second);
            all[i].set_by.insert(*names);
          }
    }
    return all;
  }

 private:
  using Meant = std::vector<std::pair<const SourceText*, const RoutineText*>>;

  void find_shared() {
    std::map<std::string, const SourceText*> first;
    for (const SourceText& source : sources_)
      for (const RoutineText& routine : source.routines)
        for (const std::string& name : routine.sets)
          if (first.try_emplace(name, &source).first->second != &source) shared_.insert(name);
  }

  // The routines that a name calls in a source: its own, or those of others.
  Meant meant(const std::string& name, const SourceText& source) const {
    for (const RoutineText& routine : source.routines)
      if (routine.name == name) return {{&source, &routine}};
    const auto found = exported_.find(name);
    return found == exported_.end() ? Meant{} : found->second;
  }

  // By routines and all that they name.
  Names set_by(Meant open) const {
    std::set<const RoutineText*> seen;
    Names names;
    while (!open.empty()) {
      const auto [source, routine] = open.back();
      open.pop_back();
      if (!seen.insert(routine).second) continue;
      std::ranges::set_intersection(routine->sets, shared_, std::inserter(names, names.end()));
      for (const std::string& word : routine->words)
        for (const auto& next : meant(word, *source)) open.push_back(next);
    }
    return names;
  }

  std::vector<SourceText> sources_;
  std::map<std::string, Meant> exported_;
  Names shared_;  // what two sources set
};

}  // namespace

std::vector<ProgramNeighbours::SharedVariables> krl_shared_variables(
    const std::vector<KrlSourceText>& sources) {
  return SharedVariablesReader(sources).run(sources);
}

}  // namespace armtrue
