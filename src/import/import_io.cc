#include "armtrue/import/import_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>

#include "armtrue/campaign/scattered_poses.h"
#include "armtrue/kinematics/chain.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "import/covariance_columns.h"
#include "import/imported_table.h"
#include "import/joint_match.h"
#include "import/joint_stops.h"
#include "import/presets.h"

namespace armtrue {
namespace {

constexpr double kSamePose = 0.1 * kDegree;  // as read_campaign() requires

// The index of a text of a column, in the order of first appearance.
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
    return std::move(campaign_);
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
    if (const TableReader* table = table_of("t")) time_rows_.push_back(row_in(table, match));
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
    const int next = static_cast<int>(first_row_.size());
    int pose = next;
    if (how_.same_joints_are_one_pose)
      pose = std::min(next, pose_like(row));
    else if (how_.stops_are_poses && row > 0 && differs(first_row_.back(), row) <= kSamePose)
      pose = next - 1;
    if (pose == next) {
      pose_of_joint_.insert({campaign_.q[row][0], pose});
      first_row_.push_back(row);
      campaign_.pose_ids.push_back(std::to_string(first_row_.size()));
    }
    return pose;
  }

  // The first pose with the joint angles of a row; INT_MAX if none.
  int pose_like(int row) const {
    int first = std::numeric_limits<int>::max();
    const double angle = campaign_.q[row][0];
    const auto end = pose_of_joint_.upper_bound(angle + kSamePose);
    for (auto near = pose_of_joint_.lower_bound(angle - kSamePose); near != end; ++near)
      if (differs(first_row_[near->second], row) <= kSamePose)
        first = std::min(first, near->second);
    return first;
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
    for (const int row : time_rows_) campaign_.time_s.push_back(clock.since(row, zero));
    const double first = campaign_.time_s.front();
    if (clock.is_number && first > kFrom1970)
      for (double& t : campaign_.time_s) t -= first;
  }

  const TableReader& points_;
  const TableReader& joints_;
  const JointMatches& how_;
  Campaign campaign_;
  StatedBlocks blocks_;
  std::vector<int> time_rows_;  // in the table of the times
  std::vector<int> first_row_;  // by pose
  std::multimap<double, int> pose_of_joint_;  // numbered poses by their first joint [rad or m]
  std::map<std::string, int> poses_, targets_, sessions_;
};

ImportedReadings built(const TableReader& points, const TableReader& joints,
                       const JointMatches& matches) {
  ImportedReadings result;
  result.campaign = CampaignBuilder(points, joints, matches).build();
  result.joints = joints.joint_names();
  result.warnings = matches.warnings;
  if (const std::string apart = scattered_poses(result.campaign); !apart.empty())
    result.warnings.push_back(points.table().file + ": " + apart);
  if (result.campaign.skipped_rows > 0)
    result.warnings.push_back(fmt::format("{}: left out: {} without a measured point",
                                          points.table().file,
                                          counted(result.campaign.skipped_rows, "row")));
  if (points.has("cov0") && result.campaign.whitening.empty())
    result.warnings.push_back(
        points.table().file +
        ": all covariances are zero, which says that they are not known; they are left out");
  if (!points.has("pose") && !joints.has("pose"))
    result.warnings.push_back(
        matches.same_joints_are_one_pose
            ? fmt::format("{}: has no column of poses; {} numbered by joint angles",
                          points.table().file, counted(result.campaign.pose_ids.size(), "pose"))
            : fmt::format("{}: has no column of poses; {} numbered, and visits to the "
                          "same pose are not known as such: --column pose=NAME",
                          points.table().file, counted(result.campaign.pose_ids.size(), "pose")));
  return result;
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
  ImportedTable import = read_imported_table(path, options, TableRole::readings);
  import.names.check_all_found({&import.table});
  map_imported_table(import, options, TableRole::readings);
  TableReader reader(import.table, import.mapping);
  JointMatches matches;
  matches.same_joints_are_one_pose = true;
  const std::string moved = moved_into_travel(reader, options);
  for (int r = 0; r < reader.rows(); ++r)
    matches.rows.push_back(
        {r, r, reader.is_unmeasured(r) ? JointVector() : reader.joints(r), nullptr});
  ImportedReadings result = built(reader, reader, matches);
  if (!moved.empty()) result.warnings.push_back(moved);
  result.mapping = mapping_text(import.table, import.mapping);
  return result;
}

JointStops read_joint_stops(const std::string& joints, const ImportOptions& options) {
  ImportedTable import = read_imported_table(joints, options, TableRole::images);
  import.names.check_all_found({&import.table});
  map_imported_table(import, options, TableRole::images);
  TableReader reader(import.table, import.mapping);
  JointStops stops;
  if (std::string moved = moved_into_travel(reader, options); !moved.empty())
    stops.readings.warnings.push_back(std::move(moved));
  JointMatches matches;
  for (int r = 0; r < reader.rows(); ++r) {
    matches.rows.push_back({r, r, reader.joints(r), nullptr});
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
  ImportedTable of_points = read_imported_table(points, options, TableRole::points);
  ImportedTable of_joints = read_imported_table(joints, options, TableRole::joints);
  of_points.names.check_all_found({&of_points.table, &of_joints.table});
  map_imported_table(of_points, options, TableRole::points);
  map_imported_table(of_joints, options, TableRole::joints);
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
