#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "armtrue/text/xml_tags.h"
#include "programs/dialects.h"
#include "programs/polyscope/polyscope_program.h"

namespace armtrue {
namespace {

class PolyscopeDialect : public Dialect {
 public:
  PolyscopeDialect()
      : Dialect({.name = "polyscope",
                 .maker = "UR",
                 .endings = {".URP"},
                 .comment = '\0',
                 .may_be_packed = true,
                 .length = 1,
                 .angle = 1,
                 .tool = "its TCP"}) {}

  void parse(RobotProgram& program, const KnownFrames& known, TargetParts) const override {
    parse_polyscope_program(program, known);
  }

  Pose pose_of_numbers(const std::vector<double>& numbers) const override {
    return urscript_dialect().pose_of_numbers(numbers);
  }
  std::vector<double> numbers_of_pose(const Pose& pose,
                                      const std::vector<double>& written) const override {
    return urscript_dialect().numbers_of_pose(pose, written);
  }
  int decimals(TargetKind kind, size_t component) const override {
    return urscript_dialect().decimals(kind, component);
  }

  // The first node of the program, before those of its tree.
  void add_comment(const std::string& comment, std::string& text) const override {
    bool is_main = false;
    for (auto tag = next_tag(text, 0); tag; tag = next_tag(text, tag->end)) {
      is_main |= tag->name == "MainProgram";
      if (!is_main || tag->name != "children" || tag->closes || tag->is_empty) continue;
      const size_t first = text.find_first_not_of(" \t\r\n", tag->end);
      const std::string blanks = text.substr(tag->end, std::min(first, text.size()) - tag->end);
      text.insert(tag->end, fmt::format("{}<Comment comment=\"{}\"/>", blanks, comment));
      return;
    }
  }

  std::optional<OpenPart> open_part(const std::string& text) const override {
    std::vector<XmlTag> open;
    for (auto tag = next_tag(text, 0); tag; tag = next_tag(text, tag->end))
      if (!tag->closes && !tag->is_empty)
        open.push_back(*tag);
      else if (tag->closes && !open.empty())
        open.pop_back();
    if (open.empty()) return std::nullopt;
    return OpenPart{open.front().begin, fmt::format("</{}>", open.front().name)};
  }
};

}  // namespace

const Dialect& polyscope_dialect() {
  static const PolyscopeDialect dialect;
  return dialect;
}

}  // namespace armtrue
