#include "import/column_mapping.h"

#include <fmt/format.h>

#include <algorithm>

#include "armtrue/kinematics/chain.h"
#include "armtrue/text/edit_distance.h"
#include "armtrue/text/number_text.h"
#include "import/column_units.h"
#include "import/covariance_columns.h"
#include "import/matrix_columns.h"
#include "import/orientation_columns.h"

namespace armtrue {
namespace {

bool is_pose_part(const std::string& quantity) {
  static const std::set<std::string> kParts{"x",   "y",  "z",  "a",  "b",  "c",  "roll", "pitch",
                                            "yaw", "rx", "ry", "rz", "qw", "qx", "qy",   "qz"};
  const bool is_of_matrix = quantity.size() == 3 && quantity.front() == 'r' && quantity[1] < 'a';
  return kParts.contains(quantity) || quantity.starts_with("quat") || is_of_matrix;
}

bool is_force(const std::string& quantity) {
  return quantity == "fx" || quantity == "fy" || quantity == "fz";
}

bool is_number(const std::string& quantity) {
  static const std::set<std::string> kTexts{"pose", "session", "target", "date", "repeat"};
  return !kTexts.contains(quantity);
}

constexpr int kUsualJoints = 6;

class Mapper {
 public:
  Mapper(const PlainTable& table, TableRole role, const ImportNames& names,
         const ImportOptions& options)
      : table_(table), role_(role), names_(names), options_(options) {}

  ColumnMapping map() {
    if (!names_.preset())
      matrix_ = matrix_columns(table_, [&](int k) {
        return !names_.is_ignored(header(k)) && !names_.quantity_of(header(k));
      });
    for (int k = 0; k < std::ssize(table_.columns); ++k) map_column(k);
    take_times_of_dates();
    refuse_target_without_pose();
    refuse_actual_beside_nominal();
    if (role_ != TableRole::points && (role_ != TableRole::pass || has_joint())) find_joints();
    ColumnUnits units(table_, names_, options_, mapping_.joints);
    require_columns(units);
    for (auto& [quantity, column] : mapping_.columns) units.find(quantity, column);
    units.refuse_missing();
    require_whole_covariance(table_, mapping_);
    for (JointName& joint : mapping_.joints)
      if (!options_.robot) joint.is_length = is_length(*mapping_.find(joint.column));
    mapping_.orientation = find_orientation(table_, mapping_, options_);
    if (has_points(role_) && mapping_.orientation.empty() && !options_.angles.empty())
      table_.fail_header("--angles " + options_.angles +
                         " is given, but no column of an orientation is known; name them, such as "
                         "--column roll=NAME, or leave out --angles");
    find_decimal_sign();
    find_date_order();
    return mapping_;
  }

 private:
  const std::string& header(int k) const { return table_.columns[k].name; }

  void leave_out(int k, const std::string& why) { mapping_.unused.push_back({header(k), why}); }

  void map_column(int k) {
    const std::string& name = header(k);
    if (names_.is_ignored(name)) return leave_out(k, "ignored");
    const std::string* const stated = names_.quantity_of(name);
    auto known = known_quantity(name);
    if (const auto of_matrix = matrix_.find(k); of_matrix != matrix_.end()) {
      if (of_matrix->second.empty()) return leave_out(k, "last row of the matrix");
      known = KnownQuantity{of_matrix->second, UnitKind::none};
    }
    if (!stated && names_.preset()) return leave_out(k, "not in the preset");
    if (!stated && (!known || is_turn_or_temperature(k))) return leave_unknown(k);
    const std::string quantity = stated ? *stated : known->name;
    if (!stated && names_.maps(table_, quantity))
      table_.fail_header("the column '" + name + "' could be " + our_column(quantity) +
                         ", for which --column names another; leave it out: --ignore '" + name +
                         "'");
    if (is_force(quantity) && role_ != TableRole::pass) return leave_out(k, "not used");
    if (quantity == "image" && role_ != TableRole::images) return leave_out(k, "not used");
    if (!has_points(role_) && is_pose_part(quantity))
      return leave_out(k, "pose of the controller, not measured");
    if (role_ != TableRole::points && is_no_joint_of_robot(quantity)) return leave_still_axis(k);
    const auto [place, is_new] = mapping_.columns.insert({quantity, MappedColumn{k, 1, ""}});
    if (is_new) return;
    const std::string& first = header(place->second.column);
    if (first == name)
      table_.fail_header("the column '" + name + "' stands twice; rename or remove one");
    table_.fail_header("the columns '" + first + "' and '" + name + "' could both be " +
                       our_column(quantity) + "; leave one out: --ignore '" + name + "'");
  }

  // A column named as that of dates may hold the time of day, too.
  void take_times_of_dates() {
    if (!mapping_.has("date") || mapping_.has("t")) return;
    const size_t column = mapping_.find("date")->column;
    const auto first = std::ranges::find_if(
        table_.rows, [&](const PlainRow& row) { return !row.cells[column].empty(); });
    if (first == table_.rows.end()) return;
    const std::string& cell = first->cells[column];
    if (!plain_time(cell, DateOrder::day_first) && !plain_time(cell, DateOrder::month_first))
      return;
    auto dates = mapping_.columns.extract("date");
    dates.key() = "t";
    mapping_.columns.insert(std::move(dates));
  }

  bool is_no_joint_of_robot(const std::string& quantity) const {
    if (joint_number(quantity) == 0 || !options_.robot) return false;
    const std::vector<JointName> joints = joint_names(options_.robot->chain);
    return std::ranges::find(joints, quantity, &JointName::column) == joints.end();
  }

  // Leaves out the column of an axis that the robot does not have and that never moves: controllers
  // also log axes that are not connected.
  void leave_still_axis(int k) {
    const size_t column = k;
    for (const PlainRow& row : table_.rows)
      if (row.cells[column] != table_.rows.front().cells[column])
        table_.fail(row, k,
                    "moves an axis that the robot does not have (" +
                        encoder_columns(options_.robot->chain) +
                        "); take the file of the robot with that axis, give --urdf if it is the "
                        "URDF's name of a joint, or leave the column out: --ignore '" +
                        header(k) + "'");
    leave_out(k, "no axis of the robot, and it stands still");
  }

  bool has_joint() const {
    return std::ranges::any_of(mapping_.columns,
                               [](const auto& entry) { return joint_number(entry.first) > 0; });
  }

  // The joints of the robot; without a robot those of the table, the arm before the external axes.
  void find_joints() {
    if (options_.robot) {
      mapping_.joints = joint_names(options_.robot->chain);
      return;
    }
    int last = 0;
    std::vector<JointName> external;
    for (const auto& [quantity, column] : mapping_.columns) {
      const int number = joint_number(quantity);
      if (number > 0 && quantity.front() == 'q') last = std::max(last, number);
      if (number > 0 && quantity.front() == 'e')
        external.push_back({quantity, "E" + quantity.substr(1), false});
    }
    for (int j = 1; j <= std::max(last, kUsualJoints); ++j)
      mapping_.joints.push_back({fmt::format("q{}", j), std::to_string(j), false});
    mapping_.joints.insert(mapping_.joints.end(), external.begin(), external.end());
    if (std::ssize(mapping_.joints) > kMaxJoints)
      table_.fail_header(
          fmt::format("has {} joints, and a robot at most {}; leave some out: "
                      "--ignore NAME",
                      mapping_.joints.size(), kMaxJoints));
  }

  static bool is_length(const MappedColumn& column) {
    const auto unit = find_unit(column.unit);
    return unit && unit->kind == UnitKind::length;
  }

  // T without a unit of time may be a turn (KUKA) or a temperature.
  bool is_turn_or_temperature(int k) const {
    const ColumnName name = column_name(header(k));
    const auto unit = find_unit(name.unit.empty() ? table_.columns[k].unit_row : name.unit);
    return name.stem == "T" && !names_.unit_of(header(k)) &&
           !(unit && unit->kind == UnitKind::time);
  }

  // The column with this one letter as its name; empty if there is none.
  std::string header_of(const std::string& letter) const {
    for (const PlainColumn& column : table_.columns)
      if (lower_case(column_name(column.name).stem) == letter) return column.name;
    return "";
  }

  bool is_of_fanuc(const std::string& name) const {
    const std::string stem = lower_case(column_name(name).stem);
    return (stem == "w" || stem == "p" || stem == "r") && !header_of("w").empty() &&
           !header_of("p").empty() && !header_of("r").empty();
  }

  void leave_unknown(int k) {
    const std::string& name = header(k);
    const std::string& unit_row = table_.columns[k].unit_row;
    const ColumnName parts = column_name(name);
    const auto unknown = unknown_unit(name);
    if (unknown && looks_like_angle(unknown->stem, ""))
      table_.fail_header(
          fmt::format("the unit '{}' of the column '{}' is not known; write deg, rad, mrad or a "
                      "unit of length, "
                      "or say what the column is, such as --column {}='{}'",
                      unknown->unit, name, our_column(known_quantity(unknown->stem)->name), name));
    if (is_of_fanuc(name))
      table_.fail_header(
          "the column '" + name +
          "' looks like an orientation; W, P, R of a FANUC are turns about x, y, z: --column "
          "roll='" +
          header_of("w") + "' --column pitch='" + header_of("p") + "' --column yaw='" +
          header_of("r") + "' --angles rpy; else leave it out: --ignore '" + name + "'");
    if (looks_like_angle(name, parts.unit.empty() ? unit_row : parts.unit))
      table_.fail_header("the column '" + name +
                         "' looks like an angle or an orientation, and which is not known; say "
                         "what it is, such as --column q1_deg='" +
                         name + "', or leave it out: --ignore '" + name + "'");
    leave_out(k, "not used");
  }

  void refuse_target_without_pose() const {
    const MappedColumn* const target = mapping_.find("target");
    if (!target || table_.has_markers || mapping_.has("pose") ||
        names_.quantity_of(header(target->column)))
      return;
    const std::string& name = header(target->column);
    table_.fail_header("the column '" + name +
                       "' may name the pose or the reflector; say which: --column pose='" + name +
                       "' or --column target='" + name + "'");
  }

  // "Ist X" alone is what was measured; beside "Soll X" it may be what the controller tells.
  void refuse_actual_beside_nominal() const {
    const auto has_word = [&](int k, std::string_view word) {
      return lower_case(header(k)).find(word) != std::string::npos;
    };
    const MappedColumn* const x = mapping_.find("x");
    if (!x || names_.quantity_of(header(x->column)) || !has_word(x->column, "ist")) return;
    for (int k = 0; k < std::ssize(table_.columns); ++k)
      if (has_word(k, "soll") && !names_.is_ignored(header(k)))
        table_.fail_header("the column '" + header(x->column) + "' stands beside '" + header(k) +
                           "': if an instrument measured it, say so: --column x_mm='" +
                           header(x->column) +
                           "', and its y and z; else leave such columns out: "
                           "--ignore '" +
                           header(x->column) + "'");
  }

  void require_columns(const ColumnUnits& units) const {
    std::vector<std::string> needed;
    const bool has_force = std::ranges::any_of(
        mapping_.columns, [](const auto& entry) { return is_force(entry.first); });
    if (has_points(role_) && (!has_force || mapping_.has("x") || mapping_.has("y")))
      needed = {"x", "y", "z"};
    if (has_force) needed.insert(needed.end(), {"fx", "fy", "fz"});
    if (role_ == TableRole::pass) needed.emplace_back("t");
    for (const JointName& joint : mapping_.joints) needed.push_back(joint.column);
    std::string missing, there;
    bool is_joint = false;
    for (const std::string& quantity : needed) {
      if (mapping_.has(quantity)) continue;
      missing += (missing.empty() ? "" : ", ") + units.wanted_column(quantity);
      is_joint = is_joint || joint_number(quantity) > 0;
    }
    if (missing.empty()) return;
    for (const PlainColumn& column : table_.columns)
      there += (there.empty() ? "" : ", ") + ("'" + column.name + "'");
    table_.fail_header(
        "no column is known for " + missing + "; the columns are " + there +
        "; say which it is, such as --column " + missing.substr(0, missing.find(',')) + "=NAME" +
        (is_joint && !options_.robot ? ", or give --robot if the arm has not six joints" : ""));
  }

  // One decimal sign holds for a table: the only one under which all cells are numbers.
  void find_decimal_sign() {
    mapping_.decimal_stated = !options_.decimal.empty();
    if (mapping_.decimal_stated) {
      mapping_.decimal_sign = options_.decimal == "comma" ? ',' : '.';
      return;
    }
    struct Cell {
      const PlainRow* row = nullptr;
      int column = 0;
    };
    Cell point, comma, ambiguous;
    bool commas_only_quoted = table_.separator == ',';
    for (const auto& [quantity, column] : mapping_.columns) {
      if (!is_number(quantity)) continue;
      for (const PlainRow& row : table_.rows) {
        const std::string& cell = row.cells[column.column];
        const DecimalEvidence evidence = decimal_evidence(cell);
        if (evidence == DecimalEvidence::point) point = {&row, column.column};
        if (evidence == DecimalEvidence::comma) comma = {&row, column.column};
        if (evidence == DecimalEvidence::ambiguous) {
          ambiguous = {&row, column.column};
          if (cell.find(',') != std::string::npos) commas_only_quoted = false;
        }
      }
    }
    if (point.row && comma.row)
      table_.fail(*comma.row, comma.column,
                  fmt::format("has a decimal comma, but line {} has a decimal point; write all "
                              "numbers in one way",
                              point.row->line));
    if (point.row || comma.row) {
      mapping_.decimal_sign = comma.row ? ',' : '.';
    } else if (ambiguous.row && !commas_only_quoted) {
      table_.fail(*ambiguous.row, ambiguous.column,
                  "can be read with a decimal sign or with a thousands separator, and so can all "
                  "cells; say which: --decimal comma or --decimal point");
    }
  }

  // One order holds for a column: the only one in which all its cells are dates.
  void find_date_order() {
    const MappedColumn* const column = mapping_.find(mapping_.has("date") ? "date" : "t");
    if (!options_.dates.empty() || !column) {
      if (options_.dates == "month-first") mapping_.date_order = DateOrder::month_first;
      return;
    }
    bool by_day = true, by_month = true;
    const PlainRow* open = nullptr;
    for (const PlainRow& row : table_.rows) {
      const std::string& cell = row.cells[column->column];
      const auto day = day_of(cell, DateOrder::day_first),
                 month = day_of(cell, DateOrder::month_first);
      by_day = by_day && (day || !month);
      by_month = by_month && (month || !day);
      if (day && month && *day != *month && !open) open = &row;
    }
    if (by_day && by_month && open)
      table_.fail(*open, column->column,
                  "may have the day or the month first, and so may all dates; say which: --dates "
                  "day-first or --dates month-first");
    mapping_.date_order = by_month && !by_day ? DateOrder::month_first : DateOrder::day_first;
  }

  const PlainTable& table_;
  TableRole role_;
  const ImportNames& names_;
  const ImportOptions& options_;
  ColumnMapping mapping_;
  std::map<int, std::string> matrix_;  // quantities of its columns
};

}  // namespace

const MappedColumn* ColumnMapping::find(const std::string& quantity) const {
  const auto found = columns.find(quantity);
  return found == columns.end() ? nullptr : &found->second;
}

ColumnMapping map_columns(const PlainTable& table, TableRole role, const ImportNames& names,
                          const ImportOptions& options) {
  return Mapper(table, role, names, options).map();
}

std::string mapping_text(const PlainTable& table, const ColumnMapping& mapping) {
  const std::string separator = table.separator == '\t'  ? "tab"
                                : table.separator == ' ' ? "blank"
                                                         : std::string(1, table.separator);
  std::string text =
      table.separator == '\0'
          ? fmt::format("{}: recording, {}\n", table.file, counted(table.rows.size(), "reading"))
          : fmt::format("{}: header in line {}, separator {}, decimal {}, {}\n", table.file,
                        table.header_line, separator,
                        mapping.decimal_sign == ',' ? "comma" : "point",
                        counted(table.rows.size(), "row"));
  const auto line = [&](const std::string& ours, const std::string& theirs, const std::string& unit,
                        const std::string& factor) {
    std::string row = fmt::format("  {:<12}  {:<24}  {:<5}  {}", ours, theirs, unit, factor);
    row.erase(row.find_last_not_of(' ') + 1);
    const auto is_control = [](unsigned char c) { return c < ' ' || c == '\x7F'; };
    std::replace_if(row.begin(), row.end(), is_control, '?');
    text += row + "\n";
  };
  for (const std::string& note : table.notes) text += "  " + note + "\n";
  line("ours", "theirs", "unit", "factor");
  for (const auto& [quantity, column] : mapping.columns) {
    const auto joint = std::ranges::find(mapping.joints, quantity, &JointName::column);
    const std::string ours =
        joint == mapping.joints.end() ? our_column(quantity) : joint->encoder();
    const auto ours_unit = find_unit(column_name(ours).unit);
    const bool has_factor = !column.unit.empty() && ours_unit && ours_unit->factor > 0;
    line(ours, table.columns[column.column].name, column.unit,
         has_factor ? fmt::format("{:.10g}", column.factor / ours_unit->factor) : "");
  }
  for (const ColumnMapping::Note& note : mapping.unused) line("-", note.header, "", note.why);
  return text;
}

}  // namespace armtrue
