#include "import/imported_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "import/bag.h"
#include "import/bag_table.h"
#include "import/body_columns.h"
#include "import/instrument_tables.h"
#include "import/marker_columns.h"
#include "import/presets.h"
#include "import/table_reader.h"

namespace armtrue {
namespace {

void refuse_lone_dates(const PlainTable& table, const ColumnMapping& mapping) {
  if (mapping.has("date") && !mapping.has("t"))
    table.fail_header(
        "the column of dates has no column of times beside it; name it: --column t_s=NAME, or "
        "leave the dates out with --ignore");
}

// The joints of a row that a recording fills by several messages: the latest value of each, at the
// time of the row.
struct LatestJoint {
  int column;
  std::string cell;
  double time = 0;
};

// Completes rows that have some joints, with the latest values of the others; leaves out those of
// which one is older than `oldest_s`.
void gather_joints(ImportedTable& import, double oldest_s) {
  std::vector<LatestJoint> latest;
  for (const JointName& joint : import.mapping.joints)
    latest.push_back({import.mapping.find(joint.column)->column, ""});
  const auto is_whole = [&](const PlainRow& row) {
    return std::ranges::none_of(
        latest, [&](const LatestJoint& joint) { return row.cells[joint.column].empty(); });
  };
  if (!import.mapping.has("t") || std::ranges::all_of(import.table.rows, is_whole)) return;
  const TableReader::Clock clock = TableReader(import.table, import.mapping).clock();
  const PlainTime zero = clock.is_number ? PlainTime{} : clock.times.front();
  std::vector<PlainRow> whole;
  int stale = 0;
  double oldest = 0, before = -std::numeric_limits<double>::infinity();
  for (size_t r = 0; r < import.table.rows.size(); ++r) {
    PlainRow& row = import.table.rows[r];
    const double now = clock.since(static_cast<int>(r), zero);
    double age = 0;
    for (LatestJoint& joint : latest) {
      std::string& cell = row.cells[joint.column];
      if (!cell.empty()) joint = {joint.column, cell, now};
      cell = joint.cell;
      age =
          cell.empty() ? std::numeric_limits<double>::infinity() : std::max(age, now - joint.time);
    }
    if (age > oldest_s) {
      ++stale;
      continue;
    }
    oldest = std::max(oldest, age);
    if (now == before) whole.pop_back();  // messages of one time: the last row has the news of all
    before = now;
    whole.push_back(std::move(row));
  }
  if (whole.empty())
    import.table.fail_header(fmt::format(
        "its messages hold some of the joints each, and at no time all were told within {:g} s; "
        "do their clocks agree? Else state a longer time: --max-gap-s",
        oldest_s));
  std::string note = fmt::format(
      "joints of several messages: at each time the latest of each, at most {:.3f} s old", oldest);
  if (stale > 0)
    note += fmt::format("; {} left out, where one is older (--max-gap-s)", counted(stale, "row"));
  import.table.notes.push_back(note);
  import.table.rows = std::move(whole);
}

// Leaves out rows without joint angles: a file of several topics has rows of the others.
void leave_out_empty_rows(ImportedTable& import) {
  const auto is_empty = [&](const PlainRow& row) {
    return std::ranges::all_of(import.mapping.joints, [&](const JointName& joint) {
      return row.cells[import.mapping.find(joint.column)->column].empty();
    });
  };
  const size_t before = import.table.rows.size();
  std::erase_if(import.table.rows, is_empty);
  if (import.table.rows.empty())
    import.table.fail_header("no row has joint angles; export them too");
  if (import.table.rows.size() < before)
    import.table.notes.push_back(
        fmt::format("{} without joint angles", counted(before - import.table.rows.size(), "row")));
}

std::optional<Preset> preset_for(const ImportOptions& options, bool holds_joints) {
  std::optional<Preset> found;
  for (const std::string& name : options.presets) {
    const Preset* const shipped = find_preset(name);
    const Preset preset = shipped ? *shipped : read_preset(name);
    if (preset.holds_joints != holds_joints) continue;
    if (found)
      throw InputError(fmt::format("--preset {} and {} are both for the table of {}; leave one out",
                                   found->name, preset.name,
                                   holds_joints ? "joint angles" : "points"));
    found = preset;
  }
  return found;
}

PlainTable read_table(const std::string& path, const ImportNames& names,
                      const ImportOptions& options, TableRole role) {
  const Preset* const preset = names.preset();
  if (preset && preset->form != TableForm::header)
    return read_instrument_table(path, *preset, options.body);
  TableStyle style;
  if (preset) {
    style.separators = preset->separators;
    style.blanks_too = false;
    style.comments = preset->comments;
  }
  if (!has_points(role) && options.robot)
    style.fewest_known = std::min(style.fewest_known, joint_count(options.robot->chain));
  return read_plain_table(path, style,
                          [&](std::string_view header) { return names.is_known(header); });
}

// The table of a recording has the columns that PlotJuggler writes.
void read_bag(const std::string& path, const ImportOptions& options, TableRole role,
              ImportedTable& import) {
  if (role == TableRole::readings)
    throw InputError(path +
                     ": is a recording; give it as --points and as --joints, or the table that has "
                     "one of them");
  const bool of_joints = !has_points(role);
  if (const auto preset = preset_for(options, of_joints))
    throw InputError(path + ": is a recording, which states its columns; leave out --preset " +
                     preset->name);
  import.names.set_preset(*find_preset(of_joints ? "plotjuggler-joints" : "plotjuggler-poses"));
  BagSelection selection{
      of_joints, of_joints ? options.joints_topic : options.points_topic, options.body, {}};
  if (of_joints)
    for (const std::string& name : joint_state_names(options)) selection.joints.insert(name);
  import.table = read_bag_table(path, selection);
}

}  // namespace

ImportedTable read_imported_table(const std::string& path, const ImportOptions& options,
                                  TableRole role) {
  ImportedTable import{ImportNames(options), {}, {}};
  if (is_bag(path)) {
    read_bag(path, options, role, import);
  } else {
    if (!(has_points(role) ? options.points_topic : options.joints_topic).empty())
      throw InputError(path + ": is a table, not a recording, so it has no topic; leave out " +
                       (has_points(role) ? "--points-topic" : "--joints-topic"));
    if (role != TableRole::readings)
      import.names.set_preset(preset_for(options, !has_points(role)));
    import.table = read_table(path, import.names, options, role);
  }
  import.names.apply_preset(import.table, options);
  if (has_points(role) && !import.names.preset()) {
    keep_body(import.table, import.names, options.body);
    spread_markers(import.table, import.names, options.markers);
  } else if (has_points(role) && !options.markers.empty()) {
    throw InputError("--marker is of tables without --preset; name the body of the preset: --body");
  }
  return import;
}

void map_imported_table(ImportedTable& import, const ImportOptions& options, TableRole role) {
  import.mapping = map_columns(import.table, role, import.names, options);
  refuse_lone_dates(import.table, import.mapping);
  if (import.table.has_markers && !import.mapping.orientation.empty())
    import.table.fail_header(
        "an orientation stands beside several markers, and each of them would count it once more; "
        "leave its columns out with --ignore, or choose one marker with --marker");
  if (import.table.has_markers && options.join == "stops")
    import.table.fail_header(
        "--join stops follows one point, and several stand in each row; choose one with --marker, "
        "or join by id or time");
  if (import.names.preset() && import.names.preset()->is_sparse) {
    leave_out_empty_rows(import);
    gather_joints(import, options.max_gap_s);
  }
}

}  // namespace armtrue
