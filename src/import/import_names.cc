
#include <algorithm>
#include <cstdlib>

#include "armtrue/kinematics/chain.h"
#include "armtrue/kinematics/names.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "import/body_columns.h"
#include "import/column_mapping.h"
#include "import/covariance_columns.h"
#include "import/marker_columns.h"
#include "import/matrix_columns.h"

namespace armtrue {
namespace {

struct NamePair {
  std::string left, right;
};

// Splits q1_deg=A1 or A1=deg at `sign`: the first or the last =, because the user's name may hold
// one.
NamePair split_pair(const std::string& option, const std::string& text, size_t sign) {
  if (sign == std::string::npos || sign == 0 || sign + 1 == text.size())
    throw InputError(option + " '" + text + "': expected two names, such as " +
                     (option == "--unit" ? "A1=deg" : "q1_deg=A1"));
  return {text.substr(0, sign), text.substr(sign + 1)};
}

bool matches(const std::string& pattern, const std::string& name) {
  if (!pattern.ends_with('*')) return pattern == name;
  return name.starts_with(pattern.substr(0, pattern.size() - 1));
}

bool has_column(const PlainTable& table, std::string_view name) {
  return std::ranges::find(table.columns, name, &PlainColumn::name) != table.columns.end();
}

// The name of a joint that a column holds in every row.
std::string joint_in_cells(const PlainTable& table, const std::string& header) {
  const auto column = find_name(table.columns, header);
  if (!column)
    table.fail_header("has no column '" + header +
                      "', which names the joint; record the whole message");
  const auto cell = [&](const PlainRow& row) { return row.cells[*column]; };
  for (const PlainRow& row : table.rows)
    if (cell(row) != cell(table.rows.front()) || cell(row).empty())
      table.fail(row, *column,
                 "is another joint than '" + cell(table.rows.front()) +
                     "' in the first row; keep the messages of one publisher");
  return cell(table.rows.front());
}

std::string quoted_names(const std::map<std::string, std::string>& headers) {
  std::string names;
  for (const auto& [name, header] : headers) names += (names.empty() ? "'" : ", '") + name + "'";
  return names;
}

void add_name(std::map<std::string, std::string>& headers, const PlainTable& table,
              const std::string& joint, const std::string& header) {
  const auto [place, is_new] = headers.insert({joint, header});
  if (!is_new)
    table.fail_header("the columns '" + place->second + "' and '" + header +
                      "' both hold the joint '" + joint + "'; leave one out: --ignore '" + header +
                      "'");
}

}  // namespace

std::vector<std::string> joint_state_names(const ImportOptions& options) {
  std::vector<std::string> names;
  if (!options.robot) return names;
  const KinematicChain& chain = options.robot->chain;
  for (int j = 0; j < joint_count(chain); ++j) {
    const std::string& link = joint_link(chain, j).name;
    const auto named = options.joint_of_link.find(link);
    names.push_back(named == options.joint_of_link.end() ? link : named->second);
  }
  return names;
}

ImportNames::ImportNames(const ImportOptions& options) : ignored_(options.ignored) {
  for (const std::string& text : options.columns) {
    const NamePair pair = split_pair("--column", text, text.find('='));
    const auto quantity = stated_quantity(pair.left);
    if (!quantity)
      throw InputError(
          "--column '" + text + "': '" + pair.left +
          "' is no column of measured poses that this command writes; write OUR=THEIRS "
          "with pose, repeat, session, target, t_s, q1_deg, e1_mm, x_mm, a_deg, roll, rx, qw, "
          "payload_kg, temp_NAME_c or, of a pass, fx_n on the left");
    if (!quantities_.insert({pair.right, quantity->name}).second)
      throw InputError("--column: '" + pair.right + "' is named twice; leave one out");
    if (quantity->kind == UnitKind::encoder)
      stated_units_[quantity->name] = column_name(pair.left).unit;
    named_.push_back(pair.right);
  }
  for (const std::string& text : options.units) {
    const NamePair pair = split_pair("--unit", text, text.rfind('='));
    if (!find_unit(pair.right))
      throw InputError("--unit '" + text + "': '" + pair.right +
                       "' is no unit; known are mm, cm, m, um, in, deg, rad, mrad, s, ms, us, ns, "
                       "min, h, kg, C, N, kN, lbf");
    if (!units_.insert({pair.left, pair.right}).second)
      throw InputError("--unit: '" + pair.left + "' is named twice; leave one out");
    named_.push_back(pair.left);
  }
  named_.insert(named_.end(), ignored_.begin(), ignored_.end());
  if (options.joint_of_link.empty() || !options.robot) return;
  const std::vector<std::string> names = joint_state_names(options);
  const std::vector<JointName> joints = joint_names(options.robot->chain);
  for (size_t j = 0; j < joints.size(); ++j) of_urdf_[names[j]] = joints[j].column;
}

// A table with all joints of the URDF by their names has no other joints: what else is called a
// joint there follows one (mimic), or is one of a gripper.
void ImportNames::add_joints_of_urdf(const PlainTable& table) {
  const auto is_open = [&](const std::string& header) {
    return !quantities_.contains(header) && !is_ignored(header);
  };
  std::map<std::string, std::string> found;  // quantity by header
  for (const auto& [name, quantity] : of_urdf_) {
    if (maps(table, quantity)) continue;  // by --column
    const auto column = std::ranges::find_if(table.columns, [&](const PlainColumn& one) {
      return column_name(one.name).stem == name && is_open(one.name);
    });
    if (column == table.columns.end()) return;
    found[column->name] = quantity;
  }
  for (const PlainColumn& column : table.columns) {
    const auto known = known_quantity(column.name);
    if (known && joint_number(known->name) > 0 && !found.contains(column.name) &&
        is_open(column.name))
      ignored_.push_back(column.name);
  }
  quantities_.insert(found.begin(), found.end());
}

void ImportNames::apply_preset(const PlainTable& table, const ImportOptions& options) {
  if (!preset_ && !of_urdf_.empty()) add_joints_of_urdf(table);
  if (!preset_) return;
  std::map<std::string, std::string> by_name;  // header by name of the joint
  for (const PresetColumn& column : preset_->columns) {
    const std::string quantity(column.quantity);
    if (quantity != "q" && maps(table, quantity)) continue;
    std::vector<std::pair<std::string, std::string>> fitting;  // header and quantity
    for (const PlainColumn& one : table.columns) {
      const PresetFit fit = fit_of(column, one.name);
      if (!fit.column || quantities_.contains(one.name) || is_ignored(one.name)) continue;
      if (quantity == "q" && !column.beside.empty()) {
        add_name(by_name, table, joint_in_cells(table, std::string(column.beside) + fit.captured),
                 one.name);
      } else if (quantity == "q" && column.header.find("{joint}") != std::string_view::npos) {
        add_name(by_name, table, fit.captured, one.name);
      } else if (quantity == "q") {
        const bool from_one = column.header.find("{n}") != std::string_view::npos;
        if (const auto number = read_whole_number(fit.captured); number && *number <= kMaxJoints)
          fitting.emplace_back(one.name, "q" + std::to_string(*number + (from_one ? 0 : 1)));
      } else if (quantity == "cov") {
        if (const auto entry = read_whole_number(fit.captured);
            entry && *entry < kCovarianceEntries)
          fitting.emplace_back(one.name, "cov" + std::to_string(*entry));
      } else if (column.beside.empty() || has_column(table, column.beside)) {
        fitting.emplace_back(one.name, quantity);
      }
    }
    for (const auto& [header, ours] : fitting) {
      if (quantity == "q" && maps(table, ours)) continue;
      quantities_.insert({header, ours});
      if (column.unit == kOnlyByOption)
        doubted_.insert(header);
      else if (!column.unit.empty())
        units_.insert({header, std::string(column.unit)});
    }
  }
  add_joints_by_name(table, options, by_name);
}

void ImportNames::add_joints_by_name(const PlainTable& table, const ImportOptions& options,
                                     const std::map<std::string, std::string>& headers) {
  if (headers.empty()) return;
  const bool is_stated = std::ranges::any_of(quantities_, [](const auto& entry) {
    return joint_number(entry.second) > 0;  // by --column
  });
  const auto add = [&](const std::string& quantity, const std::string& header, bool is_length) {
    if (maps(table, quantity)) return;
    quantities_.insert({header, quantity});
    units_.insert({header, is_length ? "m" : "rad"});  // sensor_msgs/JointState
  };
  if (options.robot) {
    const std::vector<JointName> joints = joint_names(options.robot->chain);
    const std::vector<std::string> names = joint_state_names(options);
    std::vector<std::string> unknown;
    for (int j = 0; j < std::ssize(joints); ++j) {
      auto found = headers.find(names[j]);
      if (found == headers.end()) found = headers.find(names[j] + std::string(kJointEnding));
      if (found == headers.end())
        unknown.push_back(names[j]);
      else
        add(joints[j].column, found->second, joints[j].is_length);
    }
    // If some have their names, the others are elsewhere.
    const bool has_other_names = unknown.size() == joints.size() && options.joint_of_link.empty();
    const std::string remedy = has_other_names ? "give --urdf, the file that the robot was made of"
                               : options.joints_topic.empty()
                                   ? "record it, too"
                                   : "leave out --joints-topic, to read it from other topics";
    if (!unknown.empty() && !is_stated)
      table.fail_header("the joints are " + quoted_names(headers) + ", and the robot's " +
                        unknown.front() + " is none of them; " + remedy +
                        ", or name each: --column q1_deg='" + headers.begin()->second + "'");
    return;
  }
  // joint_a1 to joint_a7: one name with numbers from 1 on.
  std::string stem;
  std::map<int, std::string> numbered;
  for (const auto& [name, header] : headers) {
    const size_t digits = name.find_last_not_of("0123456789") + 1;
    const std::string before = name.substr(0, digits);
    const bool fits =
        digits < name.size() && name.size() - digits <= 2 && (numbered.empty() || before == stem);
    if (fits) numbered[std::atoi(name.c_str() + digits)] = header;
    if (!fits) numbered[-1] = header;
    stem = before;
  }
  if (numbered.size() != headers.size() || numbered.begin()->first != 1 ||
      numbered.rbegin()->first != std::ssize(headers)) {
    if (is_stated) return;
    table.fail_header("the joints are " + quoted_names(headers) +
                      ", in an order that the table does not tell; give --robot and --urdf, or "
                      "name each: --column q1_deg='" +
                      headers.begin()->second + "'");
  }
  for (const auto& [number, header] : numbered) add("q" + std::to_string(number), header, false);
}

bool ImportNames::is_known(std::string_view header) const {
  const auto quantity = known_quantity(header);
  if (quantities_.contains(header)) return true;
  if (preset_) return is_in_preset(*preset_, header);
  const std::string name(header);
  if (of_urdf_.contains(column_name(header).stem)) return true;
  if (is_matrix_element(header) || is_marker_coordinate(name) || is_of_body(name)) return true;
  return quantity && (quantity->kind == UnitKind::length || quantity->kind == UnitKind::angle ||
                      quantity->kind == UnitKind::encoder || quantity->kind == UnitKind::force);
}

bool ImportNames::is_ignored(const std::string& header) const {
  return std::ranges::any_of(ignored_,
                             [&](const std::string& pattern) { return matches(pattern, header); });
}

const std::string* ImportNames::quantity_of(const std::string& header) const {
  const auto found = quantities_.find(header);
  return found == quantities_.end() ? nullptr : &found->second;
}

const std::string* ImportNames::unit_of(const std::string& header) const {
  const auto found = units_.find(header);
  return found == units_.end() ? nullptr : &found->second;
}

bool ImportNames::doubts_unit_of(const std::string& header) const {
  return doubted_.contains(header);
}

std::string ImportNames::stated_unit(const std::string& quantity) const {
  const auto found = stated_units_.find(quantity);
  return found == stated_units_.end() ? "" : found->second;
}

bool ImportNames::maps(const PlainTable& table, const std::string& quantity) const {
  return std::ranges::any_of(table.columns, [&](const PlainColumn& column) {
    const std::string* const stated = quantity_of(column.name);
    return stated && *stated == quantity && !is_ignored(column.name);
  });
}

void ImportNames::check_all_found(const std::vector<const PlainTable*>& tables) const {
  for (const std::string& name : named_) {
    const bool found = std::ranges::any_of(tables, [&](const PlainTable* table) {
      return std::ranges::any_of(
          table->columns, [&](const PlainColumn& column) { return matches(name, column.name); });
    });
    if (!found)
      throw InputError(tables.front()->file + ": the options name the column '" + name +
                       "', which no header has; write it as it stands there");
  }
}

}  // namespace armtrue
