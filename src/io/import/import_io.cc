#include "armtrue/io/import/import_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "io/import/joint_match.h"

namespace armtrue {
namespace {

constexpr double kSamePose = 0.1 * kDegree;  // as read_campaign() requires
constexpr const char* kSeparators = "\t;,";

// Numbers the texts of a column in the order in which they first stand.
int index_of(std::vector<std::string>& names, std::map<std::string, int>& places,
             const std::string& name) {
  const auto [place, is_new] = places.insert({name, static_cast<int>(names.size())});
  if (is_new) names.push_back(name);
  return place->second;
}

class CampaignBuilder {
 public:
  CampaignBuilder(const TableReader& points, const TableReader& joints, bool numbers_stops)
      : points_(points), joints_(joints), numbers_stops_(numbers_stops) {
    campaign_.source = points.table().file;
  }

  Campaign build(const std::vector<JointMatch>& matches) {
    find_temperatures();
    for (const JointMatch& match : matches) {
      if (points_.is_unmeasured(match.point_row))
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
    campaign_.position.push_back(points_.position(r));
    if (points_.has_orientation()) campaign_.orientation.push_back(points_.orientation(r));
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
    if (!table) {
      const bool same_stop =
          numbers_stops_ && row > 0 && differs(first_row_.back(), row) <= kSamePose;
      if (!same_stop) {
        first_row_.push_back(row);
        campaign_.pose_ids.push_back(std::to_string(first_row_.size()));
      }
      return static_cast<int>(first_row_.size()) - 1;
    }
    const int r = row_in(table, match);
    const int pose = index_of(campaign_.pose_ids, poses_, table->name(r, "pose"));
    if (pose == static_cast<int>(first_row_.size())) first_row_.push_back(row);
    const int first = first_row_[static_cast<size_t>(pose)];
    if (const double difference = differs(first, row); difference > kSamePose)
      table->fail(r, "pose",
                  fmt::format("has joint angles {:.4g} deg away from those of the same pose in "
                              "line {}; give different poses different names, or check the join",
                              difference / kDegree, campaign_.line[static_cast<size_t>(first)]));
    return pose;
  }

  // Largest difference of a joint [rad].
  double differs(int a, int b) const {
    return (campaign_.q[static_cast<size_t>(a)] - campaign_.q[static_cast<size_t>(b)])
        .cwiseAbs()
        .maxCoeff();
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
  }

  const TableReader& points_;
  const TableReader& joints_;
  bool numbers_stops_;
  Campaign campaign_;
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
                       const JointMatches& matches, bool numbers_stops) {
  ImportedReadings result;
  result.campaign = CampaignBuilder(points, joints, numbers_stops).build(matches.rows);
  result.warnings = matches.warnings;
  if (result.campaign.skipped_rows > 0)
    result.warnings.push_back(fmt::format("{}: {} rows without a measured point are left out",
                                          points.table().file, result.campaign.skipped_rows));
  if (!points.has("pose") && !joints.has("pose"))
    result.warnings.push_back(fmt::format(
        "{}: has no column of poses; {} poses are numbered, and visits to the same pose are not "
        "known as such: --column pose=NAME",
        points.table().file, result.campaign.pose_ids.size()));
  return result;
}

}  // namespace

ImportedReadings import_readings(const std::string& path, const ImportOptions& options) {
  ImportNames names(options);
  names.add_preset(options.preset);
  const PlainTable table = read_plain_table(
      path, kSeparators, [&](std::string_view header) { return names.is_known(header); });
  names.check_all_found({&table});
  const ColumnMapping mapping = map_columns(table, TableRole::readings, names, options);
  refuse_lone_dates(table, mapping);
  const TableReader reader(table, mapping);
  JointMatches matches;
  for (int r = 0; r < reader.rows(); ++r)
    matches.rows.push_back({r, r, reader.is_unmeasured(r) ? JointVector() : reader.joints(r)});
  ImportedReadings result = built(reader, reader, matches, false);
  result.mapping = mapping_text(table, mapping);
  return result;
}

ImportedReadings import_readings(const std::string& points, const std::string& joints,
                                 const ImportOptions& options) {
  const ImportNames names(options);
  ImportNames joint_names(options);
  joint_names.add_preset(options.preset);
  const PlainTable point_table = read_plain_table(
      points, kSeparators, [&](std::string_view header) { return names.is_known(header); });
  const PlainTable joint_table =
      read_plain_table(joints, joint_names.has_preset() ? " " : kSeparators,
                       [&](std::string_view header) { return joint_names.is_known(header); });
  names.check_all_found({&point_table, &joint_table});
  const ColumnMapping point_mapping = map_columns(point_table, TableRole::points, names, options);
  const ColumnMapping joint_mapping =
      map_columns(joint_table, TableRole::joints, joint_names, options);
  refuse_lone_dates(point_table, point_mapping);
  refuse_lone_dates(joint_table, joint_mapping);
  for (const auto& [quantity, column] : point_mapping.columns)
    if (quantity.size() == 2 && quantity >= "q1" && quantity <= "q6")
      point_table.fail_header(
          "the column '" + point_table.columns[static_cast<size_t>(column.column)].name +
          "' holds joint angles, as " + joint_table.file +
          " does; leave them out here with --ignore, or give this file alone without --joints");
  const TableReader point_reader(point_table, point_mapping);
  const TableReader joint_reader(joint_table, joint_mapping);
  const JointMatches matches = match_joints(point_reader, joint_reader, options);
  ImportedReadings result =
      built(point_reader, joint_reader, matches, matches.how.starts_with("by time"));
  result.mapping = mapping_text(point_table, point_mapping) +
                   mapping_text(joint_table, joint_mapping) + "joined " + matches.how + "\n";
  return result;
}

}  // namespace armtrue
