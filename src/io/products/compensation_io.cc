#include "armtrue/io/products/compensation_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/check_digits.h"
#include "armtrue/statistics/summary.h"
#include "armtrue/text/number_text.h"
#include "io/compensation_columns.h"
#include "io/csv_cell.h"
#include "io/products/error_nodes.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

constexpr int kWorst = 3;  // that a summary names

// The text of a command: with check digits if the correction changes it.
std::string command_text(double si, double programmed, double unit) {
  const int decimals = command_decimals(unit), with_check = decimals + kCheckDecimals;
  const double value = si / unit;
  if (std::abs(value - programmed / unit) < 0.5 * std::pow(10.0, -decimals))
    return decimal_text(value, decimals);
  return decimal_text(checked(value, with_check, CheckSize::digits, Corrector::compensate),
                      with_check);
}

std::string notes_text(const CorrectedTarget& target) {
  std::string text;
  for (CommandNote note : target.notes) {
    if (!text.empty()) text += ' ';
    text += to_string(note);
  }
  return text;
}

// Writes the rows of one file with the commands of one kind.
class CommandWriter {
 public:
  CommandWriter(const ProgramFile& file, CommandKind kind) : file_(file), kind_(kind) {
    if (kind == CommandKind::joints)
      places_.assign(file.q.begin(), file.q.end());
    else
      places_.assign(file.pose.begin(), file.pose.end());
    appended_ = places_.front().column < 0;
    if (!appended_) return;
    for (size_t i = 0; i < places_.size(); ++i)
      if (kind == CommandKind::joints)
        places_[i].unit = file.joints[i].si();
      else
        places_[i].unit = i < 3 ? kMillimetre : kDegree;
  }

  std::string header() const {
    std::vector<std::string> names = file_.columns;
    for (size_t i = 0; appended_ && i < places_.size(); ++i)
      names.push_back(kind_ == CommandKind::joints ? file_.joints[i].encoder() : kPoseColumns[i]);
    names.insert(names.end(), kCommandColumns.begin(), kCommandColumns.end());
    return line_of(names);
  }

  std::string row(size_t number, const CorrectedTarget& target) const {
    std::vector<std::string> cells = file_.cells[number];
    const std::vector<double> command = command_of(target), programmed = programmed_of(target);
    // A target that stays is the text that was read, if it is of the same kind.
    const bool is_own_kind = file_.program.is_cartesian() == (kind_ == CommandKind::cartesian);
    for (size_t i = 0; i < command.size(); ++i) {
      const std::string text = number_of(command_text(command[i], programmed[i], places_[i].unit));
      if (appended_)
        cells.push_back(text);
      else if (target.is_corrected || !is_own_kind)
        cells[places_[i].column] = text;
    }
    if (file_.turn.column >= 0)
      cells[file_.turn.column] = std::to_string(turn_of(file_.program.turns[number], target.q));
    cells.push_back(length(target.before.position, kMillimetre));
    cells.push_back(length(target.before.orientation, kMilliradian));
    cells.push_back(length(target.after.position, kMillimetre));
    cells.push_back(length(target.after.orientation, kMilliradian));
    cells.push_back(target.deviation ? length(*target.deviation, kMillimetre) : "");
    cells.push_back(target.leverage ? number_of(fmt::format("{:.4g}", *target.leverage)) : "");
    cells.push_back(notes_text(target));
    return line_of(cells);
  }

 private:
  std::string line_of(const std::vector<std::string>& cells) const {
    std::string line;
    for (const std::string& cell : cells) {
      line += csv_cell(cell, file_.separator);
      line += file_.separator;
    }
    line.back() = '\n';
    return line;
  }

  std::string number_of(std::string text) const {
    if (file_.has_decimal_commas) std::ranges::replace(text, '.', ',');
    return text;
  }

  // Errors and deviations: six decimals of mm or mrad.
  std::string length(double si, double unit) const { return number_of(decimal_text(si / unit, 6)); }

  std::vector<double> command_of(const CorrectedTarget& target) const {
    return numbers_of(target.q, target.pose);
  }
  std::vector<double> programmed_of(const CorrectedTarget& target) const {
    return numbers_of(target.programmed, target.intended);
  }
  std::vector<double> numbers_of(const JointVector& q, const Pose& pose) const {
    if (kind_ == CommandKind::joints) return {q.begin(), q.end()};
    const Eigen::Vector3d& p = pose.translation;
    const Eigen::Vector3d abc = abc_from_rotation(pose.rotation);
    return {p.x(), p.y(), p.z(), abc.x(), abc.y(), abc.z()};
  }

  // KUKA's turn bits: bit j is set if q_j < 0. Bits of external axes stay.
  static int turn_of(int stated, const JointVector& q) {
    int turn = stated & ~0x3f;
    for (int j = 0; j < kProgramAxes; ++j)
      if (q[j] < 0) turn |= 1 << j;
    return turn;
  }

  const ProgramFile& file_;
  CommandKind kind_;
  std::vector<QuantityColumn> places_;  // of the command
  bool appended_ = false;
};

ErrorSummary summary_of(const std::vector<CorrectedTarget>& targets, auto value) {
  std::vector<double> values;
  for (const CorrectedTarget& target : targets) values.push_back(value(target));
  return summarize(values);
}

YAML::Node worst_node(const std::vector<CorrectedTarget>& targets, const Program& program) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (int row : worst_targets(targets, kWorst)) {
    const CorrectedTarget& target = targets[row];
    YAML::Node node;
    node["pose"] = program.visits.pose_ids[row];
    node["before_mm"] = rounded(target.before.position / kMillimetre);
    node["after_mm"] = rounded(target.after.position / kMillimetre);
    if (target.deviation) node["std_mm"] = rounded(*target.deviation / kMillimetre);
    node["notes"] = flow_list(target.notes, [](CommandNote note) { return to_string(note); });
    list.push_back(flow(node));
  }
  return list;
}

YAML::Node between_node(const BetweenPoints& between, const Program& program) {
  const BetweenPointsSummary summary = summarize(between);
  std::vector<YAML::Node> above;
  for (const MoveBetweenPoints& move : between.moves) {
    if (move.why.empty()) continue;
    YAML::Node node;
    node["pose"] = program.visits.pose_ids[move.target];
    if (std::isfinite(move.after)) node["after_mm"] = rounded(move.after / kMillimetre);
    node["why"] = move.why;
    above.push_back(flow(node));
  }
  YAML::Node node;
  node["tolerance_mm"] = rounded(between.tolerance / kMillimetre);
  node["moves"] = whole_number(between.moves.size());
  node["divided"] = whole_number(summary.divided);
  node["inserted"] = whole_number(summary.inserted);
  node["unknown"] = whole_number(between.unknown);
  if (summary.before) node["before_mm"] = error_node(*summary.before, kMillimetre);
  if (summary.after) node["after_mm"] = error_node(*summary.after, kMillimetre);
  node["above"] = list_node(above);
  return node;
}

}  // namespace

std::string write_commands(const ProgramFile& file, const std::vector<CorrectedTarget>& targets,
                           CommandKind kind) {
  const CommandWriter writer(file, kind);
  std::string text = writer.header();
  for (size_t row = 0; row < targets.size(); ++row) text += writer.row(row, targets[row]);
  return text;
}

Document write_compensation(const std::vector<CorrectedTarget>& targets, const Program& program,
                            const std::optional<BetweenPoints>& between,
                            const PredictionConditions& conditions, const Provenance& provenance) {
  YAML::Node root;
  root["format"] = "armtrue-compensation/1";
  root["provenance"] = provenance_node(provenance);
  root["robot"] = conditions.robot;
  root["controller"] = conditions.controller;
  if (!conditions.moves.empty()) root["moves"] = conditions.moves;
  root["sentence"] = compensation_sentence(targets);
  root["targets"] = whole_number(targets.size());
  root["corrected"] = whole_number(std::ranges::count_if(targets, &CorrectedTarget::is_corrected));
  root["before_mm"] =
      error_node(summary_of(targets, [](const auto& t) { return t.before.position; }), kMillimetre);
  root["before_mrad"] = error_node(
      summary_of(targets, [](const auto& t) { return t.before.orientation; }), kMilliradian);
  root["after_mm"] =
      error_node(summary_of(targets, [](const auto& t) { return t.after.position; }), kMillimetre);
  root["after_mrad"] = error_node(
      summary_of(targets, [](const auto& t) { return t.after.orientation; }), kMilliradian);
  root["expected_mm"] =
      error_node(summary_of(targets, [](const auto& t) { return t.expected(); }), kMillimetre);
  if (targets.front().deviation)
    root["std_mm"] =
        error_node(summary_of(targets, [](const auto& t) { return *t.deviation; }), kMillimetre);
  YAML::Node notes(YAML::NodeType::Map);
  for (CommandNote note : command_notes())
    // Of arms with fewer than six axes alone.
    if (note != CommandNote::fewer_axes || count_of(targets, note) > 0)
      notes[to_string(note)] = whole_number(count_of(targets, note));
  root["notes"] = flow(notes);
  if (between) root["between_points"] = between_node(*between, program);
  root["worst"] = worst_node(targets, program);
  root["assumed"] = texts_node(conditions.assumed);
  root["not_applied"] = texts_node(conditions.not_applied);
  return print_document(root);
}

std::string compensation_table(const std::vector<CorrectedTarget>& targets,
                               const Program& program) {
  std::string text = compensation_sentence(targets) + "\n";
  text += fmt::format("{:<20}{:>12}{:>12}{:>10}{:>10}  {}\n", "worst", "before_mm", "after_mm",
                      "std_mm", "leverage", "note");
  for (int row : worst_targets(targets, kWorst)) {
    const CorrectedTarget& target = targets[row];
    constexpr double kNothing = 1e-9;  // m: what the inverse kinematics leave
    const auto number = [](const std::optional<double>& value, double unit) {
      return value ? fmt::format("{:.3g}", *value / unit) : std::string("-");
    };
    const double after = target.after.position > kNothing ? target.after.position : 0;
    text += fmt::format("{:<20}{:>12.3g}{:>12.3g}{:>10}{:>10}  {}\n", program.visits.pose_ids[row],
                        target.before.position / kMillimetre, after / kMillimetre,
                        number(target.deviation, kMillimetre), number(target.leverage, 1),
                        notes_text(target));
  }
  return text;
}

}  // namespace armtrue
