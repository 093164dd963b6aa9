#include "armtrue/io/campaign_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <unordered_set>

#include "armtrue/io/csv_table.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "io/joint_columns.h"

namespace armtrue {
namespace {

constexpr double kSameConfiguration = 0.1 * kDegree;  // [rad], of a travel [m]
constexpr double kUnitQuaternion = 1e-3;
constexpr double kAbsoluteZero = -273.15;  // deg C
constexpr const char* kDeviation = "a standard deviation";
constexpr const char* kNoId = "is empty; every row needs the id of its pose";

// Gives each text an index, in the order of first appearance.
class Index {
 public:
  explicit Index(std::vector<std::string>& names)
      : names_(names), places_(64, Hash{&names}, Equal{&names}) {}

  int of(std::string_view text) {
    if (!names_.empty() && names_.back() == text) return static_cast<int>(names_.size()) - 1;
    if (const auto found = places_.find(text); found != places_.end()) return *found;
    names_.emplace_back(text);
    const int place = static_cast<int>(names_.size()) - 1;
    places_.insert(place);
    return place;
  }

 private:
  struct Hash {
    using is_transparent = void;
    const std::vector<std::string>* names;
    size_t operator()(std::string_view text) const { return std::hash<std::string_view>{}(text); }
    size_t operator()(int place) const { return (*this)(std::string_view((*names)[place])); }
  };
  struct Equal {
    using is_transparent = void;
    const std::vector<std::string>* names;
    bool operator()(int a, int b) const { return a == b; }
    bool operator()(std::string_view text, int place) const { return (*names)[place] == text; }
    bool operator()(int place, std::string_view text) const { return (*names)[place] == text; }
  };
  std::vector<std::string>& names_;
  std::unordered_set<int, Hash, Equal> places_;
};

using Quantity = CsvTable::Quantity;

// Finds the columns of one file and appends its rows to a campaign.
class CampaignReader {
 public:
  CampaignReader(CsvTable& table, const std::vector<JointName>& joints, Campaign& campaign)
      : table_(table),
        joints_(joints),
        campaign_(campaign),
        poses_(campaign.pose_ids),
        targets_(campaign.target_names),
        anchors_(campaign.anchor_names),
        contacts_(campaign.contact_names),
        sessions_(campaign.session_names) {
    find_columns();
  }

  void read() {
    while (table_.next_row()) read_row();
    if (campaign_.rows() == 0)
      throw InputError(campaign_.source + ": has no measured row (" +
                       std::to_string(campaign_.skipped_rows) + " without a measurement)");
    if (campaign_.contact_names.empty()) campaign_.touch.clear();
    if ((distance_ || contact_) && has_points_) sort_kinds();
    check_weights();
    check_repeats();
    derive_arrival(campaign_);
  }

  std::vector<std::string> unknown_columns() const {
    std::vector<std::string> unknown;
    for (size_t c = 0; c < table_.columns().size(); ++c)
      if (!used_.contains(static_cast<int>(c))) unknown.push_back(table_.columns()[c]);
    return unknown;
  }

 private:
  template <typename Found>
  Found use(Found found) {
    if (found) {
      if constexpr (requires { found->column; })
        used_.insert(found->column);
      else
        used_.insert(*found);
    }
    return found;
  }

  void find_columns() {
    std::vector<std::string> missing;
    const auto need = [&](auto found, const std::string& name) {
      if (!use(found)) missing.push_back(name);
      return found;
    };
    pose_ = need(table_.find("pose"), "pose");
    q_ = find_encoders(table_, joints_);
    for (size_t j = 0; j < joints_.size(); ++j) need(q_[j], joints_[j].encoder());
    distance_ = use(table_.find_length("l"));
    contact_ = use(table_.find("contact"));
    for (int i = 0; i < 3; ++i) position_[i] = table_.find_length(std::string(1, "xyz"[i]));
    has_points_ =
        (!distance_ && !contact_) || position_[0] || position_[1] || position_[2];
    for (int i = 0; has_points_ && i < 3; ++i) need(position_[i], std::string(1, "xyz"[i]) + "_mm");
    if (!missing.empty()) table_.fail_missing(missing);

    repeat_ = use(table_.find("repeat"));
    time_ = use(table_.find("t_s"));
    target_ = use(table_.find("target"));
    if (distance_) anchor_ = use(table_.find("anchor"));
    session_ = use(table_.find("session"));
    payload_ = use(table_.find("payload_kg"));
    sigma_position_ = use(table_.find_length("sigma"));
    sigma_orientation_ = use(table_.find_angle("sigma"));
    abc_ = group("an orientation by angles",
                 std::array{table_.find_angle("a"), table_.find_angle("b"), table_.find_angle("c")},
                 {"a_deg", "b_deg", "c_deg"});
    quaternion_ = group(
        "an orientation by quaternion",
        std::array{table_.find("qw"), table_.find("qx"), table_.find("qy"), table_.find("qz")},
        {"qw", "qx", "qy", "qz"});
    if (abc_[0] && quaternion_[0])
      throw InputError(campaign_.source +
                       ": has both a_deg,b_deg,c_deg and qw,qx,qy,qz; keep one of them");
    force_ =
        group("a force", std::array{table_.find("fx_n"), table_.find("fy_n"), table_.find("fz_n")},
              {"fx_n", "fy_n", "fz_n"});
    const auto plain = [&](const std::vector<std::string>& names) {
      std::vector<std::optional<int>> found;
      for (const std::string& name : names) found.push_back(table_.find(name));
      return found;
    };
    const std::vector<std::string> directions = numbered_columns("dir", joints_);
    const std::vector<std::string> torques = numbered_columns("tau", joints_, "_nm");
    arrival_ = group("directions of arrival", plain(directions), directions);
    stroke_ = group("ways since the last reversal", find_strokes(table_, joints_),
                    stroke_columns(joints_));
    motor_torque_ = group("a set of motor torques", plain(torques), torques);
    for (size_t c = 0; c < table_.columns().size(); ++c) {
      const std::string& name = table_.columns()[c];
      if (!name.starts_with("temp_") || !name.ends_with("_c") || name.size() < 8) continue;
      if (temperatures_.size() == kMaxTemperatures)
        table_.fail(static_cast<int>(c), "more than 8 temperatures; remove the least useful");
      temperatures_.push_back(static_cast<int>(c));
      used_.insert(static_cast<int>(c));
      campaign_.temperature_names.push_back(name.substr(5, name.size() - 7));
    }
  }

  // Columns of one quantity: all of them, or none.
  template <typename Columns>
  Columns group(const std::string& what, const Columns& columns,
                const std::vector<std::string>& names) {
    std::vector<std::string> missing;
    for (size_t i = 0; i < columns.size(); ++i)
      if (!columns[i]) missing.push_back(names[i]);
    if (missing.size() == columns.size()) return columns;
    if (!missing.empty())
      throw InputError(campaign_.source + ": " + what + " also needs the column '" +
                       missing.front() + "'");
    for (const auto& column : columns) use(column);
    return columns;
  }

  bool has_distance() const { return distance_ && !table_.is_empty(distance_->column); }

  bool has_touch() const { return contact_ && !table_.is_empty(*contact_); }

  bool has_point() const {
    const auto filled = [&](const auto& quantity) { return !table_.is_empty(quantity->column); };
    return has_points_ && std::any_of(position_.begin(), position_.end(), filled);
  }

  void read_row() {
    if (!has_point() && !has_distance() && !has_touch()) {
      ++campaign_.skipped_rows;
      return;
    }
    Campaign& c = campaign_;
    if (table_.is_empty(*pose_)) table_.fail(*pose_, kNoId);
    const int pose = poses_.of(table_.text(*pose_));
    const JointVector q = numbers(q_);
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
    if (repeat_) c.repeat.push_back(table_.integer(*repeat_));
    if (time_) c.time_s.push_back(table_.number(*time_));
    if (target_) c.target.push_back(targets_.of(table_.text(*target_)));
    if (session_) c.session.push_back(sessions_.of(table_.text(*session_)));
    if (payload_) c.payload_kg.push_back(payload());
    if (sigma_position_) c.sigma_position.push_back(positive(*sigma_position_, kDeviation));
    if (sigma_orientation_)
      c.sigma_orientation.push_back(positive(*sigma_orientation_, kDeviation));
    if (force_[0])
      c.force_n.emplace_back(table_.number(*force_[0]), table_.number(*force_[1]),
                             table_.number(*force_[2]));
    if (arrival_[0]) {
      Direction directions{};
      for (size_t j = 0; j < arrival_.size(); ++j) {
        const int direction = table_.integer(*arrival_[j]);
        if (direction < -1 || direction > 1)
          table_.fail(*arrival_[j], "'" + std::to_string(direction) + "' is not -1, 0 or 1");
        directions[j] = static_cast<std::int8_t>(direction);
      }
      c.arrival.push_back(directions);
    }
    if (stroke_[0]) c.stroke.push_back(numbers(stroke_));
    if (motor_torque_[0]) {
      auto& torques = c.motor_torque_nm.emplace_back();
      for (size_t j = 0; j < motor_torque_.size(); ++j)
        torques[j] = table_.number(*motor_torque_[j]);
    }
    if (!temperatures_.empty()) {
      auto& temperatures = c.temperature_c.emplace_back();
      for (size_t i = 0; i < temperatures_.size(); ++i) {
        temperatures[i] = table_.number(temperatures_[i]);
        if (temperatures[i] < kAbsoluteZero)
          table_.fail(temperatures_[i],
                      table_.quoted(temperatures_[i]) + " lies below absolute zero; correct it");
      }
    }
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
    if (distance_ || contact_) c.distance.push_back(0);
    if (anchor_) c.anchor.push_back(0);
    if (contact_) c.touch.emplace_back();
    c.position.emplace_back(table_.number(*position_[0]), table_.number(*position_[1]),
                            table_.number(*position_[2]));
    if (abc_[0])
      c.orientation.emplace_back(rotation_from_abc(table_.number(*abc_[0]), table_.number(*abc_[1]),
                                                   table_.number(*abc_[2])));
    if (quaternion_[0]) c.orientation.push_back(quaternion());
  }

  void read_distance() {
    Campaign& c = campaign_;
    if (has_point())
      table_.fail(distance_->column, table_.quoted(distance_->column) +
                                         " stands beside a point; a row is either a distance or a "
                                         "point: empty the other's cells");
    if (has_points_) c.position.emplace_back(0, 0, 0);
    if (contact_) c.touch.emplace_back();
    refuse_orientation();
    c.distance.push_back(positive(*distance_, "a distance"));
    if (anchor_) {
      if (table_.is_empty(*anchor_))
        table_.fail(*anchor_, "is empty; every distance needs the name of its anchor");
      c.anchor.push_back(anchors_.of(table_.text(*anchor_)));
    }
  }

  // `l_mm` beside a contact is what a gauge shows, of either sign.
  void read_touch() {
    Campaign& c = campaign_;
    if (has_point())
      table_.fail(*contact_, "a row with the contact " + table_.quoted(*contact_) +
                                 " has a point, too; a row is either: empty the other's cells");
    if (anchor_ && !table_.is_empty(*anchor_))
      table_.fail(*anchor_, table_.quoted(*anchor_) +
                                " stands beside a contact; a distance from an anchor is a row of "
                                "its own: empty the cell");
    refuse_orientation();
    if (has_points_) c.position.emplace_back(0, 0, 0);
    if (anchor_) c.anchor.push_back(0);
    c.distance.push_back(has_distance() ? table_.number(*distance_) : 0.0);
    c.touch.push_back({contacts_.of(table_.text(*contact_)), -1});
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
                         (abc_[0] ? "a_deg,b_deg,c_deg" : "qw,qx,qy,qz"));
      if (!sigma_position_)
        throw InputError(both +
                         "also need the column 'sigma_mm', the standard deviation of each row, by "
                         "which they weigh against each other");
      points_to_coordinates(c);
    }
  }

  void check_weights() const {
    const Campaign& c = campaign_;
    if (!c.has_touches() || c.has_touches_only() || sigma_position_) return;
    throw InputError(c.source + ": distances and contacts in one file also need the column "
                                "'sigma_mm', the standard deviation of each row, by which they "
                                "weigh against each other");
  }

  void refuse_orientation() const {
    for (const auto& angle : abc_)
      if (angle && !table_.is_empty(angle->column)) fail_orientation(angle->column);
    for (const auto& component : quaternion_)
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
    const double value = table_.number(*payload_);
    if (value < 0)
      table_.fail(*payload_, table_.quoted(*payload_) + " is below zero; a payload is a mass");
    return value;
  }

  Eigen::Quaterniond quaternion() const {
    const Eigen::Quaterniond q(table_.number(*quaternion_[0]), table_.number(*quaternion_[1]),
                               table_.number(*quaternion_[2]), table_.number(*quaternion_[3]));
    if (std::abs(q.norm() - 1) > kUnitQuaternion)
      table_.fail(*quaternion_[0], fmt::format("the quaternion has norm {:.4g}, not 1; are the "
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
        table_.fail(q_[k]->column,
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
  Index poses_, targets_, anchors_, contacts_, sessions_;
  std::set<int> used_;
  std::vector<int> first_row_of_pose_;

  std::optional<int> pose_, repeat_, time_, target_, anchor_, contact_, session_, payload_;
  std::optional<Quantity> distance_;
  bool has_points_ = true;  // columns
  std::vector<std::optional<Quantity>> q_, stroke_;
  std::array<std::optional<Quantity>, 3> position_, abc_;
  std::array<std::optional<int>, 4> quaternion_;
  std::array<std::optional<int>, 3> force_;
  std::vector<std::optional<int>> arrival_, motor_torque_;
  std::optional<Quantity> sigma_position_, sigma_orientation_;
  std::vector<int> temperatures_;
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

std::string write_campaign(const Campaign& campaign, const std::vector<JointName>& joints) {
  std::string text = "pose";
  if (!campaign.repeat.empty()) text += ",repeat";
  if (!campaign.time_s.empty()) text += ",t_s";
  for (const JointName& joint : joints) text += "," + joint.encoder();
  text += campaign.has_distances() ? ",l_mm" : ",x_mm,y_mm,z_mm";
  if (campaign.has_orientation()) text += ",a_deg,b_deg,c_deg";
  if (!campaign.target.empty()) text += ",target";
  if (!campaign.anchor.empty()) text += ",anchor";
  if (!campaign.arrival.empty())
    for (const std::string& name : numbered_columns("dir", joints)) text += "," + name;
  if (!campaign.session.empty()) text += ",session";
  if (!campaign.payload_kg.empty()) text += ",payload_kg";
  for (const std::string& name : campaign.temperature_names) text += ",temp_" + name + "_c";
  text += "\n";
  for (int row = 0; row < campaign.rows(); ++row) {
    text += campaign.pose_ids[campaign.pose[row]];
    const auto add = [&](const std::string& cell) { (text += ",") += cell; };
    if (!campaign.repeat.empty()) add(std::to_string(campaign.repeat[row]));
    if (!campaign.time_s.empty()) add(number_text(campaign.time_s[row]));
    for (size_t j = 0; j < joints.size(); ++j)
      add(number_text(campaign.q[row][static_cast<Eigen::Index>(j)], joints[j].si()));
    if (campaign.has_distances())
      add(number_text(campaign.distance[row], kMillimetre));
    else
      for (int i = 0; i < 3; ++i) add(number_text(campaign.position[row][i], kMillimetre));
    if (campaign.has_orientation()) {
      const Eigen::Vector3d abc = abc_from_rotation(campaign.orientation[row].toRotationMatrix());
      for (int i = 0; i < 3; ++i) add(number_text(abc[i], kDegree));
    }
    if (!campaign.target.empty()) add(campaign.target_names[campaign.target[row]]);
    if (!campaign.anchor.empty()) add(campaign.anchor_names[campaign.anchor[row]]);
    if (!campaign.arrival.empty())
      for (size_t j = 0; j < joints.size(); ++j) add(std::to_string(campaign.arrival[row][j]));
    if (!campaign.session.empty()) add(campaign.session_names[campaign.session[row]]);
    if (!campaign.payload_kg.empty()) add(number_text(campaign.payload_kg[row]));
    for (size_t k = 0; k < campaign.temperature_names.size(); ++k)
      add(number_text(campaign.temperature_c[row][k]));
    text += "\n";
  }
  return text;
}

}  // namespace armtrue
