#include "armtrue/diagnosis/log_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "armtrue/campaign/grouped_rows.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"
#include "armtrue/text/edit_distance.h"
#include "diagnosis/lost_values.h"
#include "statistics/rounding.h"

namespace armtrue {
namespace {

constexpr int kFewestRows = 10;

bool stands_still(const Campaign& campaign) {
  const auto [least, largest] = std::ranges::minmax(campaign.time_s);
  return least == largest;
}

enum class Time { counts, is_left_out };

// All readings of a row, for a comparison of rows.
auto reading(const Campaign& c, int row, Time time) {
  std::array<double, kMaxJoints + 3 + 1 + 4 + 1> numbers{};
  auto next = std::copy_n(c.q[row].data(), c.q[row].size(), numbers.begin());
  if (!c.position.empty()) next = std::copy_n(c.position[row].data(), 3, next);
  if (c.reads_one_number()) *next++ = c.length(row);
  if (c.has_orientation()) next = std::copy_n(c.orientation[row].coeffs().data(), 4, next);
  if (time == Time::counts && !c.time_s.empty()) *next = c.time_s[row];
  return numbers;
}

std::tuple<int, int, int> place_of(const Campaign& c, int row) {
  return {c.pose[row], c.session.empty() ? 0 : c.session[row], c.channel(row)};
}

struct Copies {
  int count = 0;
  int first = 0, second = 0;  // rows: the first one that is a copy, and of which
};

Copies find_copies(const Campaign& campaign, Time time) {
  const auto of = [&](int row) { return reading(campaign, row, time); };
  Copies copies;
  copies.second = campaign.rows();
  const GroupedRows by_pose = grouped_rows(campaign.pose);
  for (int pose = 0; pose < by_pose.groups(); ++pose) {
    const auto rows = by_pose.rows(pose);
    if (rows.size() < 2) continue;
    std::vector<int> order(rows.begin(), rows.end());
    std::ranges::stable_sort(order, [&](int a, int b) {
      const auto of_a = place_of(campaign, a), of_b = place_of(campaign, b);
      return of_a != of_b ? of_a < of_b : of(a) < of(b);
    });
    for (size_t k = 1; k < order.size(); ++k) {
      if (place_of(campaign, order[k]) != place_of(campaign, order[k - 1]) ||
          of(order[k]) != of(order[k - 1]))
        continue;
      ++copies.count;
      if (order[k] > copies.second) continue;
      copies.first = order[k - 1];
      copies.second = order[k];
    }
  }
  return copies;
}

// Rows of several numbers have copies of their own, see copied_rows().
void check_doubled(const Campaign& campaign, Findings& findings) {
  const auto what = [&](const Copies& copies, const char* included) {
    return fmt::format("{} of {} rows hold the same as another{}: line {} as line {}", copies.count,
                       campaign.rows(), included, campaign.line[copies.second],
                       campaign.line[copies.first]);
  };
  if (!campaign.repeat.empty()) return;
  if (!campaign.time_s.empty() && !stands_still(campaign))
    if (const Copies copies = find_copies(campaign, Time::counts); copies.count > 0) {
      findings.errors.push_back(what(copies, ", time included") +
                                "; a reading counts once: remove the copies");
      return;
    }
  if (!campaign.reads_one_number() && !campaign.has_touches()) return;
  const Copies copies = find_copies(campaign, Time::is_left_out);
  if (copies.count > 0 && 4 * copies.count >= campaign.rows())
    findings.warnings.push_back(what(copies, campaign.time_s.empty() ? "" : ", but for the time") +
                                "; if they are copies, remove them: they would count as repeats "
                                "that agree, and the noise would look too small");
}

// The same readings in two sessions: two instruments, or two visits, never read alike.
void check_copied_sessions(const Campaign& campaign, Findings& findings) {
  if (campaign.session_names.size() < 2) return;
  Campaign in_one = campaign;
  in_one.session.clear();
  const Copies copies = find_copies(in_one, Time::is_left_out);
  if (4 * copies.count < campaign.rows() ||
      campaign.session[copies.first] == campaign.session[copies.second])
    return;
  findings.warnings.push_back(fmt::format(
      "{} of {} rows hold the same as another in another session: line {} as line {}; if they are "
      "copies, remove them: a reading counts once",
      copies.count, campaign.rows(), campaign.line[copies.second], campaign.line[copies.first]));
}

// One number in place of a point, in rows of several poses: an instrument that lost its target
// writes 0 or -9999. Zeros may be a reference point that is the origin of R_A.
void check_lost_readings(const Campaign& campaign, Findings& findings) {
  if (campaign.rows() < kFewestRows || campaign.position.empty()) return;
  std::map<double, std::vector<int>> rows_of;
  for (int row = 0; row < campaign.rows(); ++row)
    if (const Eigen::Vector3d& point = campaign.position[row];
        point.x() == point.y() && point.y() == point.z())
      rows_of[point.x()].push_back(row);
  for (const auto& number_and_rows : rows_of) {
    const std::vector<int>& rows = number_and_rows.second;
    const bool is_one_pose = std::ranges::all_of(
        rows, [&](int row) { return campaign.pose[row] == campaign.pose[rows.front()]; });
    if (is_one_pose || 2 * std::ssize(rows) > campaign.rows()) continue;
    const double number = number_and_rows.first / kMillimetre;
    (number == 0 ? findings.warnings : findings.errors)
        .push_back(fmt::format(
            "{} rows have {:g} mm in x, y and z, such as lines {} and {}: a mark of lost readings? "
            "Empty these cells, or remove the rows",
            rows.size(), number, campaign.line[rows.front()], campaign.line[rows.back()]));
  }
}

// One point to the last digit at several joint angles: an instrument that stopped while the arm
// went on. Where many rows are so, the arm was driven to a few known places, such as nests.
void check_frozen_readings(const Campaign& campaign, Findings& findings) {
  constexpr size_t kFewestStops = 3;
  constexpr int kOneStoppedOf = 4;  // of the rows: one of so many
  constexpr double kMoved = 1e-2;   // [rad or m]; less is how repeats of one pose scatter
  if (campaign.rows() < kFewestRows || campaign.position.empty()) return;
  using Point = std::array<double, 3>;
  std::map<Point, std::vector<int>> rows_of;
  for (int row = 0; row < campaign.rows(); ++row) {
    const Eigen::Vector3d& point = campaign.position[row];
    if (point.x() != point.y() || point.y() != point.z())  // else a mark, see above
      rows_of[{point.x(), point.y(), point.z()}].push_back(row);
  }
  std::vector<int> frozen;
  for (const auto& point_and_rows : rows_of) {
    const std::vector<int>& rows = point_and_rows.second;
    std::vector<int> stops;  // a row of each
    for (const int row : rows)
      if (stops.size() < kFewestStops && std::ranges::all_of(stops, [&](int stop) {
            return (campaign.q[row] - campaign.q[stop]).cwiseAbs().maxCoeff() > kMoved;
          }))
        stops.push_back(row);
    if (stops.size() >= kFewestStops) frozen.insert(frozen.end(), rows.begin(), rows.end());
  }
  if (frozen.empty() || kOneStoppedOf * std::ssize(frozen) > campaign.rows()) return;
  std::ranges::sort(frozen);
  findings.errors.push_back(fmt::format(
      "{} rows have the same x, y and z as others at other joint angles, to the last digit, lines "
      "{} to {}: did the instrument stop while the arm went on? Remove these rows",
      frozen.size(), campaign.line[frozen.front()], campaign.line[frozen.back()]));
}

// Rows that state a standard deviation in another unit than the others. Those of covariances may
// state axes that nobody knows.
void check_unit_of_sigma(const Campaign& campaign, Findings& findings) {
  constexpr double kMostTimes = 200;  // um among mm are a thousand
  if (!campaign.whitening.empty()) return;
  for (const auto& [column, sigma, unit] :
       {std::tuple("sigma_mm", &campaign.sigma_position, kMillimetre),
        std::tuple("sigma_deg", &campaign.sigma_orientation, kDegree)}) {
    if (sigma->empty()) continue;
    const auto [least, largest] = std::ranges::minmax_element(*sigma);
    if (*largest <= kMostTimes * *least) continue;
    findings.warnings.push_back(fmt::format(
        "{} is {:.4g} in line {} and {:.4g} in line {}: are these one unit? It weighs the rows, "
        "and makes the noise floor",
        column, *least / unit, campaign.line[least - sigma->begin()], *largest / unit,
        campaign.line[largest - sigma->begin()]));
  }
}

// `Day 1`, `day1` and `DAY1` are one name.
std::string without_case_and_blanks(std::string name) {
  std::erase_if(name, [](unsigned char c) { return std::isspace(c) != 0; });
  return lower_case(name);
}

// A slip of the pen makes a session, whose own base takes up what the readings show of the arm.
void check_session_names(const Campaign& campaign, Findings& findings) {
  const std::vector<std::string>& names = campaign.session_names;
  std::vector<int> lines(names.size());  // of the first reading
  for (int row = campaign.rows() - 1; !campaign.session.empty() && row >= 0; --row)
    lines[campaign.session[row]] = campaign.line[row];
  std::map<std::string, size_t> sessions;
  for (size_t session = 0; session < names.size(); ++session) {
    if (lines[session] == 0) continue;
    const auto [known, is_new] =
        sessions.try_emplace(without_case_and_blanks(names[session]), session);
    if (is_new) continue;
    findings.warnings.push_back(fmt::format(
        "the sessions '{}' (line {}) and '{}' (line {}) differ in case or blanks alone, and each "
        "gets a base of its own: if they are one, write one name",
        names[known->second], lines[known->second], names[session], lines[session]));
  }
}

// 273 K is the melting point of ice, and no arm is as hot as that in deg C.
void check_unit_of_temperature(const Campaign& campaign, Findings& findings) {
  constexpr double kColdest = 233, kHottest = 373;  // K
  if (campaign.temperature_c.empty()) return;
  for (size_t sensor = 0; sensor < campaign.temperature_names.size(); ++sensor) {
    const auto [least, largest] = std::ranges::minmax(campaign.temperature_c, {},
                                                      [&](const auto& row) { return row[sensor]; });
    if (least[sensor] < kColdest || largest[sensor] > kHottest) continue;
    findings.warnings.push_back(fmt::format(
        "temp_{}_c is {:g} to {:g} deg C in all rows: are these kelvin? Take 273.15 off",
        campaign.temperature_names[sensor], least[sensor], largest[sensor]));
  }
}

// Whether a sensor is on a part that runs hot by itself, by its name.
bool runs_hot(const std::string& sensor) {
  const std::string name = lower_case(sensor);
  return std::ranges::any_of(
      std::array{"motor", "drive", "gear", "getriebe", "spindle", "spindel", "servo", "winding",
                 "wicklung", "brake", "bremse", "bearing", "lager", "oil", "cabinet", "cpu", "core",
                 "electronic", "encoder", "amplifier"},
      [&](const char* part) { return name.find(part) != std::string::npos; });
}

// 50 F is a cold hall, and 50 deg C more than an arm or a room has from the first reading on.
void check_fahrenheit(const Campaign& campaign, Findings& findings) {
  constexpr double kColdest = 50, kHottest = 122;  // F: 10 to 50 deg C
  if (campaign.temperature_c.empty() || campaign.rows() < kFewestRows) return;
  for (size_t sensor = 0; sensor < campaign.temperature_names.size(); ++sensor) {
    const auto [least, largest] = std::ranges::minmax(campaign.temperature_c, {},
                                                      [&](const auto& row) { return row[sensor]; });
    if (least[sensor] < kColdest || largest[sensor] > kHottest) continue;
    if (runs_hot(campaign.temperature_names[sensor])) continue;
    const auto celsius = [](double fahrenheit) { return (fahrenheit - 32) / 1.8; };
    findings.warnings.push_back(fmt::format(
        "temp_{}_c is {:.4g} to {:.4g} deg C in all rows: are these degrees Fahrenheit ({:.3g} to "
        "{:.3g} deg C)? Convert them",
        campaign.temperature_names[sensor], least[sensor], largest[sensor], celsius(least[sensor]),
        celsius(largest[sensor])));
  }
}

// A few steps back in time, in rows that are otherwise in the order of time.
void check_steps_back(const Campaign& campaign, Findings& findings) {
  std::map<std::pair<int, int>, int> last;  // row of each session and channel
  int back = 0, compared = 0, from = 0, to = 0;
  for (int row = 0; row < campaign.rows(); ++row) {
    const std::pair key(campaign.session.empty() ? 0 : campaign.session[row],
                        campaign.channel(row));
    const auto [known, is_new] = last.try_emplace(key, row);
    if (is_new) continue;
    ++compared;
    if (campaign.time_s[row] < campaign.time_s[known->second] && back++ == 0) {
      from = known->second;
      to = row;
    }
    known->second = row;
  }
  constexpr int kRowsPerStep = 30;
  if (back == 0 || back > std::max(1, compared / kRowsPerStep)) return;
  findings.warnings.push_back(fmt::format(
      "t_s runs back from {:g} s in line {} to {:g} s in line {}: was the clock reset? Drift and "
      "the order of the visits come from it; add up the times, or name the sessions",
      campaign.time_s[from], campaign.line[from], campaign.time_s[to], campaign.line[to]));
}

void check_unit_of_time(const Campaign& campaign, Findings& findings) {
  std::vector<int> order(campaign.q.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](int row) { return campaign.time_s[row]; });
  std::vector<double> gaps, speeds;
  for (size_t k = 1; k < order.size(); ++k) {
    const int a = order[k - 1], b = order[k];
    if (campaign.pose[a] == campaign.pose[b]) continue;
    if (!campaign.session.empty() && campaign.session[a] != campaign.session[b]) continue;
    const double gap = campaign.time_s[b] - campaign.time_s[a];
    if (gap <= 0) continue;
    gaps.push_back(gap);
    speeds.push_back((campaign.q[b] - campaign.q[a]).cwiseAbs().maxCoeff() / gap);
  }
  if (gaps.size() < kFewestRows) return;
  constexpr double kLongGap = 7200, kFast = 1000 * kDegree;  // s, rad/s
  if (const double gap = median(gaps); gap > kLongGap)
    findings.warnings.push_back(fmt::format(
        "by t_s {:g} s pass from pose to pose (median): does it count milliseconds? Give seconds",
        gap));
  else if (const double speed = median(speeds); speed > kFast)
    findings.warnings.push_back(
        fmt::format("by t_s the joints move at {:.3g} deg/s from pose to pose (median): does it "
                    "count minutes or hours? Give seconds",
                    speed / kDegree));
}

void check_clock(const Campaign& campaign, Findings& findings) {
  if (campaign.time_s.empty() || campaign.rows() < kFewestRows) return;
  if (campaign.pose_ids.size() > 1 && stands_still(campaign)) {
    findings.warnings.push_back(
        fmt::format("t_s is {:g} s in all rows: the clock stands still, and drift cannot be seen; "
                    "correct the column or leave it out",
                    campaign.time_s.front()));
    return;
  }
  check_steps_back(campaign, findings);
  check_unit_of_time(campaign, findings);
}

void check_directions(const Campaign& campaign, Findings& findings) {
  int same = 0, opposite = 0;
  for_each_visit(campaign, [&](int row, const Arrival& derived) {
    for (size_t j = 0; j < campaign.arrival[row].size(); ++j) {
      const int product = campaign.arrival[row][j] * derived.direction()[j];
      same += product > 0;
      opposite += product < 0;
    }
  });
  constexpr int kMinCompared = 60, kOppositeToSame = 19;  // 95 %
  if (same + opposite < kMinCompared || opposite < kOppositeToSame * same) return;
  findings.warnings.push_back(fmt::format(
      "dir1 to dir{} contradict {} of {} moves from row to row: is their sign wrong, or are the "
      "rows in the reverse order? The sign is that of the last motion of the joint",
      campaign.q.front().size(), opposite, same + opposite));
}

// The numbers of the instrument in a row.
std::array<double, 7> numbers_read(const Campaign& campaign, int row) {
  std::array<double, 7> numbers{};
  std::copy_n(campaign.position[row].data(), 3, numbers.begin());
  if (campaign.has_orientation())
    std::copy_n(campaign.orientation[row].coeffs().data(), 4, numbers.begin() + 3);
  return numbers;
}

// How often two visits of a pose read the same by chance in all three coordinates, by how often
// they do in some: with the chance p of each, pairs that differ agree in (p + p^2) / (1 + p + p^2)
// of their coordinates.
double chance_of_three(double share_of_others) {
  const double odds = share_of_others / (1 - share_of_others);
  return std::pow((std::sqrt(1 + 4 * odds) - 1) / 2, 3);
}

}  // namespace

Findings check_log(const Campaign& campaign) {
  Findings findings;
  check_doubled(campaign, findings);
  check_copied_sessions(campaign, findings);
  check_lost_readings(campaign, findings);
  check_frozen_readings(campaign, findings);
  check_unit_of_sigma(campaign, findings);
  check_session_names(campaign, findings);
  check_lost_values(campaign, findings);
  check_unit_of_temperature(campaign, findings);
  check_fahrenheit(campaign, findings);
  check_clock(campaign, findings);
  if (!campaign.arrival.empty()) check_directions(campaign, findings);
  return findings;
}

CopiedRows copied_rows(const Campaign& campaign) {
  constexpr double kStep = 0.01 * kMillimetre;  // of displays; finer digits never agree by chance
  constexpr int kFewest = 3, kFewestOthers = 10;
  constexpr double kDeviations = 4;
  if (campaign.position.empty() || campaign.reads_one_number()) return {};
  const auto read = [&](int row) { return numbers_read(campaign, row); };
  std::vector<int> order(campaign.position.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](int a, int b) {
    const auto of_a = place_of(campaign, a), of_b = place_of(campaign, b);
    return of_a != of_b ? of_a < of_b : read(a) < read(b);
  });
  CopiedRows copies;
  double alike = 0, others = 0;  // coordinates that agree in pairs that differ, such pairs
  for (size_t k = 1; k < order.size(); ++k) {
    const int a = order[k - 1], b = order[k];
    if (place_of(campaign, a) != place_of(campaign, b)) continue;
    if (read(a) == read(b)) {
      copies.rows.push_back(b);
      if (copies.rows.size() == 1 || b < copies.row) copies.row = b, copies.of = a;
      continue;
    }
    alike +=
        static_cast<double>((campaign.position[a].array() == campaign.position[b].array()).count());
    ++others;
  }
  const auto found = static_cast<double>(copies.rows.size());
  if (found < kFewest) return {};
  std::vector<double> coordinates;
  for (const Eigen::Vector3d& point : campaign.position) coordinates.push_back(point.x());
  if (last_digits(coordinates, kStep)) {
    if (others < kFewestOthers) return {};
    const double by_chance = (found + others) * chance_of_three(alike / (3 * others));
    if (found < kFewest + by_chance + kDeviations * std::sqrt(by_chance)) return {};
  }
  std::ranges::sort(copies.rows);
  return copies;
}

Findings check_travel(const Robot& robot, const Campaign& campaign) {
  Findings findings;
  constexpr double kFarBeyond = 1.0;  // m
  const std::vector<JointName> names = joint_names(robot.chain);
  for (int row = 0; row < campaign.rows(); ++row)
    for (int j = 0; j < std::ssize(names); ++j) {
      const Link& link = joint_link(robot.chain, j);
      const JointName& name = names[j];
      const double q = campaign.q[row][j];
      const double beyond = std::max(link.min - q, q - link.max);
      if (beyond < (name.is_length ? kFarBeyond : std::numbers::pi)) continue;
      findings.errors.push_back(fmt::format(
          "line {0}: {1} is {2:.6g} {3}, and {4} travels from {5:g} to {6:g} {3}: {7}check the "
          "columns, or correct min_{3} and max_{3} in the robot file",
          campaign.line[row], name.column, q / name.si(), name.unit(), link.name,
          link.min / name.si(), link.max / name.si(), name.is_length ? "" : "count no turns, "));
      return findings;
    }
  return findings;
}

Findings check_limits(const Robot& robot) {
  constexpr size_t kFewestJoints = 4;
  constexpr double kRadians = 2.02 * std::numbers::pi * kDegree;  // a turn, read as degrees
  constexpr double kShort = 75 * kDegree;   // half of the joints of every arm travel farther,
  constexpr double kLong = 100 * kDegree;   // and one of them so far
  constexpr double kTurns = 4 * std::numbers::pi;  // farther travel only joints without an end
  Findings findings;
  std::vector<double> reaches, spans;
  const Link* most = nullptr;
  for (const Link& link : robot.chain.links) {
    if (link.joint != JointKind::revolute || !std::isfinite(link.min) || !std::isfinite(link.max))
      continue;
    reaches.push_back(std::max(-link.min, link.max));
    spans.push_back(link.max - link.min);
    if (!most || spans.back() > most->max - most->min) most = &link;
  }
  if (spans.size() < kFewestJoints) return findings;
  const auto warn = [&](const char* mistake) {
    findings.warnings.push_back(
        fmt::format("no joint travels farther than {}, from {:g} to {:g} deg: are min_deg and "
                    "max_deg {}? Compare them with the data sheet",
                    most->name, most->min / kDegree, most->max / kDegree, mistake));
  };
  // One joint among others. Whole degrees or tenths are a travel that was narrowed on purpose.
  const auto looks_like_radians = [&](const Link& link) {
    constexpr double kTenths = 10, kExact = 1e-6;
    const auto is_fraction = [&](double limit) {
      const double tenths = limit / kDegree * kTenths;
      return std::abs(tenths - std::round(tenths)) > kExact;
    };
    return link.joint == JointKind::revolute && link.max - link.min <= kRadians &&
           (is_fraction(link.min) || is_fraction(link.max));
  };
  if (std::ranges::max(reaches) <= kRadians) {
    warn("radians");
  } else {
    for (const Link& link : robot.chain.links)
      if (looks_like_radians(link))
        findings.warnings.push_back(fmt::format(
            "{} travels from {:g} to {:g} deg, and other joints farther: are its min_deg and "
            "max_deg radians ({:.4g} to {:.4g} deg)? Compare them with the data sheet",
            link.name, link.min / kDegree, link.max / kDegree, link.min / kDegree / kDegree,
            link.max / kDegree / kDegree));
  }
  if (std::ranges::max(reaches) > kRadians && median(spans) < kShort &&
      std::ranges::max(spans) < kLong)
    warn("ten times too small");
  else if (median(reaches) > kTurns)
    findings.warnings.push_back(fmt::format(
        "half of the joints travel by more than {:.3g} turns, {} from {:g} to {:g} deg: are "
        "min_deg and max_deg ten times too large? Compare them with the data sheet",
        median(spans) / (2 * std::numbers::pi), most->name, most->min / kDegree,
        most->max / kDegree));
  return findings;
}

}  // namespace armtrue
