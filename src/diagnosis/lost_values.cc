#include "diagnosis/lost_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

constexpr int kFewestMarks = 3;        // rows: two readings may agree by chance
constexpr long kFewestOthers = 10;     // different values by which a series is one of a sensor
constexpr long kFewestSteps = 4;       // of a coarse one: fewer may be typed
constexpr double kNoTemperature = 10;  // K: no part of an arm does it from one visit to the next
constexpr const char* kOrLeaveOut =
    "? Write what was read there, or leave out these rows or the column";

// One number of each row, in the order of the visits.
struct Series {
  std::string column, unit;
  std::vector<int> rows;
  std::vector<double> values;
};

// A value of a series, and where it stands.
struct Value {
  double value;
  long count;
  size_t first, last;  // places
};

// The different values, in ascending order.
std::vector<Value> different_values(const Series& series) {
  std::vector<size_t> order(series.values.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::stable_sort(order, {}, [&](size_t k) { return series.values[k]; });
  std::vector<Value> different;
  for (const size_t k : order) {
    if (different.empty() || different.back().value != series.values[k])
      different.push_back({series.values[k], 0, k, k});
    ++different.back().count;
    different.back().last = k;
  }
  return different;
}

// A stretch of one value, and the values before and behind it; NaN at the ends of the series.
struct Run {
  double value, before, after;
  bool has_both() const { return !std::isnan(before) && !std::isnan(after); }
};

std::vector<Run> runs_of(const std::vector<double>& values) {
  constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();
  std::vector<Run> runs;
  for (const double value : values) {
    if (!runs.empty() && runs.back().value == value) continue;
    const double before = runs.empty() ? kNoValue : runs.back().value;
    if (!runs.empty()) runs.back().after = value;
    runs.push_back({value, before, kNoValue});
  }
  return runs;
}

std::vector<Run> runs_of(double value, const Series& series) {
  std::vector<Run> runs = runs_of(series.values);
  std::erase_if(runs, [&](const Run& run) { return run.value != value; });
  return runs;
}

// How often a value comes, and how far its nearest neighbour in the order of the visits is.
struct Isolation {
  int runs = 0;
  double least = std::numeric_limits<double>::infinity();
};

std::map<double, Isolation> isolations(const Series& series) {
  std::map<double, Isolation> isolations;
  for (const Run& run : runs_of(series.values)) {
    Isolation& isolation = isolations[run.value];
    ++isolation.runs;
    for (const double neighbour : {run.before, run.after})
      if (!std::isnan(neighbour))
        isolation.least = std::min(isolation.least, std::abs(neighbour - run.value));
  }
  return isolations;
}

// The way to a neighbour that no sensor goes: ten steps (median) of the series.
double least_jump(const Series& series) {
  constexpr double kSteps = 10;
  std::vector<double> steps;
  for (size_t k = 1; k < series.values.size(); ++k)
    steps.push_back(std::abs(series.values[k] - series.values[k - 1]));
  return std::max(kNoTemperature, kSteps * median(steps));
}

// The values that stand out at an end of the sorted series: each repeated, and `times` as far from
// the next one as the rest is wide, and at least `least`. A mark at the other end is no part of the
// rest.
std::vector<Value> outlying(std::vector<Value> values, double times, double least) {
  const auto is_mark = [](const Value& value) { return value.count >= kFewestMarks; };
  std::vector<Value> found;
  while (std::ssize(values) > kFewestOthers) {
    const Value &first = values.front(), &last = values.back();
    const double second = values[1].value, last_but_one = values[values.size() - 2].value;
    const double width = (is_mark(last) ? last_but_one : last.value) -
                         (is_mark(first) ? second : first.value);
    const double far = std::max(least, times * width);
    if (is_mark(first) && second - first.value >= far) {
      found.push_back(first);
      values.erase(values.begin());
    } else if (is_mark(last) && last.value - last_but_one >= far) {
      found.push_back(last);
      values.pop_back();
    } else {
      break;
    }
  }
  return found;
}

bool is_one_of(double value, const std::vector<Value>& values) {
  return std::ranges::find(values, value, &Value::value) != values.end();
}

std::string lines_of(const Value& mark, const Series& series, const Campaign& campaign) {
  return fmt::format("{} rows, such as lines {} and {}", mark.count,
                     campaign.line[series.rows[mark.first]], campaign.line[series.rows[mark.last]]);
}

std::string range_without(const std::vector<Value>& marks, const Series& series) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const double value : series.values)
    if (!is_one_of(value, marks)) {
      least = std::min(least, value);
      most = std::max(most, value);
    }
  return least < most ? fmt::format("{:g} to {:g}", least, most) : fmt::format("{:g}", least);
}

void name_marks(const std::vector<Value>& marks, const Series& series, const Campaign& campaign,
                std::vector<std::string>& findings) {
  for (const Value& mark : marks)
    findings.push_back(fmt::format(
        "{} is {:g}{} in {}, and {} in the others: a mark of values that were not read{}",
        series.column, mark.value, series.unit, lines_of(mark, series, campaign),
        range_without(marks, series), kOrLeaveOut));
}

std::vector<int> order_of_visits(const Campaign& campaign) {
  std::vector<int> order(campaign.q.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](int row) {
    return std::pair(campaign.session.empty() ? 0 : campaign.session[row],
                     campaign.time_s.empty() ? 0.0 : campaign.time_s[row]);
  });
  return order;
}

// A sensor that comes late: it stays at one number, from which it then jumps to all others.
void check_dead_stretch(const Series& series, const std::vector<Value>& values,
                        const Campaign& campaign, Findings& findings) {
  constexpr int kFewestInStretch = 5;
  const std::map<double, Isolation> isolation = isolations(series);
  const double jump = least_jump(series);
  for (const Value& value : values) {
    const bool is_stretch = std::cmp_equal(value.last - value.first + 1, value.count);
    if (value.count < kFewestInStretch || !is_stretch) continue;
    // Values that repeat are those of a coarse sensor, or typed.
    const long others = std::ssize(series.values) - value.count;
    if (2 * (std::ssize(values) - 1) < others || isolation.at(value.value).least < jump) continue;
    findings.warnings.push_back(fmt::format(
        "{} is {:g}{} in {} and all between, and {} in the others: was the sensor connected{}",
        series.column, value.value, series.unit, lines_of(value, series, campaign),
        range_without({value}, series), kOrLeaveOut));
  }
}

// Whether thermometers give this number when they give none: those of one wire 85 at the start and
// -127 where the wire is broken, loggers one of the others.
bool is_code(double temperature) {
  constexpr std::array kCodes{-127.0, 85.0, 0.0, -1.0, -99.0, -99.9, -100.0, -200.0,
                              -242.0, 327.67, 850.0, 999.0, 999.9};
  return std::ranges::find(kCodes, temperature) != kCodes.end();
}

// The values to which a thermometer jumps again and again.
std::vector<Value> marks_of(const Series& series, const std::vector<Value>& values) {
  constexpr int kFewestRuns = 2;  // it comes back to them
  constexpr long kRowsPerCode = 4;
  const std::map<double, Isolation> isolation = isolations(series);
  const double jump = least_jump(series);
  const std::vector<Value> far = outlying(values, 1, kNoTemperature);
  const bool is_of_sensor = std::ssize(values) > kFewestSteps;
  std::vector<Value> marks;
  std::ranges::copy_if(values, std::back_inserter(marks), [&](const Value& value) {
    const Isolation& own = isolation.at(value.value);
    if (value.count < kFewestMarks || own.runs < kFewestRuns) return false;
    if (2 * value.count > std::ssize(series.values)) return false;
    if (own.least < jump && !is_one_of(value.value, far)) return false;
    return is_of_sensor ||
           (is_code(value.value) && kRowsPerCode * value.count <= std::ssize(series.values));
  });
  return marks;
}

void check_temperatures(const Campaign& campaign, Findings& findings) {
  if (campaign.temperature_c.empty()) return;
  const std::vector<int> order = order_of_visits(campaign);
  for (size_t sensor = 0; sensor < campaign.temperature_names.size(); ++sensor) {
    Series series{"temp_" + campaign.temperature_names[sensor] + "_c", " deg C", order, {}};
    for (const int row : order) series.values.push_back(campaign.temperature_c[row][sensor]);
    const std::vector<Value> values = different_values(series);
    const std::vector<Value> marks = marks_of(series, values);
    name_marks(marks, series, campaign,
               std::ssize(values) > kFewestOthers ? findings.errors : findings.warnings);
    if (marks.empty()) check_dead_stretch(series, values, campaign, findings);
  }
}

// How many poses share a time: of all times, and of the one that has most.
struct SharedTimes {
  long times = 0, shared = 0;  // shared: by several poses
  double mark = 0;             // the first of those that most poses share
  long poses = 0;              // of the mark
};

SharedTimes shared_times(const Campaign& campaign) {
  std::vector<int> rows(campaign.q.size());
  std::iota(rows.begin(), rows.end(), 0);
  const auto time_of = [&](int row) { return campaign.time_s[row]; };
  std::ranges::stable_sort(rows, {}, time_of);
  SharedTimes found;
  for (auto begin = rows.begin(); begin != rows.end();) {
    const double time = time_of(*begin);
    std::set<std::pair<int, int>> of_time;
    for (; begin != rows.end() && time_of(*begin) == time; ++begin)
      of_time.emplace(campaign.session.empty() ? 0 : campaign.session[*begin],
                      campaign.pose[*begin]);
    const long poses = std::ssize(of_time);
    ++found.times;
    found.shared += poses > 1;
    if (poses > found.poses) found = {found.times, found.shared, time, poses};
  }
  return found;
}

// Whether the rows are in the order of time, but for those with the mark and a few resets.
bool is_in_order(const Campaign& campaign, double mark) {
  constexpr int kRowsPerStepBack = 10;
  int back = 0;
  double last = -std::numeric_limits<double>::infinity();
  for (const double time : campaign.time_s) {
    if (time == mark) continue;
    back += time < last;
    last = time;
  }
  return kRowsPerStepBack * back < campaign.rows();
}

void check_times(const Campaign& campaign, Findings& findings) {
  constexpr long kPerShared = 20;      // times: so many have one pose alone, for one of several
  constexpr double kNearlyAll = 0.9;
  constexpr int kFewestRuns = 2, kMorePosesThanRuns = 6;
  if (campaign.time_s.empty()) return;
  const auto [times, all_shared, mark, poses] = shared_times(campaign);
  const long shared = all_shared - 1, others = times - 1;  // without the mark
  if (poses < kFewestMarks || others < kFewestOthers || shared * kPerShared > others) return;
  Series series{"t_s", " s", std::vector<int>(campaign.q.size()), campaign.time_s};
  std::iota(series.rows.begin(), series.rows.end(), 0);
  // A clock that was reset goes on from the mark; one that was not read goes on from before it.
  int inner = 0, goes_on = 0;
  for (const Run& run : runs_of(mark, series)) {
    if (!run.has_both()) continue;
    ++inner;
    const bool is_between = (run.before < mark) == (mark < run.after);
    goes_on += run.before <= run.after && !is_between;
  }
  const bool is_proven = inner >= kFewestRuns && goes_on >= kNearlyAll * inner;
  // Rows that are not in the order of time do not tell; so many runs of one clock there are not.
  if (!is_proven && (is_in_order(campaign, mark) || poses < kMorePosesThanRuns)) return;
  std::vector<Value> marks = different_values(series);
  std::erase_if(marks, [mark = mark](const Value& value) { return value.value != mark; });
  name_marks(marks, series, campaign, is_proven ? findings.errors : findings.warnings);
}

// Components of a load, such as the torques of all joints.
struct Load {
  std::string names;  // "fx_n, fy_n and fz_n"
  std::vector<Series> components;
  bool may_be_zero;  // all of them
};

// Rows of several poses in which all components are one number.
bool name_equal_components(const Load& load, const Campaign& campaign, Findings& findings) {
  std::map<double, std::vector<int>> rows_of;
  for (int row = 0; row < campaign.rows(); ++row) {
    const auto value = [&](const Series& s) { return s.values[row]; };
    const double first = value(load.components.front());
    if (std::ranges::all_of(load.components, [&](const Series& s) { return value(s) == first; }))
      rows_of[first].push_back(row);
  }
  bool is_named = false;
  for (const auto& [value, rows] : rows_of) {
    std::set<int> poses;
    for (const int row : rows) poses.insert(campaign.pose[row]);
    if (std::ssize(poses) < kFewestMarks || 2 * std::ssize(rows) > campaign.rows()) continue;
    if (value == 0 && load.may_be_zero) continue;
    const Value mark{value, std::ssize(rows), static_cast<size_t>(rows.front()),
                     static_cast<size_t>(rows.back())};
    (value == 0 ? findings.warnings : findings.errors)
        .push_back(fmt::format("{} are all {:g}{} in {}: a mark of values that were not read{}",
                               load.names, value, load.components.front().unit,
                               lines_of(mark, load.components.front(), campaign), kOrLeaveOut));
    is_named = true;
  }
  return is_named;
}

void check_load(const Load& load, const Campaign& campaign, Findings& findings) {
  constexpr double kMostWidths = 10;  // times the width of the others: no process loads an arm so
  if (name_equal_components(load, campaign, findings)) return;
  for (const Series& series : load.components) {
    std::vector<Value> marks = outlying(different_values(series), kMostWidths, 0);
    std::erase_if(marks, [](const Value& value) { return value.value == 0; });
    name_marks(marks, series, campaign, findings.errors);
  }
}

void check_loads(const Campaign& campaign, Findings& findings) {
  std::vector<int> rows(campaign.q.size());
  std::iota(rows.begin(), rows.end(), 0);
  if (!campaign.force_n.empty()) {
    Load load{"fx_n, fy_n and fz_n", {}, true};
    for (int axis = 0; axis < 3; ++axis) {
      Series& series = load.components.emplace_back(
          Series{fmt::format("f{}_n", "xyz"[axis]), " N", rows, {}});
      for (const Eigen::Vector3d& force : campaign.force_n) series.values.push_back(force[axis]);
    }
    check_load(load, campaign, findings);
  }
  if (!campaign.motor_torque_nm.empty()) {
    const size_t joints = campaign.q.front().size();
    Load load{fmt::format("tau1_nm to tau{}_nm", joints), {}, false};
    for (size_t j = 0; j < joints; ++j) {
      Series& series = load.components.emplace_back(
          Series{fmt::format("tau{}_nm", j + 1), " Nm", rows, {}});
      for (const auto& torque : campaign.motor_torque_nm) series.values.push_back(torque[j]);
    }
    check_load(load, campaign, findings);
  }
}

// Payloads are few numbers, each in many rows: a mark shows by its size, or, if it is zero, by a
// load that is gone for single visits and back again, the same.
void check_payload(const Campaign& campaign, Findings& findings) {
  constexpr double kNoPayload = 10;  // times the largest of the others
  constexpr long kRowsPerMark = 4;   // a campaign with and without load has more
  if (campaign.payload_kg.empty()) return;
  Series series{"payload_kg", " kg", order_of_visits(campaign), {}};
  for (const int row : series.rows) series.values.push_back(campaign.payload_kg[row]);
  const std::vector<Value> values = different_values(series);
  if (values.size() < 2) return;
  const Value& largest = values.back();
  const double next = values[values.size() - 2].value;
  if (next > 0 && largest.value >= kNoPayload * next && largest.count >= kFewestMarks &&
      kRowsPerMark * largest.count <= campaign.rows())
    name_marks({largest}, series, campaign, findings.warnings);
  const Value& least = values.front();
  if (least.value != 0 || kRowsPerMark * least.count > campaign.rows()) return;
  const std::vector<Run> runs = runs_of(0, series);
  if (std::ssize(runs) < kFewestMarks || !std::ranges::all_of(runs, [](const Run& run) {
        return !run.has_both() || run.before == run.after;
      }))
    return;
  findings.warnings.push_back(fmt::format(
      "payload_kg is 0 in {}, each time between visits with the same load: was it taken off, or "
      "not logged{}",
      lines_of(least, series, campaign), kOrLeaveOut));
}

}  // namespace

void check_lost_values(const Campaign& campaign, Findings& findings) {
  if (campaign.rows() < kFewestOthers) return;
  check_times(campaign, findings);
  check_temperatures(campaign, findings);
  check_loads(campaign, findings);
  check_payload(campaign, findings);
}

}  // namespace armtrue
