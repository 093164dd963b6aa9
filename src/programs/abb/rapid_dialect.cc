#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "programs/abb/rapid_parts.h"
#include "programs/abb/rapid_words.h"
#include "programs/dialects.h"
#include "programs/path_name.h"
#include "programs/point_numbers.h"

namespace armtrue {
namespace {

constexpr std::array<int, 3> kAxesOfQuadrants{0, 3, 5};  // cf1, cf4, cf6
constexpr double kQuarter = 90 * kDegree;

// Of the axes 1, 4 and 6 (RAPID reference manual, confdata).
int quadrant(double angle) {
  return static_cast<int>(std::floor(angle / (0.5 * std::numbers::pi)));
}

class RapidDialect : public Dialect {
 public:
  RapidDialect()
      : Dialect({.name = "rapid",
                 .maker = "ABB",
                 .endings = {".MOD", ".PRG", ".SYS", ".MODX", ".SYSX"},
                 .frame = "its wobj",
                 .tool = "its tool"}) {}

  void parse(RobotProgram& program, const KnownFrames& known, TargetParts parts) const override {
    parse_rapid_program(program, known, parts);
  }

  // x y z q1 q2 q3 q4, whose length need not be 1.
  Pose pose_of_numbers(const std::vector<double>& n) const override {
    return {Eigen::Quaterniond(n[3], n[4], n[5], n[6]).normalized().toRotationMatrix(),
            Eigen::Vector3d(n[0], n[1], n[2]) * kMillimetre};
  }
  std::vector<double> numbers_of_pose(const Pose& pose,
                                      const std::vector<double>& written) const override {
    const Eigen::Vector3d mm = pose.translation / kMillimetre;
    const Eigen::Quaterniond of_text(written[3], written[4], written[5], written[6]);
    Eigen::Quaterniond q(pose.rotation);
    if (q.dot(of_text) < 0) q.coeffs() = -q.coeffs();
    return {mm[0], mm[1], mm[2], q.w(), q.x(), q.y(), q.z()};
  }

  // num is a float: 1e-4 mm of a metre, 1e-5 deg of 180.
  int decimals(TargetKind kind, size_t component) const override {
    if (kind == TargetKind::joints) return 5;
    return component < 3 ? 4 : 7;
  }
  NumberCheck check(TargetKind kind, size_t component) const override {
    NumberCheck check = Dialect::check(kind, component);
    if (component >= 3) check.rounded = 0;  // a thousandth of a quaternion turns the tool too far
    return check;
  }

  std::vector<std::string> configuration_texts(const ProgramPoint& point,
                                               const ProgramCommand& command) const override {
    std::vector<std::string> texts = Dialect::configuration_texts(point, command);
    if (texts.size() != 4) return texts;
    for (size_t i = 0; i < 3; ++i) {
      const ProgramNumber& number = point.configuration[i];
      const int joint = kAxesOfQuadrants[i];
      const double low = kQuarter * number.value;
      if (!leaves(low, low + kQuarter, joint, command)) continue;
      const int now = quadrant(command.q[joint]);
      if ((number.is_written() || point.is_expression) && now != number.value)
        texts[i] = fmt::format("{}", now);
    }
    return texts;
  }

  std::vector<TextEdit> configuration_edits(const RobotProgram&, const ProgramPoint& point,
                                            const JointVector& q) const override {
    std::vector<TextEdit> edits;
    for (size_t i = 0; i < 3; ++i) {
      const ProgramNumber& number = point.configuration[i];
      edits.push_back({number.text, number.begin, number.end,
                       fmt::format("{}", quadrant(q[kAxesOfQuadrants[i]]))});
    }
    return edits;
  }

  // Line ends have no meaning in RAPID.
  std::optional<OpenPart> open_part(const std::string& text) const override {
    static const std::map<std::string, std::string> kEnds{
        {"MODULE", "ENDMODULE"}, {"PROC", "ENDPROC"}, {"FUNC", "ENDFUNC"}, {"TRAP", "ENDTRAP"}};
    const std::string plain = masked(text, facts().comment, "\"");
    std::vector<OpenPart> open;
    each_rapid_word(plain, {0, 0, plain.size()},
                    [&](const std::string& word, size_t at, const TextCursor&) {
                      if (const auto part = kEnds.find(word); part != kEnds.end())
                        open.push_back({at, part->second});
                      if (!open.empty() && word == open.back().end) open.pop_back();
                      return false;
                    });
    return open.empty() ? std::nullopt : std::optional(open.back());
  }

  std::unique_ptr<FolderTexts> folder_texts(
      const std::vector<const ProgramText*>& texts) const override {
    std::vector<const ProgramText*> modules;
    for (const ProgramText* const text : texts)
      if (dialect_of_file(text->name) == this) modules.push_back(text);
    return rapid_folder(modules);
  }

  // That of the task (TASK1), or that of the module alone.
  SearchFolder search_folder(const std::vector<std::string>&,
                             const std::string& path) const override {
    for (size_t slash = path.find('/'); slash != std::string::npos;
         slash = path.find('/', slash + 1)) {
      const std::string folder = path.substr(0, slash);
      if (name_in_folder(folder).starts_with("TASK"))
        return {folder + "/", folder + "/" != folder_of(path)};
    }
    return {folder_of(path), false};
  }

  // Of a point that no declaration states as a whole.
  std::string written_out(const RobotProgram& program, const ProgramPoint& point,
                          const WrittenPoint& texts) const override {
    if (point.starts_from >= 0) return Dialect::written_out(program, point, texts);
    const std::vector<std::string>& n = texts.numbers;
    std::string text =
        fmt::format("[[{},{},{}],[{},{},{},{}],[", n[0], n[1], n[2], n[3], n[4], n[5], n[6]);
    for (size_t i = 0; i < point.configuration.size(); ++i)
      text += (i > 0 ? "," : "") + (texts.configuration[i].empty()
                                        ? fmt::format("{}", point.configuration[i].value)
                                        : texts.configuration[i]);
    return text + "]";
  }

 protected:
  bool begins_program(const std::string& word) const override { return word == "MODULE"; }
};

}  // namespace

const Dialect& rapid_dialect() {
  static const RapidDialect dialect;
  return dialect;
}

}  // namespace armtrue
