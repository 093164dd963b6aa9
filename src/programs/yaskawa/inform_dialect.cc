
#include "programs/dialects.h"
#include "programs/yaskawa/inform_parts.h"

namespace armtrue {
namespace {

class InformDialect : public Dialect {
 public:
  InformDialect()
      : Dialect({.name = "inform",
                 .maker = "Yaskawa",
                 .endings = {".JBI"},
                 .comment = '\'',
                 .names = {.longest = 32,
                           .others = "-",
                           .may_begin_with_digit = true,
                           .are_capitals = true},  // DX100 and later, operator's manual
                 .frame = "its user frame (USER)",
                 .tool = "its tool (TOOL)",
                 .parts = {{"/JOB", "END"}}}) {}

  void parse(RobotProgram& program, const KnownFrames& known, TargetParts parts) const override {
    parse_inform_program(program, known, parts);
  }

  // Micrometres and 0.0001 deg are what the controller keeps.
  int decimals(TargetKind kind, size_t component) const override {
    return kind == TargetKind::cartesian && component < 3 ? 3 : 4;
  }
  NumberCheck check(TargetKind kind, size_t component) const override {
    return {0, Dialect::check(kind, component).rounded};
  }

  std::unique_ptr<MoveWriter> move_writer(const RobotProgram& program) const override {
    return inform_writer(program);
  }
  void refuse_what_does_not_load(const RobotProgram& program, size_t inserted) const override {
    refuse_long_inform_job(program, inserted);
  }
  std::unique_ptr<FolderTexts> folder_texts(
      const std::vector<const ProgramText*>& texts) const override {
    return inform_folder(texts);
  }
  void add_comment(const std::string& comment, std::string& text) const override {
    add_inform_comment(facts().comment + comment, text);
  }
};

}  // namespace

const Dialect& inform_dialect() {
  static const InformDialect dialect;
  return dialect;
}

}  // namespace armtrue
