#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>
#include <tuple>

#include "armtrue/campaign/grouped_rows.h"
#include "armtrue/campaign/stated_covariance.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "io/campaign_columns.h"
#include "io/campaign_parts.h"
#include "io/csv_table.h"
#include "io/joint_columns.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr double kUnitQuaternion = 1e-3;
constexpr const char* kDeviation = "a standard deviation";
constexpr int kNoName = -1;  // index of a name that the row does not need
constexpr const char* kNoId = "is empty; every row needs the id of its pose";

using Quantity = CsvTable::Quantity;

constexpr size_t kBytesPerBlock = 1 << 18;  // of the file, that one task reads
constexpr int kBlocksAtOnce = 16;           // bounds the text that waits in memory

// Reads the rows of a block of the file.
class RowReader {
 public:
  // `has_beams`: the robot has beams. A file without a column `beam` then means its only one.
  RowReader(CsvTable& table, const CampaignColumns& columns, bool has_beams)
      : table_(table), columns_(columns), has_beams_(has_beams), indices_(part_.rows) {}

  CampaignPart read() {
    part_.rows.source = table_.source_name();
    try {
      while (table_.next_row()) {
        part_.first_line = part_.first_line == 0 ? table_.line_number() : part_.first_line;
        read_row();
      }
    } catch (...) {
      part_.failure = std::current_exception();
    }
    part_.blank_line = table_.blank_line();
    return std::move(part_);
  }

 private:
  bool has_distance() const {
    return columns_.distance && !table_.is_empty(columns_.distance->column);
  }

  // A point of a profile that the sensor did not see has neither y nor z.
  bool has_touch() const {
    if (columns_.profile[0])
      return !table_.is_empty(columns_.profile[0]->column) ||
             !table_.is_empty(columns_.profile[1]->column);
    return columns_.contact && !table_.is_empty(*columns_.contact);
  }

  bool has_pixel() const {
    return columns_.corner &&
           !(table_.is_empty(*columns_.pixel[0]) && table_.is_empty(*columns_.pixel[1]));
  }

  bool has_pixel_columns() const { return columns_.corner.has_value(); }
  // Whether all rows fill `position`: with points, or with pixels until bind_touches().
  bool fills_position() const { return columns_.has_points || has_pixel_columns(); }
  bool has_touch_columns() const { return columns_.contact || has_pixel_columns(); }

  bool has_point() const {
    const auto filled = [&](const auto& quantity) { return !table_.is_empty(quantity->column); };
    return columns_.has_points &&
           std::any_of(columns_.position.begin(), columns_.position.end(), filled);
  }

  void read_row() {
    if (!has_point() && !has_distance() && !has_touch() && !has_pixel()) {
      ++part_.rows.skipped_rows;
      return;
    }
    Campaign& c = part_.rows;
    if (table_.is_empty(*columns_.pose)) table_.fail(*columns_.pose, kNoId);
    const int pose = indices_.poses.of(table_.original(*columns_.pose));
    const JointVector q = numbers(columns_.q);
    c.pose.push_back(pose);
    c.line.push_back(table_.line_number());
    c.q.push_back(q);
    if (has_pixel())
      read_pixel();
    else if (has_touch())
      read_touch();
    else if (has_distance())
      read_distance();
    else
      read_point();
    if (columns_.repeat) c.repeat.push_back(table_.integer(*columns_.repeat));
    if (columns_.target)
      c.target.push_back(reads_target() ? indices_.targets.of(table_.original(*columns_.target))
                                        : kNoName);
    if (columns_.session) c.session.push_back(indices_.sessions.of(table_.original(*columns_.session)));
    if (const auto& sigma = has_pixel() ? columns_.sigma_pixel : columns_.sigma_position)
      c.sigma_position.push_back(positive(*sigma, kDeviation));
    if (columns_.sigma_orientation)
      c.sigma_orientation.push_back(positive(*columns_.sigma_orientation, kDeviation));
    read_covariance();
    columns_.context->read(table_, c);
  }

  // Whether the row that was just read needs a target: beams and cameras sit beside the targets.
  bool reads_target() const {
    const Campaign& c = part_.rows;
    if (c.touch.empty() || c.touch.back().contact < 0) return true;
    return !c.touch.back().is_pixel && !BeamName::is_one(c.contact_names[c.touch.back().contact]);
  }

  // Splits the covariance of a row into standard deviations and the matrix that whitens it.
  void read_covariance() {
    constexpr size_t kOfRotation = place_of_covariance(3, 3);
    const bool of_position = columns_.covariance[0].has_value();
    const bool of_rotation = columns_.covariance[kOfRotation].has_value();
    if (!of_position && !of_rotation) return;
    PoseCovariance covariance = PoseCovariance::Identity();
    for (int i = 0; i < 6; ++i)
      for (int k = i; k < 6; ++k)
        if (const auto& column = columns_.covariance[place_of_covariance(i, k)])
          covariance(i, k) = covariance(k, i) = table_.number(*column);
    if (!add_covariance(covariance, {of_position, of_rotation}, part_.rows))
      table_.fail(columns_.covariance[of_position ? 0 : kOfRotation]->column,
                  "the covariance of this row is not positive definite: variances are above zero, "
                  "and no covariance is beyond the root of the product of its two variances");
  }

  // One number per joint.
  JointVector numbers(const std::vector<std::optional<Quantity>>& columns) const {
    JointVector values(columns.size());
    for (size_t j = 0; j < columns.size(); ++j) values[j] = table_.number(*columns[j]);
    return values;
  }

  void read_point() {
    Campaign& c = part_.rows;
    if (columns_.distance || has_touch_columns()) c.distance.push_back(0);
    if (columns_.anchor) c.anchor.push_back(0);
    if (has_touch_columns()) c.touch.emplace_back();
    c.position.emplace_back(table_.number(*columns_.position[0]),
                            table_.number(*columns_.position[1]),
                            table_.number(*columns_.position[2]));
    if (columns_.abc[0])
      c.orientation.emplace_back(rotation_from_abc(table_.number(*columns_.abc[0]),
                                                   table_.number(*columns_.abc[1]),
                                                   table_.number(*columns_.abc[2])));
    if (columns_.quaternion[0]) c.orientation.push_back(quaternion());
  }

  void read_distance() {
    Campaign& c = part_.rows;
    if (columns_.beam && !table_.is_empty(*columns_.beam))
      table_.fail(*columns_.beam,
                  "the beam " + table_.quoted(*columns_.beam) +
                      " ends on a plane; name it in the column 'contact', or empty the cell");
    if (has_point())
      table_.fail(columns_.distance->column,
                  table_.quoted(columns_.distance->column) +
                      " stands beside a point; a row is either a distance or a "
                      "point: empty the other's cells");
    if (fills_position()) c.position.emplace_back(0, 0, 0);
    if (has_touch_columns()) c.touch.emplace_back();
    refuse_orientation();
    c.distance.push_back(positive(*columns_.distance, "a distance"));
    if (columns_.anchor) {
      if (table_.is_empty(*columns_.anchor))
        table_.fail(*columns_.anchor, "is empty; every distance needs the name of its anchor");
      c.anchor.push_back(indices_.anchors.of(table_.original(*columns_.anchor)));
    }
  }

  // `l_mm` beside a contact is what a gauge or a beam shows, of either sign.
  void read_touch() {
    Campaign& c = part_.rows;
    if (has_point())
      table_.fail(*columns_.contact,
                  "a row with the contact " + table_.quoted(*columns_.contact) +
                      " has a point, too; a row is either: empty the other's cells");
    if (columns_.anchor && !table_.is_empty(*columns_.anchor))
      table_.fail(*columns_.anchor,
                  table_.quoted(*columns_.anchor) +
                      " stands beside a contact; a distance from an anchor is a row of "
                      "its own: empty the cell");
    refuse_orientation();
    if (fills_position()) c.position.emplace_back(0, 0, 0);
    if (columns_.anchor) c.anchor.push_back(0);
    c.distance.push_back(has_distance() ? table_.number(*columns_.distance) : 0.0);
    if (columns_.profile[0]) read_profile_point();
    const std::string contact(table_.original(*columns_.contact));
    const bool names_beam = columns_.beam && !table_.is_empty(*columns_.beam);
    if (names_beam && !has_distance())
      table_.fail(*columns_.beam, "the beam " + table_.quoted(*columns_.beam) +
                                      " reads a distance; give it in the column 'l_mm'");
    const bool is_of_beam = names_beam || (!columns_.beam && has_beams_ && has_distance());
    const std::string name = is_of_beam
                                 ? BeamName(std::string(names_beam ? table_.original(*columns_.beam)
                                                                   : std::string_view()),
                                            contact)
                                       .text()
                                 : contact;
    c.touch.push_back({indices_.contacts.of(name), -1});
  }

  void read_profile_point() {
    if (table_.is_empty(*columns_.contact))
      table_.fail(*columns_.contact,
                  "is empty; every point of a profile needs the plane or the sphere on which it "
                  "lies: leave out rows of what else the sensor saw");
    part_.rows.profile.push_back(
        {table_.number(*columns_.profile[0]), table_.number(*columns_.profile[1])});
  }

  // Pixels wait in `position` for bind_touches().
  void read_pixel() {
    Campaign& c = part_.rows;
    if (table_.is_empty(*columns_.corner))
      table_.fail(*columns_.corner,
                  "is empty; every pixel needs the id of its corner on the board");
    if (has_point() || has_distance() || has_touch())
      table_.fail(*columns_.pixel[0],
                  table_.quoted(*columns_.pixel[0]) +
                      " stands beside another reading; a row is one reading: give the corner a row "
                      "of its own");
    const auto name = [&](const std::optional<int>& column) {
      return std::string(column ? table_.original(*column) : std::string_view());
    };
    for (const auto& column : {columns_.camera, columns_.board})
      if (name(column).find('/') != std::string::npos)
        table_.fail(*column, table_.quoted(*column) + " has a '/', which no name has");
    c.position.emplace_back(table_.number(*columns_.pixel[0]), table_.number(*columns_.pixel[1]),
                            0);
    c.distance.push_back(0);
    c.metre_per_pixel = 1;
    const PixelName seen(name(columns_.camera), name(columns_.board), name(columns_.corner));
    if (columns_.anchor) c.anchor.push_back(0);
    c.touch.push_back({indices_.contacts.of(seen.text()), -1, true});
  }

  void refuse_orientation() const {
    for (const auto& angle : columns_.abc)
      if (angle && !table_.is_empty(angle->column)) fail_orientation(angle->column);
    for (const auto& component : columns_.quaternion)
      if (component && !table_.is_empty(*component)) fail_orientation(*component);
  }

  [[noreturn]] void fail_orientation(int column) const {
    table_.fail(column, table_.quoted(column) + " stands beside a " +
                            (has_touch() ? "contact" : "distance") +
                            ", which has no orientation; empty the cell");
  }

  double positive(const Quantity& quantity, const std::string& what) const {
    const double value = table_.number(quantity);
    constexpr double kSmallest = 1e-12;  // m or rad
    if (value <= 0)
      table_.fail(quantity.column,
                  table_.quoted(quantity.column) + ": " + what + " must be above zero");
    if (value < kSmallest)
      table_.fail(quantity.column,
                  table_.quoted(quantity.column) + ": " + what + " is less than anything real");
    return value;
  }

  Eigen::Quaterniond quaternion() const {
    const auto& columns = columns_.quaternion;
    const Eigen::Quaterniond q(table_.number(*columns[0]), table_.number(*columns[1]),
                               table_.number(*columns[2]), table_.number(*columns[3]));
    if (std::abs(q.norm() - 1) > kUnitQuaternion)
      table_.fail(*columns[0], fmt::format("the quaternion has norm {:.4g}, not 1; are the "
                                           "columns in the order qw,qx,qy,qz?",
                                           q.norm()));
    return q.normalized();
  }

  CsvTable& table_;
  const CampaignColumns& columns_;
  bool has_beams_;
  CampaignPart part_;
  CampaignIndices indices_;  // of part_.rows
};

// Reads the rows of a file into a campaign.
class CampaignReader {
 public:
  CampaignReader(Source& source, const CsvTable& table, const std::vector<JointName>& joints,
                 const KinematicChain* chain, Campaign& campaign)
      : source_(source),
        table_(table),
        chain_(chain),
        campaign_(campaign),
        columns_(find_campaign_columns(table, joints, campaign.source)),
        joined_(std::in_place, table, joints, chain, columns_, campaign) {
    campaign.temperature_names = columns_.context->temperature_names();
  }

  void read() {
    while (read_blocks()) {
    }
    joined_.reset();  // its indices of the names take 30 MB of a million poses
    if (campaign_.rows() == 0)
      throw InputError(campaign_.source + ": has no measured row (" +
                       std::to_string(campaign_.skipped_rows) + " without a measurement)");
    if (campaign_.contact_names.empty()) campaign_.touch.clear();
    if (campaign_.target_names.empty()) campaign_.target.clear();
    if ((columns_.distance || columns_.contact || columns_.corner) && columns_.has_points)
      sort_kinds();
    check_weights();
    check_profiles();
    check_repeats();
    if (chain_) moved_by_turns_ = move_into_travel(campaign_.q, campaign_.pose, *chain_);
    derive_arrival(campaign_);
  }

  const std::vector<std::string>& unknown_columns() const { return columns_.unknown; }
  const std::vector<MovedByTurns>& moved_by_turns() const { return moved_by_turns_; }

 private:
  // The next blocks of the file, on all cores; false at its end.
  bool read_blocks() {
    struct Block {
      int lines_before;
      std::string text;
    };
    std::vector<Block> blocks;
    while (blocks.size() < kBlocksAtOnce) {
      const int before = source_.line_number();
      std::string text = source_.next_block(kBytesPerBlock);
      if (text.empty()) break;
      blocks.push_back({before, std::move(text)});
    }
    for_ordered_blocks<CampaignPart>(
        static_cast<int>(blocks.size()), 1,
        [&](int begin, int) {
          Block& block = blocks[begin];
          Source lines(source_.name(), block.text, block.lines_before);
          CsvTable rows(table_, lines);
          return RowReader(rows, columns_, has_beams()).read();
        },
        [&](const CampaignPart& part) { joined_->append(part); });
    return blocks.size() == kBlocksAtOnce;
  }

  bool has_beams() const {
    return chain_ && std::ranges::count(chain_->contacts, ContactKind::beam, &Contact::kind) > 0;
  }

  // Clears what only rows of other kinds would use. Mixed rows of points and lengths become
  // coordinates.
  void sort_kinds() {
    Campaign& c = campaign_;
    int points = 0;
    for (int row = 0; row < c.rows(); ++row)
      points += c.kind(row) == ReadingKind::distance && c.distance[row] == 0;
    if (points == 0) {
      if (!c.has_pixels()) c.position.clear();
    } else if (points == c.rows()) {
      c.distance.clear();
      c.anchor.clear();
      c.anchor_names.clear();
      c.touch.clear();
    } else {
      const std::string both =
          c.source + (c.contact_names.empty() ? ": points and distances in one file "
                                              : ": points and contacts in one file ");
      if (c.has_orientation())
        throw InputError(both + "are read without orientations; leave out " +
                         (columns_.abc[0] ? "a_deg,b_deg,c_deg" : "qw,qx,qy,qz"));
      if (!columns_.sigma_position)
        throw InputError(both +
                         "also need the column 'sigma_mm', the standard deviation of each row, by "
                         "which they weigh against each other");
      points_to_coordinates(c);
    }
  }

  void check_weights() const {
    const Campaign& c = campaign_;
    if (!c.has_touches() || c.has_pixels() || columns_.sigma_position) return;
    const auto of_beams = std::ranges::count_if(c.contact_names, BeamName::is_one);
    if (of_beams > 0 && of_beams < std::ssize(c.contact_names))
      throw InputError(c.source +
                       ": beams and touches in one file also need the column 'sigma_mm', the "
                       "standard deviation of each row, by which they weigh against each other");
    if (c.has_touches_only()) return;
    throw InputError(c.source +
                     ": distances and contacts in one file also need the column "
                     "'sigma_mm', the standard deviation of each row, by which they "
                     "weigh against each other");
  }

  void check_profiles() {
    Campaign& c = campaign_;
    if (!c.has_profiles()) return;
    number_profile_points(c);
    constexpr double kShortestReading = 1e-3,
                     kLongestReading = 10;  // m, between them are the readings of any sensor
    double largest = 0;
    for (int row = 0; row < c.rows(); ++row) largest = std::max(largest, c.own_point(row).norm());
    if (largest < kShortestReading || largest > kLongestReading)
      throw InputError(fmt::format(
          "{}: profile_y_mm and profile_z_mm: the farthest point is {:.4g} mm from the sensor's "
          "origin, as no profile is; are these numbers in another unit? Columns in metres are "
          "named profile_y_m and profile_z_m",
          c.source, largest / kMillimetre));
  }

  void check_repeats() const {
    const Campaign& c = campaign_;
    if (c.repeat.empty()) return;
    const auto key = [&](int row) {
      return std::tuple(c.repeat[row], c.channel(row), c.session.empty() ? 0 : c.session[row]);
    };
    const GroupedRows by_pose = grouped_rows(c.pose);
    for (int pose = 0; pose < by_pose.groups(); ++pose) {
      const auto rows = by_pose.rows(pose);
      if (rows.size() < 2) continue;
      std::vector<int> order(rows.begin(), rows.end());
      std::ranges::stable_sort(order, {}, key);
      for (size_t i = 1; i < order.size(); ++i)
        if (key(order[i]) == key(order[i - 1]))
          throw InputError(fmt::format(
              "{}:{}: column 'repeat': repeat {} of pose '{}' already stands in line {}; number "
              "the readings of a pose 1, 2, 3 ...",
              c.source, c.line[order[i]], c.repeat[order[i]], c.pose_ids[c.pose[order[i]]],
              c.line[order[i - 1]]));
    }
  }

  Source& source_;
  const CsvTable& table_;
  const KinematicChain* chain_;  // null: the travels are not known
  Campaign& campaign_;
  CampaignColumns columns_;
  std::optional<JoinedCampaign> joined_;  // while the file is read
  std::vector<MovedByTurns> moved_by_turns_;
};

CampaignFile read_file(const std::string& path, const std::vector<JointName>& joints,
                       const KinematicChain* chain) {
  Source source(path);
  CampaignFile file;
  file.campaign.source = source.name();
  CsvTable table(source, example_header("pose,", joints, ",x_mm,y_mm,z_mm"));
  CampaignReader reader(source, table, joints, chain, file.campaign);
  reader.read();
  file.unknown_columns = reader.unknown_columns();
  file.moved_by_turns = reader.moved_by_turns();
  file.sha256 = source.sha256();
  return file;
}

}  // namespace

CampaignFile read_campaign(const std::string& path, const std::vector<JointName>& joints) {
  return read_file(path, joints, nullptr);
}

CampaignFile read_campaign(const std::string& path, const KinematicChain& chain) {
  return read_file(path, joint_names(chain), &chain);
}

}  // namespace armtrue
