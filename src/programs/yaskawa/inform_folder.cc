#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "programs/path_name.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"
#include "programs/yaskawa/inform_job.h"
#include "programs/yaskawa/inform_listing.h"
#include "programs/yaskawa/inform_parts.h"

namespace armtrue {
namespace {

// The name of the short text, which no call has.
constexpr const char* kNobody = "*";

ProgramText job_of(const std::string& name, const std::string& lines) {
  return {name, "//NAME " + name + "\n//INST\n" + lines};
}

class InformFolder : public FolderTexts {
 public:
  explicit InformFolder(const std::vector<const ProgramText*>& texts) {
    InformChanges changes;
    InformListing listing;
    for (const ProgramText* const text : texts)
      if (ending_of(text->name) == ".JBI")
        add(*text, changes);
      else if (is_inform_listing(text->name))
        read_inform_listing(text->text, listing);
    listing_ = text_of(listing);
    for (const std::string& variable : changes.variables) sets_ += "SET " + variable + "\n";
    if (changes.is_any_variable) sets_ += "SET P[0]\n";
  }

  // The jobs that it calls, and those that they call, as far as they set frames; it knows itself
  // what it sets.
  std::vector<ProgramText> for_program(const std::vector<const ProgramText*>& own) const override {
    std::vector<ProgramText> result{job_of(kNobody, sets_), {kInformListing, listing_}};
    std::set<const Job*> called;
    std::vector<const Job*> open;
    for (const ProgramText* const text : own)
      if (const auto job = jobs_.find(text); job != jobs_.end()) open.push_back(&job->second);
    while (!open.empty()) {
      const Job* const job = open.back();
      open.pop_back();
      for (const std::string& name : job->calls) {
        const auto [begin, end] = by_name_.equal_range(name);
        for (auto other = begin; other != end; ++other) {
          if (std::ranges::find(own, other->second->text) != own.end()) continue;
          if (!called.insert(other->second).second) continue;
          result.push_back(job_of(name, other->second->lines));
          open.push_back(other->second);
        }
      }
    }
    return result;
  }

 private:
  struct Job {
    const ProgramText* text = nullptr;
    std::vector<std::string> calls;
    std::string lines;  // that call jobs or set frames or tools
  };

  void add(const ProgramText& text, InformChanges& changes) {
    const std::string plain = masked(text.text, '\'', "\"");
    const auto name = inform_job_name(plain);  // without one nobody loads it
    Job& job = jobs_[&text];
    job.text = &text;
    for (const Statement& statement : inform_lines(plain, inform_instructions(plain))) {
      const std::vector<std::string> calls = inform_calls(plain, statement);
      job.calls.insert(job.calls.end(), calls.begin(), calls.end());
      const std::string first = TextCursor(plain, statement.begin, statement.end).take_name();
      if (!calls.empty() || first == "MFRAME" || first == "SETTOOL")
        job.lines += plain.substr(statement.begin, statement.end - statement.begin) + "\n";
      if (name) note_inform_changes(plain, statement, false, changes);
    }
    if (name) by_name_.emplace(*name, &job);
  }

  std::map<const ProgramText*, Job> jobs_;
  std::multimap<std::string, const Job*> by_name_;
  std::string sets_;     // of all jobs
  std::string listing_;  // what the controller's files say
};

}  // namespace

std::unique_ptr<FolderTexts> inform_folder(const std::vector<const ProgramText*>& texts) {
  return std::make_unique<InformFolder>(texts);
}

}  // namespace armtrue
