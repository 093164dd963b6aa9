#include "armtrue/campaign/campaign.h"

#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

#include "armtrue/kinematics/names.h"

namespace armtrue {
namespace {

constexpr int kAxes = 3;  // of R_A, or of a contact

// Number of the quantities that are coordinates or distances from anchors.
int lengths(const Campaign& campaign) {
  return (campaign.has_coordinates() ? kAxes : 0) +
         std::max(1, static_cast<int>(campaign.anchor_names.size()));
}

}  // namespace

Context Campaign::context(int row) const {
  Context context;
  context.q = q[row];
  if (!arrival.empty()) context.arrival = arrival[row];
  if (!stroke.empty()) context.stroke = stroke[row];
  if (!time_s.empty()) context.time_s = time_s[row];
  if (!session.empty()) context.session = session_names[session[row]];
  if (!payload_kg.empty()) context.payload_kg = payload_kg[row];
  if (!motor_torque_nm.empty()) context.motor_torque_nm = motor_torque_nm[row];
  if (!force_n.empty()) context.force_n = force_n[row];
  if (!temperature_c.empty()) context.temperature_c = temperature_c[row];
  return context;
}

ReadingKind Campaign::kind(int row) const {
  if (!reads_one_number()) return ReadingKind::point;
  if (has_touches() && touch[row].contact >= 0)
    return touch[row].is_pixel ? ReadingKind::pixel : ReadingKind::touch;
  return has_coordinates() && coordinate[row] ? ReadingKind::coordinate : ReadingKind::distance;
}

bool Campaign::has_touches_only() const {
  return has_touches() &&
         std::ranges::all_of(touch, [](const Touch& own) { return own.contact >= 0; });
}

bool Campaign::has_beams_only() const {
  return has_touches_only() && !has_pixels() &&
         std::ranges::all_of(touch, [this](const Touch& own) {
           return BeamName::is_one(contact_names[own.contact]);
         });
}

int Campaign::quantity(int row) const {
  const ReadingKind of_row = kind(row);
  if (of_row == ReadingKind::touch || of_row == ReadingKind::pixel)
    return lengths(*this) + kAxes * touch[row].contact + std::max(0, touch[row].axis);
  if (of_row == ReadingKind::coordinate) return coordinate[row]->axis;
  return (has_coordinates() ? kAxes : 0) + (anchor.empty() ? 0 : anchor[row]);
}

int Campaign::quantities() const {
  return lengths(*this) + kAxes * static_cast<int>(contact_names.size());
}

void Campaign::set_quantity(int row, int quantity) {
  if (has_coordinates()) {
    coordinate[row].reset();
    if (quantity < kAxes) coordinate[row] = Coordinate{quantity, 0};
    quantity = std::max(0, quantity - kAxes);
  }
  if (!anchor.empty()) anchor[row] = quantity;
}

namespace {

// The axis of the coordinate that a row reads, of R_A or of a contact; -1 of a whole reading.
int axis_of(const Campaign& campaign, int row) {
  switch (campaign.kind(row)) {
    case ReadingKind::touch:
    case ReadingKind::pixel:
      return campaign.touch[row].axis;
    case ReadingKind::coordinate:
      return campaign.coordinate[row]->axis;
    default:
      return -1;
  }
}

// Whether two rows that follow each other read coordinates of one point.
bool is_continued(const Campaign& campaign, int row) {
  const int axis = axis_of(campaign, row), next = axis_of(campaign, row + 1);
  const auto differs = [row](const auto& column) {
    return !column.empty() && column[row] != column[row + 1];
  };
  if (axis < 0 || next <= axis || campaign.kind(row) != campaign.kind(row + 1)) return false;
  if (campaign.has_touches() && campaign.touch[row].contact != campaign.touch[row + 1].contact)
    return false;
  return !differs(campaign.pose) && !differs(campaign.line) && !differs(campaign.session);
}

}  // namespace

PixelName::PixelName(const std::string& name) {
  const size_t first = name.find('/'), second = name.find('/', first + 1);
  camera = name.substr(0, first);
  board = name.substr(first + 1, second - first - 1);
  corner = name.substr(second + 1);
}

std::vector<int> Campaign::first_rows_of_readings() const {
  if (!reads_one_number()) return {};
  std::vector<int> first;
  for (int row = 0; row < rows(); ++row)
    if (row == 0 || !is_continued(*this, row - 1)) first.push_back(row);
  if (std::ssize(first) == rows()) return {};
  return first;
}

int Campaign::readings() const {
  const std::vector<int> first = first_rows_of_readings();
  return first.empty() ? rows() : static_cast<int>(first.size());
}

std::vector<int> Campaign::lines_of(const std::vector<int>& rows) const {
  std::set<int> lines;
  for (int row : rows) lines.insert(line[row]);
  return {lines.begin(), lines.end()};
}

int Campaign::channel(int row) const {
  const int of_target = quantity(row) * targets() + (target.empty() ? 0 : target[row]);
  return of_target * longest_profile + (has_profiles() ? profile[row].number : 0);
}

int Campaign::pose_by_quantity(int row) const {
  return (pose[row] * quantities() + quantity(row)) * longest_profile +
         (has_profiles() ? profile[row].number : 0);
}

std::vector<int> Campaign::pose_by_id() const {
  std::vector<int> order(pose_ids.size());
  std::iota(order.begin(), order.end(), 0);
  // A number with more digits is the larger one.
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const std::string &of_a = pose_ids[a], &of_b = pose_ids[b];
    return of_a.size() != of_b.size() ? of_a.size() < of_b.size() : of_a < of_b;
  });
  std::vector<int> number(order.size());
  for (int i = 0; i < std::ssize(order); ++i) number[order[i]] = i;
  std::vector<int> numbers;
  for (int p : pose) numbers.push_back(number[p]);
  return numbers;
}

Campaign Campaign::select(const std::vector<int>& rows) const {
  Campaign chosen;
  chosen.source = source;
  std::vector<int> new_index(pose_ids.size(), -1);
  for (int row : rows) {
    int& index = new_index[pose[row]];
    if (index < 0) {
      index = chosen.poses();
      chosen.pose_ids.push_back(pose_ids[pose[row]]);
    }
    chosen.pose.push_back(index);
  }
  chosen.target_names = target_names;
  chosen.anchor_names = anchor_names;
  chosen.contact_names = contact_names;
  chosen.temperature_names = temperature_names;
  chosen.session_names = session_names;
  const auto pick = [&](const auto& from, auto& to) {
    if (from.empty()) return;
    to.reserve(rows.size());
    for (int row : rows) to.push_back(from[row]);
  };
  pick(line, chosen.line);
  pick(q, chosen.q);
  pick(position, chosen.position);
  pick(distance, chosen.distance);
  pick(coordinate, chosen.coordinate);
  pick(touch, chosen.touch);
  pick(profile, chosen.profile);
  chosen.longest_profile = longest_profile;
  chosen.metre_per_pixel = metre_per_pixel;
  pick(repeat, chosen.repeat);
  pick(orientation, chosen.orientation);
  pick(time_s, chosen.time_s);
  pick(target, chosen.target);
  pick(anchor, chosen.anchor);
  pick(sigma_position, chosen.sigma_position);
  pick(sigma_orientation, chosen.sigma_orientation);
  pick(whitening, chosen.whitening);
  pick(arrival, chosen.arrival);
  pick(stroke, chosen.stroke);
  pick(payload_kg, chosen.payload_kg);
  pick(motor_torque_nm, chosen.motor_torque_nm);
  pick(force_n, chosen.force_n);
  pick(temperature_c, chosen.temperature_c);
  pick(session, chosen.session);
  return chosen;
}

std::string missing_column(const Campaign& campaign, DriverKind kind, const std::string& where) {
  const auto& sensors = campaign.temperature_names;
  const size_t joints = campaign.q.empty() ? 6 : campaign.q.front().size();
  const auto numbered = [&](const std::string& name, const std::string& unit) {
    return name + "1" + unit + " to " + name + std::to_string(joints) + unit;
  };
  switch (kind) {
    case DriverKind::time:
      return campaign.time_s.empty() ? "t_s" : "";
    case DriverKind::temperature:
      return std::find(sensors.begin(), sensors.end(), where) == sensors.end()
                 ? "temp_" + where + "_c"
                 : "";
    case DriverKind::motor_torque:
      return campaign.motor_torque_nm.empty() ? numbered("tau", "_nm") : "";
    case DriverKind::arrival:
      return campaign.arrival.empty() ? numbered("dir", "") : "";
    case DriverKind::stroke:
      return campaign.stroke.empty() ? numbered("stroke", "_deg") : "";
    default:
      return "";
  }
}

std::vector<double> values_of(const Driver& driver, const Campaign& campaign) {
  if (driver.kind == DriverKind::time) return campaign.time_s;
  std::vector<double> values(campaign.rows());
  const auto sensor = std::ranges::find(campaign.temperature_names, driver.where) -
                      campaign.temperature_names.begin();
  for (size_t row = 0; row < values.size(); ++row)
    values[row] = driver.kind == DriverKind::temperature ? campaign.temperature_c[row][sensor]
                                                         : campaign.q[row][driver.joint];
  return values;
}

void require_drivers(const Campaign& campaign, const Effect& effect) {
  if (campaign.rows() == 0) return;
  for (const Effect& member : effect.members) require_drivers(campaign, member);
  const Driver& driver = effect.driver;
  std::string missing = missing_column(campaign, driver.kind, driver.where);
  if (missing.empty() && driver.factor)
    missing = missing_column(campaign, *driver.factor, driver.where);
  if (!missing.empty())
    throw std::invalid_argument(campaign.source + ": has no column " + missing +
                                ", and the effect '" + effect.name + "' makes " + to_string(effect.parameter) +
                                " follow " + to_string(driver) +
                                "; add it, or take the effect out of its file");
}

namespace {

bool has_length(const Campaign& campaign, int row) {
  return campaign.distance[row] > 0 || campaign.kind(row) != ReadingKind::distance;
}

// Each row as many times as axes(row) says.
template <typename Axes>
Campaign with_axes(const Campaign& campaign, const Axes& axes) {
  std::vector<int> rows;
  for (int row = 0; row < campaign.rows(); ++row) rows.insert(rows.end(), axes(row), row);
  Campaign all = campaign.select(rows);
  all.skipped_rows = campaign.skipped_rows;
  return all;
}

}  // namespace

void points_to_coordinates(Campaign& campaign) {
  Campaign all =
      with_axes(campaign, [&](int row) { return has_length(campaign, row) ? 1 : kAxes; });
  all.coordinate.resize(all.q.size());
  for (int row = 0, axis = 0; row < all.rows(); ++row) {
    if (has_length(all, row)) continue;
    all.coordinate[row] = Coordinate{axis, all.position[row][axis]};
    axis = (axis + 1) % kAxes;
  }
  if (!all.has_pixels()) all.position.clear();
  campaign = std::move(all);
}

void touches_to_coordinates(Campaign& campaign, const std::vector<bool>& is_point) {
  const auto axes_of = [&](const Campaign& readings, int row) {
    const Touch& touch = readings.touch[row];
    if (touch.is_pixel) return 2;
    return touch.contact >= 0 && is_point[touch.contact] ? kAxes : 1;
  };
  Campaign all = with_axes(campaign, [&](int row) { return axes_of(campaign, row); });
  for (int row = 0, axis = 0; row < all.rows(); ++row) {
    const int axes = axes_of(all, row);
    if (axes == 1) continue;
    all.touch[row].axis = axis;
    axis = (axis + 1) % axes;
  }
  campaign = std::move(all);
}

void number_profile_points(Campaign& campaign) {
  std::vector<int> points(campaign.pose_ids.size(), 0);
  for (size_t row = 0; row < campaign.profile.size(); ++row)
    campaign.profile[row].number = points[campaign.pose[row]]++;
  campaign.longest_profile = points.empty() ? 1 : std::max(1, *std::ranges::max_element(points));
}

double stated_position_noise(const Robot& robot, const Campaign& campaign) {
  return campaign.has_pixels_only() ? robot.noise.pixel * campaign.metre_per_pixel
                                    : robot.noise.position;
}

void for_each_visit(const Campaign& campaign, const VisitAction& action) {
  std::map<int, Arrival> sessions;
  std::vector<int> visits(campaign.q.size());
  std::iota(visits.begin(), visits.end(), 0);
  if (!campaign.time_s.empty())
    std::stable_sort(visits.begin(), visits.end(),
                     [&](int a, int b) { return campaign.time_s[a] < campaign.time_s[b]; });
  for (int row : visits) {
    const int session = campaign.session.empty() ? 0 : campaign.session[row];
    Arrival& arrival = sessions.try_emplace(session, campaign.q[row]).first->second;
    arrival.go_to(campaign.q[row]);
    action(row, arrival);
  }
}

void derive_arrival(Campaign& campaign) {
  if (campaign.q.empty()) return;
  const bool has_arrival = !campaign.arrival.empty(), has_stroke = !campaign.stroke.empty();
  campaign.arrival.resize(campaign.q.size());
  if (!has_stroke) campaign.stroke.resize(campaign.q.size(), campaign.q.front());
  bool agree = true;
  for_each_visit(campaign, [&](int row, const Arrival& arrival) {
    Direction& given = campaign.arrival[row];
    const Direction& derived = arrival.direction();
    if (!has_arrival) given = derived;
    for (size_t j = 0; j < derived.size(); ++j) agree &= derived[j] == 0 || derived[j] == given[j];
    if (!has_stroke) campaign.stroke[row] = arrival.stroke();
  });
  if (!has_stroke && !agree) campaign.stroke.clear();
}

void scale_angles(Campaign& campaign, const KinematicChain& chain, double factor) {
  for (int j = 0; j < joint_count(chain); ++j)
    if (!is_prismatic(joint_link(chain, j)))
      for (auto q : campaign.q) q[j] *= factor;
}

void begin_sessions(Campaign& campaign, const std::vector<double>& times_s) {
  std::vector<std::string> names;
  std::vector<int> sessions;
  for (int row = 0; row < campaign.rows(); ++row) {
    const auto part =
        std::to_string(1 + std::count_if(times_s.begin(), times_s.end(),
                                         [&](double t) { return t <= campaign.time_s[row]; }));
    std::string name = part;
    if (!campaign.session.empty()) {
      name = campaign.session_names[campaign.session[row]];
      if (part != "1") name += " (" + part + ")";
    }
    sessions.push_back(index_of(names, name));
  }
  campaign.session = std::move(sessions);
  campaign.session_names = std::move(names);
}

}  // namespace armtrue
