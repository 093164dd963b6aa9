#include "armtrue/io/campaign_io.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <tuple>

#include "armtrue/io/csv_table.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "io/campaign_columns.h"
#include "io/joint_columns.h"
#include "io/text_index.h"

namespace armtrue {
namespace {

constexpr double kSameConfiguration = 0.1 * kDegree;  // [rad], of a travel [m]
constexpr double kUnitQuaternion = 1e-3;
constexpr double kAbsoluteZero = -273.15;  // deg C
constexpr const char* kDeviation = "a standard deviation";
constexpr const char* kNoId = "is empty; every row needs the id of its pose";

using Quantity = CsvTable::Quantity;

// Appends the rows of one file to a campaign.
class CampaignReader {
 public:
  CampaignReader(CsvTable& table, const std::vector<JointName>& joints, Campaign& campaign)
      : table_(table),
        joints_(joints),
        campaign_(campaign),
        columns_(find_campaign_columns(table, joints, campaign.source)),
        poses_(campaign.pose_ids),
        targets_(campaign.target_names),
        anchors_(campaign.anchor_names),
        contacts_(campaign.contact_names),
        sessions_(campaign.session_names) {
    campaign.temperature_names = columns_.temperature_names;
  }

  void read() {
    while (table_.next_row()) read_row();
    if (campaign_.rows() == 0)
      throw InputError(campaign_.source + ": has no measured row (" +
                       std::to_string(campaign_.skipped_rows) + " without a measurement)");
    if (campaign_.contact_names.empty()) campaign_.touch.clear();
    if ((columns_.distance || columns_.contact) && columns_.has_points) sort_kinds();
    check_weights();
    check_repeats();
    derive_arrival(campaign_);
  }

  const std::vector<std::string>& unknown_columns() const { return columns_.unknown; }

 private:
  bool has_distance() const {
    return columns_.distance && !table_.is_empty(columns_.distance->column);
  }

  bool has_touch() const { return columns_.contact && !table_.is_empty(*columns_.contact); }

  bool has_point() const {
    const auto filled = [&](const auto& quantity) { return !table_.is_empty(quantity->column); };
    return columns_.has_points &&
           std::any_of(columns_.position.begin(), columns_.position.end(), filled);
  }

  void read_row() {
    if (!has_point() && !has_distance() && !has_touch()) {
      ++campaign_.skipped_rows;
      return;
    }
    Campaign& c = campaign_;
    if (table_.is_empty(*columns_.pose)) table_.fail(*columns_.pose, kNoId);
    const int pose = poses_.of(table_.text(*columns_.pose));
    const JointVector q = numbers(columns_.q);
    check_configuration(pose, q);
    c.pose.push_back(pose);
    c.line.push_back(table_.line_number());
    c.q.push_back(q);
    if (has_touch())
      read_touch();
    else if (has_distance())
      read_distance();
    else
      read_point();
    if (columns_.repeat) c.repeat.push_back(table_.integer(*columns_.repeat));
    if (columns_.time) c.time_s.push_back(table_.number(*columns_.time));
    if (columns_.target) c.target.push_back(targets_.of(table_.text(*columns_.target)));
    if (columns_.session) c.session.push_back(sessions_.of(table_.text(*columns_.session)));
    if (columns_.payload) c.payload_kg.push_back(payload());
    if (columns_.sigma_position)
      c.sigma_position.push_back(positive(*columns_.sigma_position, kDeviation));
    if (columns_.sigma_orientation)
      c.sigma_orientation.push_back(positive(*columns_.sigma_orientation, kDeviation));
    read_covariance();
    if (columns_.force[0])
      c.force_n.emplace_back(table_.number(*columns_.force[0]), table_.number(*columns_.force[1]),
                             table_.number(*columns_.force[2]));
    if (columns_.arrival[0]) {
      Direction directions{};
      for (size_t j = 0; j < columns_.arrival.size(); ++j) {
        const int direction = table_.integer(*columns_.arrival[j]);
        if (direction < -1 || direction > 1)
          table_.fail(*columns_.arrival[j],
                      "'" + std::to_string(direction) + "' is not -1, 0 or 1");
        directions[j] = static_cast<std::int8_t>(direction);
      }
      c.arrival.push_back(directions);
    }
    if (columns_.stroke[0]) c.stroke.push_back(numbers(columns_.stroke));
    if (columns_.motor_torque[0]) {
      auto& torques = c.motor_torque_nm.emplace_back();
      for (size_t j = 0; j < columns_.motor_torque.size(); ++j)
        torques[j] = table_.number(*columns_.motor_torque[j]);
    }
    if (!columns_.temperatures.empty()) {
      auto& temperatures = c.temperature_c.emplace_back();
      for (size_t i = 0; i < columns_.temperatures.size(); ++i) {
        temperatures[i] = table_.number(columns_.temperatures[i]);
        if (temperatures[i] < kAbsoluteZero)
          table_.fail(columns_.temperatures[i], table_.quoted(columns_.temperatures[i]) +
                                                    " lies below absolute zero; correct it");
      }
    }
  }

  // What a row states of its noise, as standard deviations and what makes its components white.
  void read_covariance() {
    constexpr size_t kOfRotation = place_of_covariance(3, 3);
    const bool of_position = columns_.covariance[0].has_value();
    const bool of_rotation = columns_.covariance[kOfRotation].has_value();
    if (!of_position && !of_rotation) return;
    Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
    for (int i = 0; i < 6; ++i)
      for (int k = i; k < 6; ++k)
        if (const auto& column = columns_.covariance[place_of_covariance(i, k)])
          covariance(i, k) = covariance(k, i) = table_.number(*column);
    const double position = std::sqrt(covariance.topLeftCorner<3, 3>().trace() / 3);
    const double rotation = std::sqrt(covariance.bottomRightCorner<3, 3>().trace() / 3);
    Eigen::Matrix<double, 6, 1> deviation;
    deviation << Eigen::Vector3d::Constant(position), Eigen::Vector3d::Constant(rotation);
    const Eigen::Matrix<double, 6, 6> shape =
        deviation.cwiseInverse().asDiagonal() * covariance * deviation.cwiseInverse().asDiagonal();
    const Eigen::LLT<Eigen::Matrix<double, 6, 6>> llt(shape);
    if (!(position > 0) || !(rotation > 0) || llt.info() != Eigen::Success)
      table_.fail(columns_.covariance[of_position ? 0 : kOfRotation]->column,
                  "the covariance of this row is not positive definite: variances are above zero, "
                  "and no covariance is beyond the root of the product of its two variances");
    if (of_position) campaign_.sigma_position.push_back(position);
    if (of_rotation) campaign_.sigma_orientation.push_back(rotation);
    campaign_.whitening.emplace_back(
        llt.matrixL().solve(Eigen::Matrix<double, 6, 6>::Identity()));
  }

  // One number per joint.
  JointVector numbers(const std::vector<std::optional<Quantity>>& columns) const {
    JointVector values(static_cast<Eigen::Index>(columns.size()));
    for (size_t j = 0; j < columns.size(); ++j)
      values[static_cast<Eigen::Index>(j)] = table_.number(*columns[j]);
    return values;
  }

  void read_point() {
    Campaign& c = campaign_;
    if (columns_.distance || columns_.contact) c.distance.push_back(0);
    if (columns_.anchor) c.anchor.push_back(0);
    if (columns_.contact) c.touch.emplace_back();
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
    Campaign& c = campaign_;
    if (has_point())
      table_.fail(columns_.distance->column,
                  table_.quoted(columns_.distance->column) +
                      " stands beside a point; a row is either a distance or a "
                      "point: empty the other's cells");
    if (columns_.has_points) c.position.emplace_back(0, 0, 0);
    if (columns_.contact) c.touch.emplace_back();
    refuse_orientation();
    c.distance.push_back(positive(*columns_.distance, "a distance"));
    if (columns_.anchor) {
      if (table_.is_empty(*columns_.anchor))
        table_.fail(*columns_.anchor, "is empty; every distance needs the name of its anchor");
      c.anchor.push_back(anchors_.of(table_.text(*columns_.anchor)));
    }
  }

  // `l_mm` beside a contact is what a gauge shows, of either sign.
  void read_touch() {
    Campaign& c = campaign_;
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
    if (columns_.has_points) c.position.emplace_back(0, 0, 0);
    if (columns_.anchor) c.anchor.push_back(0);
    c.distance.push_back(has_distance() ? table_.number(*columns_.distance) : 0.0);
    c.touch.push_back({contacts_.of(table_.text(*columns_.contact)), -1});
  }

  // A file with columns for points and for distances may have rows of one kind only.
  void sort_kinds() {
    Campaign& c = campaign_;
    int points = 0;
    for (int row = 0; row < c.rows(); ++row)
      points += c.kind(row) == ReadingKind::distance && c.distance[row] == 0;
    if (points == 0) {
      c.position.clear();
    } else if (points == c.rows()) {
      c.distance.clear();
      c.anchor.clear();
      c.anchor_names.clear();
      c.touch.clear();
    } else {
      const std::string both = c.source + (c.contact_names.empty()
                                               ? ": points and distances in one file "
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
    if (!c.has_touches() || c.has_touches_only() || columns_.sigma_position) return;
    throw InputError(c.source + ": distances and contacts in one file also need the column "
                                "'sigma_mm', the standard deviation of each row, by which they "
                                "weigh against each other");
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
    if (value <= 0)
      table_.fail(quantity.column,
                  table_.quoted(quantity.column) + ": " + what + " must be above zero");
    return value;
  }

  double payload() const {
    const double value = table_.number(*columns_.payload);
    if (value < 0)
      table_.fail(*columns_.payload,
                  table_.quoted(*columns_.payload) + " is below zero; a payload is a mass");
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

  void check_configuration(int pose, const JointVector& q) {
    if (pose == static_cast<int>(first_row_of_pose_.size())) {
      first_row_of_pose_.push_back(campaign_.rows());
      return;
    }
    const int first = first_row_of_pose_[pose];
    for (size_t k = 0; k < joints_.size(); ++k) {
      const auto j = static_cast<Eigen::Index>(k);
      const double difference = std::abs(q[j] - campaign_.q[first][j]);
      if (difference > kSameConfiguration)
        table_.fail(columns_.q[k]->column,
                    fmt::format("pose '{}' stands {:.4g} {} away from its reading in line {}; rows "
                                "that share a pose id are replicates of one configuration: give "
                                "different configurations different ids",
                                campaign_.pose_ids[pose], difference / joints_[k].si(),
                                joints_[k].unit(), campaign_.line[first]));
    }
  }

  void check_repeats() const {
    const Campaign& c = campaign_;
    if (c.repeat.empty()) return;
    std::vector<int> order(c.rows());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](int row) {
      return std::tuple(c.pose[row], c.repeat[row], c.channel(row),
                        c.session.empty() ? 0 : c.session[row]);
    };
    std::sort(order.begin(), order.end(),
              [&](int a, int b) { return std::tuple(key(a), a) < std::tuple(key(b), b); });
    for (size_t i = 1; i < order.size(); ++i)
      if (key(order[i]) == key(order[i - 1]))
        throw InputError(fmt::format(
            "{}:{}: column 'repeat': repeat {} of pose '{}' already stands in line {}; number the "
            "readings of a pose 1, 2, 3 ...",
            c.source, c.line[order[i]], c.repeat[order[i]], c.pose_ids[c.pose[order[i]]],
            c.line[order[i - 1]]));
  }

  CsvTable& table_;
  const std::vector<JointName>& joints_;
  Campaign& campaign_;
  CampaignColumns columns_;
  TextIndex poses_, targets_, anchors_, contacts_, sessions_;
  std::vector<int> first_row_of_pose_;
};

}  // namespace

CampaignFile read_campaign(const std::string& path, const std::vector<JointName>& joints) {
  Source source(path);
  CampaignFile file;
  file.campaign.source = source.name();
  CsvTable table(source, example_header("pose,", joints, ",x_mm,y_mm,z_mm"));
  CampaignReader reader(table, joints, file.campaign);
  reader.read();
  file.unknown_columns = reader.unknown_columns();
  file.sha256 = source.sha256();
  return file;
}

}  // namespace armtrue
