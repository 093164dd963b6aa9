#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "programs/fanuc/fanuc_flow.h"
#include "programs/fanuc/fanuc_parts.h"
#include "programs/fanuc/fanuc_registers.h"
#include "programs/fanuc/fanuc_text.h"
#include "programs/fanuc/fanuc_words.h"
#include "programs/path_name.h"
#include "programs/statement.h"

namespace armtrue {
namespace {

class FanucFolder : public FolderTexts {
 public:
  explicit FanucFolder(const std::vector<const ProgramText*>& texts) {
    for (const ProgramText* const text : texts)
      if (ending_of(text->name) == ".LS")
        add(*text);
      else if (is_fanuc_listing(text->text))
        listings_.push_back(text);
  }

  std::vector<ProgramText> for_program(const std::vector<const ProgramText*>& own) const override {
    std::vector<ProgramText> result;
    for (const ProgramText* const listing : listings_) result.push_back(*listing);
    std::string assignments;
    for (const auto& [name, programs] : setting_)
      if (std::ranges::any_of(programs, [&](const ProgramText* program) {
            return std::ranges::find(own, program) == own.end();
          }))
        assignments += name + "=0\n";
    result.push_back({"", assignments});
    for (const ProgramText* const program : own)
      for (const std::string& called : calls_in(masked_fanuc(program->text)))
        if (const auto sets = set_by_call(called))
          result.push_back({std::string(kFanucCall) + called, *sets});
    return result;
  }

 private:
  struct Program {
    std::set<std::string> values;  // that it sets
    std::set<std::string> calls;
  };

  void add(const ProgramText& program) {
    const std::string text = masked_fanuc(program.text);
    for (const char* const kind : {"PR", "UFRAME", "UTOOL"})
      for (const std::string& name : fanuc_values_set_in(text, kind))
        setting_[name].push_back(&program);
    const size_t head = std::min(line_that_begins(text, "/PROG"), text.size());
    TextCursor cursor(text, std::min(head + 5, text.size()), text.size());
    const std::string prog = cursor.take_name();
    if (prog.empty()) return;
    Program& named = programs_[prog];
    named.values.merge(fanuc_values_set_in(text, "PR"));
    if (sets_fanuc_frames(text)) named.values.insert("UFRAME_NUM");
    named.calls.merge(calls_in(text));
  }

  static std::set<std::string> calls_in(const std::string& text) {
    std::set<std::string> calls;
    each_fanuc_word(text, {0, 0, text.size()},
                    [&](const std::string& word, size_t, TextCursor cursor) {
                      if (calls_fanuc_program(word)) calls.insert(cursor.take_name());
                    });
    return calls;
  }

  // Nothing if a program of it is in no text here.
  std::optional<std::string> set_by_call(const std::string& called) const {
    std::vector<std::string> open{called};
    std::set<std::string> seen{called};
    std::string assignments;
    while (!open.empty()) {
      const auto program = programs_.find(open.back());
      open.pop_back();
      if (program == programs_.end()) return std::nullopt;
      for (const std::string& name : program->second.values) assignments += name + "=0\n";
      for (const std::string& next : program->second.calls)
        if (seen.insert(next).second) open.push_back(next);
    }
    return assignments;
  }

  std::vector<const ProgramText*> listings_;
  std::map<std::string, std::vector<const ProgramText*>> setting_;  // programs, by what they set
  std::map<std::string, Program> programs_;
};

}  // namespace

std::unique_ptr<FolderTexts> fanuc_folder(const std::vector<const ProgramText*>& texts) {
  return std::make_unique<FanucFolder>(texts);
}

}  // namespace armtrue
