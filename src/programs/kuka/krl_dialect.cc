#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "armtrue/programs/program_project.h"
#include "programs/dialects.h"
#include "programs/kuka/krl_parts.h"
#include "programs/path_name.h"
#include "programs/point_numbers.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

constexpr int kTurnBits = 0x3f;               // of T, of the joints
constexpr int kFlipped = 4;                   // of S: A5 is below zero
constexpr size_t kOfTurn = 0, kOfStatus = 1;  // of ProgramPoint::configuration
constexpr int kDecimals = 4;                  // KSS shows four

int turn_bits(const JointVector& q) {
  int bits = 0;
  for (int j = 0; j < kProgramAxes; ++j)
    if (q[j] < 0) bits |= 1 << j;
  return bits;
}

bool crosses_zero(int joint, bool is_below, const ProgramCommand& command) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return is_below ? leaves(-kInfinity, 0, joint, command) : leaves(0, kInfinity, joint, command);
}

class KrlDialect : public Dialect {
 public:
  KrlDialect()
      : Dialect({.name = "krl",
                 .maker = "KUKA",
                 .endings = {".SRC"},
                 .comment = ';',
                 .names = {.longest = 24},  // KSS 8.x, operating manual
                 .frame = "$BASE",
                 .tool = "$TOOL",
                 .sets_active_tool = "$TOOL",
                 .has_frames_of_caller = true,
                 .has_external_axes = true,
                 .own_model = "$ABS_ACCUR",
                 .parts = {{"DEF", "END"}, {"DEFFCT", "ENDFCT"}, {"DEFDAT", "ENDDAT"}},
                 .data_list = ".DAT",
                 .with_data_list = {".SRC", ".SUB"},
                 // It sets XHOME where nobody has taught it, of deltas and palletizers.
                 .controller_texts = {"BAS.SRC"},
                 .controller_mark = "$CONFIG.DAT"}) {}

  void parse(RobotProgram& program, const KnownFrames& known, TargetParts parts) const override {
    parse_krl_program(program, known, parts);
  }

  std::vector<Routine> routines(const RobotProgram& program,
                                const KnownFrames& known) const override {
    return krl_routines(program, known);
  }

  // X Y Z A B C
  Pose pose_of_numbers(const std::vector<double>& n) const override {
    return {rotation_from_abc(n[3] * kDegree, n[4] * kDegree, n[5] * kDegree),
            Eigen::Vector3d(n[0], n[1], n[2]) * kMillimetre};
  }
  std::vector<double> numbers_of_pose(const Pose& pose,
                                      const std::vector<double>& written) const override {
    const Eigen::Vector3d near(written[3], written[4], written[5]);
    const Eigen::Vector3d mm = pose.translation / kMillimetre,
                          abc = abc_near(pose.rotation, near * kDegree) / kDegree;
    return {mm[0], mm[1], mm[2], abc[0], abc[1], abc[2]};
  }

  int decimals(TargetKind, size_t) const override { return kDecimals; }

  bool states_turn(const ProgramPoint& point) const override {
    return !point.configuration.empty() &&
           (point.configuration[kOfTurn].is_written() || point.is_expression);
  }

  std::vector<std::string> configuration_texts(const ProgramPoint& point,
                                               const ProgramCommand& command) const override {
    std::vector<std::string> texts = Dialect::configuration_texts(point, command);
    if (texts.empty()) return texts;
    const auto change = [&](size_t i, int now) {
      const ProgramNumber& number = point.configuration[i];
      if ((number.is_written() || point.is_expression) && now != number.value)
        texts[i] = fmt::format("{}", now);
    };
    int turn = static_cast<int>(point.configuration[kOfTurn].value);
    int status = static_cast<int>(point.configuration[kOfStatus].value);
    for (int j = 0; j < kProgramAxes; ++j)
      if (crosses_zero(j, turn & (1 << j), command)) turn ^= 1 << j;
    if (crosses_zero(4, status & kFlipped, command)) status ^= kFlipped;
    change(kOfTurn, turn);
    change(kOfStatus, status);
    return texts;
  }

  std::vector<TextEdit> configuration_edits(const RobotProgram&, const ProgramPoint& point,
                                            const JointVector& q) const override {
    if (!states_turn(point)) return {};
    const ProgramNumber& number = point.configuration[kOfTurn];
    const int written = static_cast<int>(number.value);
    const int turn = (written & ~kTurnBits) | turn_bits(q);
    if (turn == written) return {};
    return {{number.text, number.begin, number.end, fmt::format("{}", turn)}};
  }

  std::string written_out(const RobotProgram&, const ProgramPoint& point,
                          const WrittenPoint& texts) const override {
    const bool is_joints = point.kind == TargetKind::joints;
    std::string text = "{";
    for (size_t i = 0; i < texts.numbers.size(); ++i)
      text += fmt::format("{}{} {}", i == 0 ? "" : ",",
                          is_joints ? fmt::format("A{}", i + 1) : std::string(1, "XYZABC"[i]),
                          texts.numbers[i]);
    for (const size_t i : {kOfStatus, kOfTurn})
      if (!point.configuration.empty())
        text += fmt::format(",{} {}", i == kOfStatus ? 'S' : 'T',
                            texts.configuration[i].empty()
                                ? fmt::format("{:.0f}", point.configuration[i].value)
                                : texts.configuration[i]);
    for (size_t i = 0; i < point.external.size(); ++i) {
      if (!texts.external[i].empty())
        text += fmt::format(",E{} {}", i + 1, texts.external[i]);
      else if (!point.external[i].prefix.empty())
        text += point.external[i].prefix + rounded_text(point.external[i].value, 1, kDecimals);
    }
    return text + "}";
  }

  std::unique_ptr<FolderTexts> folder_texts(
      const std::vector<const ProgramText*>& texts) const override {
    return krl_folder(texts);
  }

  // That of the controller: the nearest folder around the program with a $config.dat in it.
  SearchFolder search_folder(const std::vector<std::string>& marks,
                             const std::string& path) const override {
    std::string folder = folder_of(path);
    const auto is_within = [&](const std::string& mark) { return mark.starts_with(folder); };
    while (!folder.empty() && std::ranges::none_of(marks, is_within))
      folder = folder_of(folder.substr(0, folder.size() - 1));
    return {folder};
  }

  std::map<std::string, ProgramNeighbours> neighbours(const std::vector<ProgramText>& project,
                                                      const KnownFrames& known) const override {
    return krl_neighbours(*this, project, known);
  }

 protected:
  bool begins_program(const std::string& word) const override {
    return word == "DEF" || word == "DEFFCT" || word == "DEFDAT";
  }
};

}  // namespace

const Dialect& krl_dialect() {
  static const KrlDialect dialect;
  return dialect;
}

}  // namespace armtrue
