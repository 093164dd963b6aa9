#include "armtrue/import/import_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "armtrue/campaign/scattered_poses.h"
#include "armtrue/kinematics/chain.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "import/bag.h"
#include "import/bag_table.h"
#include "import/body_columns.h"
#include "import/covariance_columns.h"
#include "import/instrument_tables.h"
#include "import/joint_match.h"
#include "import/joint_stops.h"
#include "import/marker_columns.h"
#include "import/presets.h"

namespace armtrue {
namespace {

constexpr double kSamePose = 0.1 * kDegree;  // as read_campaign() requires
constexpr double kFrom1970 = 1e8;            // [s]: further than a clock counts that began at 0

// Numbers the texts of a column in the order in which they first stand.
int index_of(std::vector<std::string>& names, std::map<std::string, int>& places,
             const std::string& name) {
  const auto [place, is_new] = places.insert({name, static_cast<int>(names.size())});
  if (is_new) names.push_back(name);
  return place->second;
}

class CampaignBuilder {
 public:
  CampaignBuilder(const TableReader& points, const TableReader& joints, const JointMatches& matches)
      : points_(points), joints_(joints), how_(matches) {
    campaign_.source = points.table().file;
  }

  Campaign build() {
    find_temperatures();
    blocks_ = known_blocks(points_);
    for (const JointMatch& match : how_.rows) {
      if (points_.has("x") && points_.is_unmeasured(match.point_row))
        ++campaign_.skipped_rows;
      else
        add(match);
    }
    if (campaign_.rows() == 0)
      throw InputError(campaign_.source + ": no row has a measured point; export the readings too");
    add_times();
    return campaign_;
  }

 private:
  // The table that has a quantity, the points first; null if none.
  const TableReader* table_of(const std::string& quantity) const {
    return points_.has(quantity) ? &points_ : joints_.has(quantity) ? &joints_ : nullptr;
  }
  int row_in(const TableReader* table, const JointMatch& match) const {
    return table == &points_ ? match.point_row : match.joint_row;
  }

  void add(const JointMatch& match) {
    const int r = match.point_row;
    matches_.push_back(match);
    campaign_.line.push_back(points_.row(r).line);
    campaign_.q.push_back(match.q);
    if (!points_.has("x"))
      campaign_.position.emplace_back(0, 0, 0);  // an image's
    else
      campaign_.position.push_back(match.mean ? match.mean->position : points_.position(r));
    if (points_.has_orientation())
      campaign_.orientation.push_back(match.mean ? match.mean->orientation
                                                 : points_.orientation(r));
    if (blocks_.any())
      add_covariance(points_, r, match.mean ? match.mean->covariance : covariance_of(points_, r),
                     blocks_, campaign_);
    campaign_.pose.push_back(pose_of(match));
    if (const TableReader* table = table_of("repeat"))
      campaign_.repeat.push_back(table->whole_number(row_in(table, match), "repeat"));
    if (const TableReader* table = table_of("target"))
      campaign_.target.push_back(
          index_of(campaign_.target_names, targets_, table->name(row_in(table, match), "target")));
    if (const TableReader* table = table_of("session"))
      campaign_.session.push_back(index_of(campaign_.session_names, sessions_,
                                           table->name(row_in(table, match), "session")));
    if (const TableReader* table = table_of("payload"))
      campaign_.payload_kg.push_back(table->number(row_in(table, match), "payload"));
    if (campaign_.temperature_names.empty()) return;
    campaign_.temperature_c.emplace_back();
    for (size_t k = 0; k < campaign_.temperature_names.size(); ++k) {
      const std::string quantity = "temp_" + campaign_.temperature_names[k];
      const TableReader* table = table_of(quantity);
      campaign_.temperature_c.back()[k] = table->number(row_in(table, match), quantity);
    }
  }

  int pose_of(const JointMatch& match) {
    const TableReader* const table = table_of("pose");
    const int row = campaign_.rows() - 1;
    if (!table) return numbered_pose(row);
    const int r = row_in(table, match);
    const int pose = index_of(campaign_.pose_ids, poses_, table->name(r, "pose"));
    if (pose == std::ssize(first_row_)) first_row_.push_back(row);
    const int first = first_row_[pose];
    if (const double difference = differs(first, row); difference > kSamePose)
      table->fail(r, "pose",
                  fmt::format("has joint angles {:.4g} deg away from those of the same pose in "
                              "line {}; give different poses different names, or check the join",
                              difference / kDegree, campaign_.line[first]));
    return pose;
  }

  int numbered_pose(int row) {
    const size_t last = row;
    if (row > 0 && campaign_.line[last] == campaign_.line[last - 1])
      return campaign_.pose.back();  // of another marker
    const auto is_same = [&](int first) { return differs(first, row) <= kSamePose; };
    const auto known = how_.same_joints_are_one_pose ? std::ranges::find_if(first_row_, is_same)
                       : how_.stops_are_poses && row > 0 && is_same(first_row_.back())
                           ? first_row_.end() - 1
                           : first_row_.end();
    const auto pose = static_cast<int>(known - first_row_.begin());
    if (known == first_row_.end()) {
      first_row_.push_back(row);
      campaign_.pose_ids.push_back(std::to_string(first_row_.size()));
    }
    return pose;
  }

  // Largest difference of a joint [rad or m].
  double differs(int a, int b) const {
    return (campaign_.q[a] - campaign_.q[b]).cwiseAbs().maxCoeff();
  }

  void find_temperatures() {
    for (const TableReader* table : {&points_, &joints_})
      for (const std::string& quantity : table->quantities()) {
        auto& names = campaign_.temperature_names;
        if (!quantity.starts_with("temp_") || std::ranges::count(names, quantity.substr(5)) > 0)
          continue;
        if (names.size() == kMaxTemperatures)
          throw InputError(
              fmt::format("{}: has more than {} temperatures; leave some out with "
                          "--ignore",
                          table->table().file, kMaxTemperatures));
        names.push_back(quantity.substr(5));
      }
  }

  void add_times() {
    const TableReader* const table = table_of("t");
    if (!table) return;
    const TableReader::Clock clock = table->clock();
    const PlainTime zero = clock.is_number ? PlainTime{} : clock.times.front();
    for (const JointMatch& match : matches_)
      campaign_.time_s.push_back(clock.since(row_in(table, match), zero));
    const double first = campaign_.time_s.front();
    if (clock.is_number && first > kFrom1970)
      for (double& t : campaign_.time_s) t -= first;
  }

  const TableReader& points_;
  const TableReader& joints_;
  const JointMatches& how_;
  Campaign campaign_;
  StatedBlocks blocks_;
  std::vector<JointMatch> matches_;
  std::vector<int> first_row_;  // by pose
  std::map<std::string, int> poses_, targets_, sessions_;
};

void refuse_lone_dates(const PlainTable& table, const ColumnMapping& mapping) {
  if (mapping.has("date") && !mapping.has("t"))
    table.fail_header(
        "the column of dates has no column of times beside it; name it: --column t_s=NAME, or "
        "leave "
        "the dates out with --ignore");
}

ImportedReadings built(const TableReader& points, const TableReader& joints,
                       const JointMatches& matches) {
  ImportedReadings result;
  result.campaign = CampaignBuilder(points, joints, matches).build();
  result.joints = joints.joint_names();
  result.warnings = matches.warnings;
  if (const std::string apart = scattered_poses(result.campaign); !apart.empty())
    result.warnings.push_back(points.table().file + ": " + apart);
  if (result.campaign.skipped_rows > 0)
    result.warnings.push_back(fmt::format("{}: {} rows without a measured point are left out",
                                          points.table().file, result.campaign.skipped_rows));
  if (points.has("cov0") && result.campaign.whitening.empty())
    result.warnings.push_back(
        points.table().file +
        ": all covariances are zero, which says that they are not known; they are left out");
  if (!points.has("pose") && !joints.has("pose"))
    result.warnings.push_back(
        matches.same_joints_are_one_pose
            ? fmt::format("{}: has no column of poses; {} poses are numbered by their joint angles",
                          points.table().file, result.campaign.pose_ids.size())
            : fmt::format("{}: has no column of poses; {} poses are numbered, and visits to the "
                          "same pose are not known as such: --column pose=NAME",
                          points.table().file, result.campaign.pose_ids.size()));
  return result;
}

// One table on its way: text, then columns with names.
struct Import {
  ImportNames names;
  PlainTable table;
  ColumnMapping mapping;
};

// Rows of a file that holds several topics, of which this one has nothing.
void leave_out_empty_rows(Import& import) {
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
        fmt::format("{} rows without joint angles", before - import.table.rows.size()));
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

// The table of a recording has the columns of those that PlotJuggler writes.
void read_bag(const std::string& path, const ImportOptions& options, TableRole role,
              Import& import) {
  if (role == TableRole::readings)
    throw InputError(path +
                     ": is a recording; give it as --points and as --joints, or the table that has "
                     "one of them");
  const bool of_joints = !has_points(role);
  if (const auto preset = preset_for(options, of_joints))
    throw InputError(path + ": is a recording, which states its columns; leave out --preset " +
                     preset->name);
  import.names.set_preset(*find_preset(of_joints ? "plotjuggler-joints" : "plotjuggler-poses"));
  import.table = read_bag_table(
      path, {of_joints, of_joints ? options.joints_topic : options.points_topic, options.body});
}

Import read_import(const std::string& path, const ImportOptions& options, TableRole role) {
  Import import{ImportNames(options), {}, {}};
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

void map_import(Import& import, const ImportOptions& options, TableRole role) {
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
  if (import.names.preset() && import.names.preset()->is_sparse) leave_out_empty_rows(import);
}

}  // namespace

std::vector<std::string> import_presets() {
  std::vector<std::string> names;
  for (const Preset& preset : presets()) names.emplace_back(preset.name);
  return names;
}

namespace {

std::string moved_into_travel(TableReader& joints, const ImportOptions& options) {
  return options.robot ? joints.move_joints_into_travel(options.robot->chain) : "";
}

}  // namespace

ImportedReadings import_readings(const std::string& path, const ImportOptions& options) {
  Import import = read_import(path, options, TableRole::readings);
  import.names.check_all_found({&import.table});
  map_import(import, options, TableRole::readings);
  TableReader reader(import.table, import.mapping);
  JointMatches matches;
  const std::string moved = moved_into_travel(reader, options);
  for (int r = 0; r < reader.rows(); ++r)
    matches.rows.push_back(
        {r, r, reader.is_unmeasured(r) ? JointVector() : reader.joints(r), std::nullopt});
  ImportedReadings result = built(reader, reader, matches);
  if (!moved.empty()) result.warnings.push_back(moved);
  result.mapping = mapping_text(import.table, import.mapping);
  return result;
}

JointStops read_joint_stops(const std::string& joints, const ImportOptions& options) {
  Import import = read_import(joints, options, TableRole::images);
  import.names.check_all_found({&import.table});
  map_import(import, options, TableRole::images);
  TableReader reader(import.table, import.mapping);
  JointStops stops;
  if (std::string moved = moved_into_travel(reader, options); !moved.empty())
    stops.readings.warnings.push_back(std::move(moved));
  JointMatches matches;
  for (int r = 0; r < reader.rows(); ++r) {
    matches.rows.push_back({r, r, reader.joints(r), std::nullopt});
    if (reader.has("image")) stops.images.push_back(reader.name(r, "image"));
  }
  stops.readings.campaign = CampaignBuilder(reader, reader, matches).build();
  stops.readings.joints = reader.joint_names();
  stops.readings.mapping = mapping_text(import.table, import.mapping);
  stops.has_poses = reader.has("pose");
  return stops;
}

ImportedReadings import_readings(const std::string& points, const std::string& joints,
                                 const ImportOptions& options) {
  Import of_points = read_import(points, options, TableRole::points);
  Import of_joints = read_import(joints, options, TableRole::joints);
  of_points.names.check_all_found({&of_points.table, &of_joints.table});
  map_import(of_points, options, TableRole::points);
  map_import(of_joints, options, TableRole::joints);
  for (const auto& [quantity, column] : of_points.mapping.columns)
    if (joint_number(quantity) > 0)
      of_points.table.fail_header(
          "the column '" + of_points.table.columns[column.column].name +
          "' holds joint angles, as " + of_joints.table.file +
          " does; leave them out here with --ignore, or give this file alone without --joints");
  const TableReader point_reader(of_points.table, of_points.mapping);
  TableReader joint_reader(of_joints.table, of_joints.mapping);
  const std::string moved = moved_into_travel(joint_reader, options);
  const JointMatches matches = match_joints(point_reader, joint_reader, options);
  ImportedReadings result = built(point_reader, joint_reader, matches);
  if (!moved.empty()) result.warnings.push_back(moved);
  result.mapping = mapping_text(of_points.table, of_points.mapping) +
                   mapping_text(of_joints.table, of_joints.mapping) + "joined " + matches.how +
                   "\n";
  return result;
}

}  // namespace armtrue
