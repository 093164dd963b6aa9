#include <fmt/format.h>

#include <cmath>

#include "programs/dialects.h"
#include "programs/fanuc/fanuc_parts.h"
#include "programs/fanuc/fanuc_registers.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

class FanucDialect : public Dialect {
 public:
  FanucDialect()
      : Dialect({.name = "fanuc",
                 .maker = "FANUC",
                 .endings = {".LS"},
                 .names = {.longest = 36, .are_capitals = true},  // R-30iB, operator's manual
                 .frame = "its user frame (UF)",
                 .tool = "its tool frame (UT)",
                 .counts_axis_3_from_arm = true,
                 .fixed_turns = "CONFIG",
                 .parts = {{"/PROG", "/END"}}}) {}

  void parse(RobotProgram& program, const KnownFrames& known, TargetParts parts) const override {
    parse_fanuc_program(program, known, parts);
  }

  int decimals(TargetKind, size_t) const override { return 3; }
  NumberCheck check(TargetKind kind, size_t component) const override {
    return {0, Dialect::check(kind, component).rounded};  // an LS file has no more decimals
  }

  // 'N U T, 0, 0, 0': the letters stay, the turns are those of the joints, of an arm of four axes
  // J4 alone.
  std::vector<TextEdit> configuration_edits(const RobotProgram& program, const ProgramPoint& point,
                                            const JointVector& q) const override {
    if (point.configuration.empty()) return {};
    const ProgramNumber& place = point.configuration[0];
    const std::string text = program.texts[0].text.substr(place.begin, place.end - place.begin);
    std::string edited = text.substr(0, text.find(','));
    const auto stated = 3 + std::min<std::ptrdiff_t>(3, std::ranges::count(text, ','));
    for (Eigen::Index joint = 3; joint < stated; ++joint)
      edited += fmt::format(", {}", std::lround(q[joint] / kTurn));
    return {{0, place.begin, place.end, edited}};
  }

  // Of a register: a position of /POS.
  std::string written_out(const RobotProgram&, const ProgramPoint& point,
                          const WrittenPoint& texts) const override {
    const bool is_joints = point.kind == TargetKind::joints;
    std::string text = "{\n   GP1:\n\t" + point.name;
    const auto has_place = [](const ProgramNumber& number) { return number.end > 0; };
    const auto count = std::ranges::count_if(point.numbers, has_place);  // of fewer axes fewer
    for (size_t i = 0; i < static_cast<size_t>(count); ++i)
      text += fmt::format("{}\t{} = {:>9} {}",
                          i == 0   ? ""
                          : i == 3 ? ",\n"
                                   : ",",
                          is_joints ? fmt::format("J{}", i + 1) : std::string(1, "XYZWPR"[i]),
                          texts.numbers[i], is_joints || i > 2 ? "deg" : " mm");
    return text + "\n}";
  }

  std::unique_ptr<MoveWriter> move_writer(const RobotProgram& program) const override {
    return fanuc_writer(program);
  }
  void refuse_what_does_not_load(const RobotProgram& program, size_t inserted) const override {
    refuse_long_fanuc_program(program, inserted);
  }
  void add_comment(const std::string& comment, std::string& text) const override {
    add_fanuc_remark(facts().comment + comment, text);
  }

  std::unique_ptr<FolderTexts> folder_texts(
      const std::vector<const ProgramText*>& texts) const override {
    return fanuc_folder(texts);
  }
};

}  // namespace

const Dialect& fanuc_dialect() {
  static const FanucDialect dialect;
  return dialect;
}

}  // namespace armtrue
