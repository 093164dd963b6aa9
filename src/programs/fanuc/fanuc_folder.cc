#include <algorithm>
#include <map>
#include <string>

#include "programs/fanuc/fanuc_parts.h"
#include "programs/fanuc/fanuc_registers.h"
#include "programs/fanuc/fanuc_text.h"
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
    return result;
  }

 private:
  void add(const ProgramText& program) {
    const std::string text = masked_fanuc(program.text);
    for (const char* const kind : {"PR", "UFRAME", "UTOOL"})
      for (const std::string& name : fanuc_values_set_in(text, kind))
        setting_[name].push_back(&program);
  }

  std::vector<const ProgramText*> listings_;
  std::map<std::string, std::vector<const ProgramText*>> setting_;  // programs, by what they set
};

}  // namespace

std::unique_ptr<FolderTexts> fanuc_folder(const std::vector<const ProgramText*>& texts) {
  return std::make_unique<FanucFolder>(texts);
}

}  // namespace armtrue
