#include "programs/fanuc/fanuc_folder.h"

#include <algorithm>
#include <set>
#include <string>

#include "programs/fanuc/fanuc_registers.h"
#include "programs/fanuc/fanuc_text.h"
#include "programs/path_name.h"
#include "programs/statement.h"

namespace armtrue {
namespace {

// What a program sets itself is set for it, too: the short text is the same for all.
class FanucFolder : public FolderTexts {
 public:
  explicit FanucFolder(const std::vector<const ProgramText*>& texts) {
    std::set<std::string> set;
    for (const ProgramText* const text : texts)
      if (ending_of(text->name) == ".LS")
        set.merge(fanuc_registers_set_in(masked_fanuc(text->text)));
      else if (is_fanuc_listing(text->text))
        listings_.push_back(text);
    for (const std::string& name : set) assignments_ += name + "=0\n";
  }

  std::vector<ProgramText> for_program(const std::vector<const ProgramText*>&) const override {
    std::vector<ProgramText> result;
    for (const ProgramText* const listing : listings_) result.push_back(*listing);
    result.push_back({"", assignments_});
    return result;
  }

 private:
  std::vector<const ProgramText*> listings_;
  std::string assignments_;
};

}  // namespace

std::unique_ptr<FolderTexts> fanuc_folder(const std::vector<const ProgramText*>& texts) {
  return std::make_unique<FanucFolder>(texts);
}

}  // namespace armtrue
