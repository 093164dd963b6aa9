#include "armtrue/programs/dialect.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "armtrue/statistics/check_digits.h"
#include "programs/insertion.h"
#include "programs/path_name.h"
#include "programs/point_numbers.h"
#include "programs/routine_copies.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"
#include "programs/text_edit.h"

// What most makers have in common.

namespace armtrue {

std::vector<Routine> Dialect::routines(const RobotProgram&, const KnownFrames&) const { return {}; }

// A, B, C of KUKA in the other order.
Pose Dialect::pose_of_numbers(const std::vector<double>& n) const {
  return {rotation_from_abc(n[5] * kDegree, n[4] * kDegree, n[3] * kDegree),
          Eigen::Vector3d(n[0], n[1], n[2]) * kMillimetre};
}

std::vector<double> Dialect::numbers_of_pose(const Pose& pose,
                                             const std::vector<double>& written) const {
  const Eigen::Vector3d near(written[5], written[4], written[3]);
  const Eigen::Vector3d mm = pose.translation / kMillimetre,
                        abc = abc_near(pose.rotation, near * kDegree) / kDegree;
  return {mm[0], mm[1], mm[2], abc[2], abc[1], abc[0]};
}

// FANUC shows joint 3 relative to the horizontal; the chain counts it from the upper arm: q3 = J3 +
// J2 (FANUC, R-30iB operator's manual, joint coordinates).
JointVector Dialect::joints_of_numbers(const std::vector<double>& numbers) const {
  JointVector q = Eigen::Map<const JointVector>(numbers.data(), kProgramAxes);
  if (facts_.counts_axis_3_from_arm) q[2] += q[1];
  return q * facts_.angle;
}

std::vector<double> Dialect::numbers_of_joints(const JointVector& q) const {
  JointVector numbers = q / facts_.angle;
  if (facts_.counts_axis_3_from_arm) numbers[2] -= numbers[1];
  return {numbers.begin(), numbers.end()};
}

// A micrometre and a thousandth of a degree, which turns the tool about its tip, or a microradian.
// The same of a joint moves the tool too far.
NumberCheck Dialect::check(TargetKind kind, size_t component) const {
  constexpr double kMicrometre = 1e-6;
  const int rounded = static_cast<int>(std::lround(std::log10(facts_.length / kMicrometre)));
  return {decimals(kind, component) + 2, kind == TargetKind::joints ? 0 : rounded};
}

double Dialect::moved_by_check(TargetKind kind, size_t component) const {
  const NumberCheck checked = check(kind, component);
  double moved = 0;
  if (checked.decimals > 0) moved += std::pow(10.0, -decimals(kind, component));
  if (checked.rounded > 0) moved += kMostMovedIfRounded * std::pow(10.0, -checked.rounded);
  return moved;
}

bool Dialect::states_turn(const ProgramPoint&) const { return false; }

std::vector<std::string> Dialect::configuration_texts(const ProgramPoint& point,
                                                      const ProgramCommand&) const {
  return std::vector<std::string>(point.configuration.size());
}

std::vector<TextEdit> Dialect::configuration_edits(const RobotProgram&, const ProgramPoint&,
                                                   const JointVector&) const {
  return {};
}

// The declared point that the expression starts from, with other numbers.
std::string Dialect::written_out(const RobotProgram& program, const ProgramPoint& point,
                                 const WrittenPoint& texts) const {
  const ProgramPoint& from = program.points[point.starts_from];
  std::vector<TextEdit> edits;
  const auto add = [&](const ProgramNumber& number, const std::string& text) {
    edits.push_back({from.text, number.begin - from.begin, number.end - from.begin, text});
  };
  for (size_t i = 0; i < texts.numbers.size(); ++i) add(from.numbers[i], texts.numbers[i]);
  for (size_t i = 0; i < texts.configuration.size(); ++i)
    if (!texts.configuration[i].empty()) add(from.configuration[i], texts.configuration[i]);
  const std::string& text = program.texts[from.text].text;
  return apply_edits(text.substr(from.begin, from.end - from.begin), edits, from.text);
}

std::unique_ptr<MoveWriter> Dialect::move_writer(const RobotProgram& program) const {
  return std::make_unique<MoveWriter>(program);
}

void Dialect::refuse_what_does_not_load(const RobotProgram&, size_t) const {}

void Dialect::add_comment(const std::string& comment, std::string& text) const {
  size_t place = 0;
  for (const Statement& line : lines_of(text)) {
    TextCursor cursor(text, line.begin, line.end);
    std::string word = cursor.take_name();
    if (word == "GLOBAL") word = cursor.take_name();
    if (!begins_program(word)) continue;
    place = line.end + 1;
    break;
  }
  // MODULE part(SYSMODULE, .. on several lines
  const std::string_view head = std::string_view(text).substr(0, std::min(place, text.size()));
  if (const size_t open = head.rfind('(');
      place > 0 && open != std::string::npos && head.find(')', open) == std::string::npos)
    place = text.find('\n', std::min(text.find(')', open), text.size())) + 1;
  if (place > text.size()) return;  // a text of one line, which has no moves
  text.insert(place, facts_.comment + comment + line_end(text, 0));
}

std::optional<OpenPart> Dialect::open_part(const std::string& text) const {
  const std::string plain = masked(text, facts_.comment, "\"");
  std::optional<OpenPart> open;
  for (const Statement& line : lines_of(plain)) {
    TextCursor cursor(plain, line.begin, line.end);
    std::string word = cursor.take('/') ? "/" + cursor.take_name() : cursor.take_name();
    if (word == "GLOBAL") word = cursor.take_name();
    if (open && word == open->end) open.reset();
    for (const auto& [first, last] : facts_.parts)
      if (word == first) {
        if (open) return open;
        open = OpenPart{line.begin, last};
      }
  }
  return open;
}

bool Dialect::begins_program(const std::string&) const { return false; }

std::unique_ptr<FolderTexts> Dialect::folder_texts(const std::vector<const ProgramText*>&) const {
  return nullptr;
}

Dialect::SearchFolder Dialect::search_folder(const std::vector<std::string>&,
                                             const std::string& path) const {
  return {folder_of(path)};
}

std::map<std::string, ProgramNeighbours> Dialect::neighbours(const std::vector<ProgramText>&,
                                                             const KnownFrames&) const {
  return {};
}

}  // namespace armtrue
