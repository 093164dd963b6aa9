#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include "armtrue/programs/dialect.h"
#include "armtrue/programs/program_project.h"
#include "programs/kuka/krl_parts.h"
#include "programs/kuka/krl_set_up.h"
#include "programs/kuka/krl_shared_variables.h"
#include "programs/kuka/krl_syntax.h"
#include "programs/kuka/krl_words.h"
#include "programs/path_name.h"
#include "programs/program_warnings.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

// A source, and what of it matters for its neighbours.
struct KrlSource {
  const ProgramText* text = nullptr;
  std::string plain;                 // by masked()
  std::set<std::string> routines;    // all
  std::set<std::string> exported;    // the first one, and those that are GLOBAL
  std::set<std::string> interrupts;  // routines that interrupts or triggers call
  std::vector<KrlCall> calls;        // of routines of others
  std::optional<KrlSyntax> syntax;   // if it calls others or others call it
  ProgramNeighbours neighbours;
};

KrlSource source_of(const ProgramText& text) {
  KrlSource source;
  source.text = &text;
  source.plain = masked(text.text, ';', "\"");
  for (const Statement& line : lines_of(source.plain)) {
    if (const auto head = krl_head(source.plain, line); head && begins_krl_routine(head->word)) {
      if (head->is_global || source.routines.empty()) source.exported.insert(head->name);
      source.routines.insert(head->name);
    }
    TextCursor cursor(source.plain, line.begin, line.end);
    std::string word = cursor.take_name();
    if (word == "GLOBAL") word = cursor.take_name();
    if (word == "INTERRUPT" || word == "TRIGGER")
      each_word(source.plain, {0, cursor.at(), line.end},
                [&](const std::string& name, size_t, TextCursor& behind) {
                  if (name == "DO") source.interrupts.insert(behind.take_name());
                });
  }
  source.calls = krl_calls(source.plain);
  return source;
}

// The sources of one controller. The frames at the end of a routine are found from those that call
// nothing upwards, the frames at its beginning from those that nothing calls downwards. Sources
// that call each other in a ring are not followed.
class KrlController {
 public:
  KrlController(TextsOfOthers& others, const KnownFrames& known, std::vector<KrlSource> sources,
                std::vector<std::string> submits)
      : others_(others),
        known_(known),
        sources_(std::move(sources)),
        submits_(std::move(submits)) {}

  void add_to(std::map<std::string, ProgramNeighbours>& result) {
    find_owners();
    for (KrlSource& source : sources_) keep_calls_of_others(source);
    state_.assign(sources_.size(), State::open);
    for (size_t i = 0; i < sources_.size(); ++i) find_what_is_left(i);
    for (KrlSource& source : sources_) find_what_interrupts_leave(source);
    for (KrlSource& source : sources_)
      for (const std::string& routine : source.exported)
        if (not_followed_.contains(routine) || interrupts_.contains(routine)) {
          source.neighbours.begins[routine] = several();
          source.neighbours.callers[routine] = interrupts_.contains(routine) ? "an interrupt" : "";
        }
    std::ranges::reverse(order_);
    for (const size_t i : order_) find_what_is_handed_on(i);
    find_shared_variables();
    for (KrlSource& source : sources_) result[source.text->name] = std::move(source.neighbours);
  }

 private:
  static constexpr int kSeveral = -1;
  enum class State { open, visited, done };

  void find_owners() {
    for (size_t i = 0; i < sources_.size(); ++i) {
      for (const std::string& name : sources_[i].exported) {
        if (!owners_.try_emplace(name, static_cast<int>(i)).second) owners_[name] = kSeveral;
        exporting_[name].push_back(i);
      }
      interrupts_.insert(sources_[i].interrupts.begin(), sources_[i].interrupts.end());
    }
  }

  void keep_calls_of_others(KrlSource& source) {
    std::erase_if(source.calls, [&](const KrlCall& call) {
      return source.routines.contains(call.name) || !owners_.contains(call.name);
    });
  }

  // What the calls of a source leave, after the same of the sources that it calls.
  void find_what_is_left(size_t index) {
    if (state_[index] != State::open) return;
    state_[index] = State::visited;
    KrlSource& source = sources_[index];
    for (const KrlCall& call : source.calls) {
      const int callee = owners_.at(call.name);
      if (callee != kSeveral) find_what_is_left(callee);
      const bool is_known = callee != kSeveral && state_[callee] == State::done;
      if (!is_known) not_followed_.insert(call.name);
      source.neighbours.leaves[call.name] =
          is_known ? left_by(sources_[callee], call.name) : several();
    }
    state_[index] = State::done;
    order_.push_back(index);
  }

  // What routines of others leave that only an interrupt or a trigger of a source calls.
  void find_what_interrupts_leave(KrlSource& source) {
    for (const std::string& name : source.interrupts) {
      const auto owner = owners_.find(name);
      if (!source.routines.contains(name) && owner != owners_.end() && owner->second != kSeveral)
        source.neighbours.leaves.try_emplace(name, left_by(sources_[owner->second], name));
    }
  }

  const HandedFrames& left_by(KrlSource& source, const std::string& routine) {
    const auto [known, is_new] = left_.try_emplace(routine);
    if (!is_new) return known->second;
    std::vector<ProgramFrame> frames;
    ProgramWarnings unused{""};
    ProgramNeighbours neighbours = source.neighbours;
    neighbours.begins = {{routine, KrlSetUps::any_frames()}};
    neighbours.callers = {{routine, ""}};
    KrlSetUps set_ups(source.text->text, syntax_of(source), neighbours, known_, frames, unused);
    set_ups.read();
    return known->second = set_ups.left_by(routine);
  }

  void find_what_is_handed_on(size_t index) {
    KrlSource& source = sources_[index];
    if (source.calls.empty()) return;
    std::vector<ProgramFrame> frames;
    ProgramWarnings unused{""};
    KrlSetUps set_ups(source.text->text, syntax_of(source), source.neighbours, known_, frames,
                      unused);
    set_ups.read();
    for (const KrlCall& call : source.calls) {
      const HandedFrames handed = set_ups.handed_on(call.statement);
      const std::string caller = fmt::format("{}:{}", source.text->name, call.line);
      for (const size_t callee : exporting_[call.name])
        hand_on(call.name, handed, caller, sources_[callee].neighbours);
    }
  }

  void find_shared_variables() {
    std::vector<KrlSourceText> texts;
    for (const KrlSource& source : sources_) texts.push_back({source.plain});
    for (const std::string& submit : submits_) texts.push_back({submit, true});
    std::vector<ProgramNeighbours::SharedVariables> shared = krl_shared_variables(texts);
    for (size_t i = 0; i < sources_.size(); ++i)
      sources_[i].neighbours.shared = std::move(shared[i]);
  }

  static void hand_on(const std::string& routine, const HandedFrames& frames,
                      const std::string& caller, ProgramNeighbours& callee) {
    std::string& callers = callee.callers[routine];
    constexpr size_t kShown = 60;  // characters, and the name that goes beyond
    if (callers.size() < kShown)
      callers += (callers.empty() ? "" : ", ") + caller;
    else if (!callers.ends_with(" .."))
      callers += " ..";
    const auto [begin, is_new] = callee.begins.try_emplace(routine, frames);
    for (size_t i = 0; !is_new && i < frames.size(); ++i)
      if (!(begin->second[i] == frames[i])) begin->second[i].kind = HandedFrame::Kind::several;
  }

  static HandedFrames several() {
    const HandedFrame frame{HandedFrame::Kind::several, "", {}};
    return {frame, frame, frame};
  }

  const KrlSyntax& syntax_of(KrlSource& source) {
    if (!source.syntax) {
      std::vector<ProgramText> texts{*source.text};
      for (const ProgramText* const text : others_.own(source.text->name))
        if (ending_of(text->name) == ".DAT") texts.push_back(*text);
      const size_t own = texts.size();
      std::ranges::move(others_.of(source.text->name), std::back_inserter(texts));
      source.syntax = parse_krl(texts, own);
    }
    return *source.syntax;
  }

  TextsOfOthers& others_;
  const KnownFrames& known_;
  std::vector<KrlSource> sources_;
  std::vector<std::string> submits_;          // texts that run beside them, by masked()
  std::map<std::string, int> owners_;         // of exported routines: sources, or kSeveral
  std::map<std::string, std::vector<size_t>> exporting_;  // sources, by these
  std::set<std::string> interrupts_;          // all names that they call
  std::set<std::string> not_followed_;        // routines: of several sources, or in a ring
  std::map<std::string, HandedFrames> left_;  // by the routines of one source
  std::vector<State> state_;
  std::vector<size_t> order_;  // a source before those that call it; then the other way round
};

}  // namespace

std::map<std::string, ProgramNeighbours> krl_neighbours(const Dialect& dialect,
                                                        const std::vector<ProgramText>& project,
                                                        const KnownFrames& known) {
  std::map<std::string, std::vector<KrlSource>> controllers;  // by their folders
  std::map<std::string, std::vector<std::string>> submits;
  const std::vector<std::string> marks = controller_marks(dialect, project);
  for (const ProgramText& text : project) {
    const bool is_submit = ending_of(text.name) == ".SUB";
    if (!is_submit && (dialect_of_file(text.name) != &dialect || is_of_controller(text.name)))
      continue;
    const std::string folder = dialect.search_folder(marks, text.name).folder;
    if (is_submit)
      submits[folder].push_back(masked(text.text, ';', "\""));
    else
      controllers[folder].push_back(source_of(text));
  }
  std::map<std::string, ProgramNeighbours> result;
  TextsOfOthers others(dialect, project);
  for (auto& [folder, sources] : controllers)
    KrlController(others, known, std::move(sources), std::move(submits[folder])).add_to(result);
  return result;
}

}  // namespace armtrue
