#include "import/joint_match.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "armtrue/kinematics/names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"
#include "armtrue/text/edit_distance.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "import/stop_join.h"

namespace armtrue {
namespace {

constexpr double kStandsStill = 0.01 * kDegree;  // or m: from sample to sample,
constexpr double kStillFor = 0.02;               // [s]: and in this time where samples are closer
constexpr double kRounding = 1e-6;               // [s] of a difference of two UNIX times

std::set<std::string> ids_of(const TableReader& reader) {
  std::set<std::string> ids;
  for (int r = 0; r < reader.rows(); ++r)
    if (!reader.cell(r, "pose").empty()) ids.insert(reader.cell(r, "pose"));
  return ids;
}

// A name in small letters, without blanks, `_`, `-` and leading zeros: P01 and p1 are alike.
std::string bare_name(const std::string& name) {
  std::string bare;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  for (const char c : lower_case(name)) {
    if (c == ' ' || c == '_' || c == '-') continue;
    if (is_digit(c) && !bare.empty() && bare.back() == '0' &&
        (bare.size() == 1 || !is_digit(bare[bare.size() - 2])))
      bare.pop_back();
    bare += c;
  }
  return bare;
}

std::vector<std::string> bare_names(const TableReader& reader) {
  std::vector<std::string> names;
  for (int r = 0; r < reader.rows(); ++r) names.push_back(bare_name(reader.cell(r, "pose")));
  return names;
}

// Throws InputError if both tables have the same names by bare_name() in another order: their rows
// must not be joined by order.
void refuse_names_in_another_order(const TableReader& points, const TableReader& joints) {
  std::vector<std::string> left = bare_names(points), right = bare_names(joints);
  if (left == right) return;
  const std::string first = left.front();
  const auto row = find_name(right, first);
  std::ranges::sort(left);
  std::ranges::sort(right);
  if (left != right) return;
  throw InputError(fmt::format(
      "{}: its poses are those of {} in another order, only their names are written otherwise, "
      "such as '{}' and '{}'; write them alike, or give --join order",
      points.table().file, joints.table().file, points.cell(0, "pose"), joints.cell(*row, "pose")));
}

// The markers of one line are rows of their own.
bool begins_line(const TableReader& points, int r) {
  return r == 0 || points.row(r).line != points.row(r - 1).line;
}

int lines_of(const TableReader& points) {
  int lines = 0;
  for (int r = 0; r < points.rows(); ++r) lines += begins_line(points, r);
  return lines;
}

// The times of the lines, the markers of one line together [s].
std::vector<double> times_of_lines(const TableReader& table, const TableReader::Clock& clock) {
  const PlainTime zero = clock.is_number ? PlainTime{} : clock.times.front();
  std::vector<double> times;
  for (int r = 0; r < table.rows(); ++r)
    if (begins_line(table, r)) times.push_back(clock.since(r, zero));
  return times;
}

double median_period(const std::vector<double>& times) {
  std::vector<double> periods;
  for (size_t k = 1; k < times.size(); ++k) periods.push_back(times[k] - times[k - 1]);
  return median(std::move(periods));
}

// Two records of the way, each with its own clock or start, have no order in common: row 100 of one
// was taken at another time than row 100 of the other, however many rows they have.
void refuse_records(const TableReader& points, const TableReader& joints) {
  constexpr double kFastestVisit =
      0.5;  // [s]: no arm drives to a pose and stands there in this time
  if (!points.has("t") || !joints.has("t") || joints.rows() < 3) return;
  const TableReader::Clock a = points.clock(), b = joints.clock();
  const std::vector<double> of_points = times_of_lines(points, a),
                            of_joints = times_of_lines(joints, b);
  const double period = std::max(median_period(of_points), median_period(of_joints));
  if (!(period < kFastestVisit)) return;
  const bool same_instants = a.is_number == b.is_number &&
                             std::ranges::equal(of_points, of_joints, [&](double at, double other) {
                               return std::abs(at - other) <= period / 2;
                             });
  if (same_instants) return;
  throw InputError(fmt::format(
      "{}: this table and {} are records with a row each {:.3g} s, and their rows have other "
      "times; "
      "say how they belong together: --join time if the clocks agree, --join stops if they differ, "
      "--join order if each row has the same visit in both",
      points.table().file, joints.table().file, period));
}

std::string join_by(const TableReader& points, const TableReader& joints) {
  const std::string& a = points.table().file;
  const std::string& b = joints.table().file;
  if (points.has("pose") && joints.has("pose")) {
    const std::set<std::string> left = ids_of(points), right = ids_of(joints);
    if (left == right) return "id";
    for (const std::string& id : left)
      if (right.contains(id))
        throw InputError(fmt::format(
            "{}: the poses of this table and of {} are the same in part only; give --join id to "
            "take those that both have, or --join order",
            a, b));
    refuse_names_in_another_order(points, joints);
  }
  if (lines_of(points) == joints.rows()) {
    refuse_records(points, joints);
    return "order";
  }
  throw InputError(fmt::format(
      "{}: has {}, {} has {}, and no column of poses with the same names; say how rows belong "
      "together: --join time, --join stops if their clocks differ, or --column pose=NAME for both",
      a, counted(lines_of(points), "row"), b, joints.rows()));
}

// A warning if many rows are joined by order although the other table has their names at other
// rows; else empty.
std::string doubt_of_order(const TableReader& points, const TableReader& joints) {
  if (!points.has("pose") || !joints.has("pose") || points.rows() != joints.rows()) return "";
  const std::vector<std::string> left = bare_names(points), right = bare_names(joints);
  const std::set<std::string> names(right.begin(), right.end());
  int elsewhere = 0, first = 0;
  for (int row = points.rows() - 1; row >= 0; --row)
    if (left[row] != right[row] && names.contains(left[row])) {
      first = row;
      ++elsewhere;
    }
  if (2 * elsewhere <= points.rows()) return "";
  return fmt::format(
      "{}: its row '{}' is joined with '{}' of {} by their order, and {} of {} rows stand there "
      "under their name in another row: if the names are those of poses, give --join id",
      points.table().file, points.cell(first, "pose"), joints.cell(first, "pose"),
      joints.table().file, elsewhere, points.rows());
}

JointMatches match_by_order(const TableReader& points, const TableReader& joints) {
  if (lines_of(points) != joints.rows())
    throw InputError(fmt::format(
        "{}: has {} and {} has {}; --join order needs as many in both: add or remove rows",
        points.table().file, counted(lines_of(points), "row"), joints.table().file, joints.rows()));
  JointMatches matches;
  if (std::string doubt = doubt_of_order(points, joints); !doubt.empty())
    matches.warnings.push_back(std::move(doubt));
  for (int r = 0, of_joints = -1; r < points.rows(); ++r) {
    of_joints += begins_line(points, r);
    matches.rows.push_back({r, of_joints, joints.joints(of_joints), nullptr});
  }
  matches.how = "by the order of the rows";
  return matches;
}

// Joins rows by pose and, if both tables number the visits, by repeat.
class IdJoin {
 public:
  IdJoin(const TableReader& points, const TableReader& joints)
      : points_(points),
        joints_(joints),
        by_repeat_(points.has("repeat") && joints.has("repeat")) {}

  JointMatches match() {
    for (const TableReader* table : {&points_, &joints_})
      if (!table->has("pose"))
        throw InputError(table->table().file +
                         ": has no column of poses to join by; name it: --column pose=NAME");
    for (int r = 0; r < joints_.rows(); ++r) joint_rows_[key(joints_, r)].push_back(r);
    for (int r = 0; r < points_.rows(); ++r) point_rows_[key(points_, r)].push_back(r);
    JointMatches matches;
    for (int r = 0; r < points_.rows(); ++r) {
      const int joint_row = row_for(r);
      matches.rows.push_back({r, joint_row, joints_.joints(joint_row), nullptr});
    }
    const auto left = std::ranges::count_if(
        joint_rows_, [&](const auto& entry) { return !point_rows_.contains(entry.first); });
    if (left > 0)
      matches.warnings.push_back(fmt::format("{}: left out: {} without a measured point",
                                             joints_.table().file, counted(left, "pose")));
    matches.how = by_repeat_ ? "by pose and repeat" : "by pose";
    return matches;
  }

 private:
  using Key = std::pair<std::string, int>;

  Key key(const TableReader& table, int r) const {
    return {table.name(r, "pose"), by_repeat_ ? table.whole_number(r, "repeat") : 0};
  }

  int row_for(int r) const {
    const auto found = joint_rows_.find(key(points_, r));
    if (found == joint_rows_.end())
      points_.fail(r, "pose",
                   "has no row with joint angles in " + joints_.table().file +
                       "; add it there, or remove this row");
    const std::vector<int>& rows = found->second;
    if (rows.size() == 1) return rows.front();
    const std::vector<int>& here = point_rows_.at(found->first);
    if (here.size() != rows.size() || points_.has("target"))
      points_.fail(r, "pose",
                   fmt::format("stands {} times here and {} times in {}, so that rows cannot be "
                               "told apart; number the visits in both: --column repeat=NAME",
                               here.size(), rows.size(), joints_.table().file));
    return rows[std::ranges::lower_bound(here, r) - here.begin()];
  }

  const TableReader& points_;
  const TableReader& joints_;
  bool by_repeat_;
  std::map<Key, std::vector<int>> joint_rows_, point_rows_;
};

class TimeJoin {
 public:
  TimeJoin(const TableReader& points, const TableReader& joints, const ImportOptions& options)
      : points_(points), joints_(joints), options_(options) {}

  JointMatches match() {
    require_times(points_, joints_);
    read_clocks();
    JointMatches matches;
    int outside = 0, moving = 0, first_moving = 0;
    for (int r = 0; r < points_.rows(); ++r) {
      if (points_.is_unmeasured(r)) continue;
      const double t = point_s_[r];
      const auto after = std::ranges::lower_bound(joint_s_, t);
      if (after == joint_s_.end() || (after == joint_s_.begin() && *after > t)) {
        ++outside;
        continue;
      }
      const bool hit = *after == t;
      const auto b = static_cast<int>(after - joint_s_.begin()), a = hit ? b : b - 1;
      if (!stands_still(a, b)) {
        if (moving++ == 0) first_moving = points_.row(r).line;
        continue;
      }
      matches.rows.push_back({r, a, between(a, b, t), nullptr});
    }
    if (matches.rows.empty()) fail_without_rows(outside, moving);
    if (outside > 0)
      matches.warnings.push_back(fmt::format("{}: left out: {} before or after all joint angles",
                                             points_.table().file, counted(outside, "point")));
    if (moving > 0)
      matches.warnings.push_back(fmt::format(
          "{}: left out: {} at which the joints move, or have no samples within {:.6g} s, the "
          "first in "
          "line {}",
          points_.table().file, counted(moving, "point"), options_.max_gap_s, first_moving));
    matches.stops_are_poses = true;
    matches.how =
        fmt::format("by time, {} of {} points, clock offset {:.9g} s", matches.rows.size(),
                    points_.rows(), options_.clock_offset_s.value_or(0));
    return matches;
  }

 private:
  void read_clocks() {
    TableReader::Clock points = points_.clock(), joints = joints_.clock();
    bring_to_one_form(points_, points, joints_, joints);
    const PlainTime zero = joints.is_number ? PlainTime{} : joints.times.front();
    for (int r = 0; r < points_.rows(); ++r)
      point_s_.push_back(points.since(r, zero) + options_.clock_offset_s.value_or(0));
    for (int r = 0; r < joints_.rows(); ++r) {
      joint_s_.push_back(joints.since(r, zero));
      if (r > 0 && joint_s_[r] <= joint_s_[r - 1])
        joints_.fail(r, "t",
                     "is not after the time of the row above; joint angles that are joined by time "
                     "need increasing times");
      q_.push_back(joints_.joints(r));
    }
  }

  bool near(int a, int b) const { return (q_[b] - q_[a]).cwiseAbs().maxCoeff() <= kStandsStill; }
  double seconds(int a, int b) const { return std::abs(joint_s_[b] - joint_s_[a]); }
  bool is_gap(int a, int b) const { return seconds(a, b) > options_.max_gap_s + kRounding; }

  // From a sample to the next one in a direction, and on until kStillFor is over: at a high rate
  // any motion is small from sample to sample.
  bool stands_still_beside(int sample, int direction) const {
    const auto count = std::ssize(q_);
    const int next = sample + direction;
    if (next >= 0 && next < count && is_gap(sample, next)) return false;
    for (int k = next; k >= 0 && k < count; k += direction) {
      if (!near(sample, k)) return false;
      if (seconds(sample, k) >= kStillFor - kRounding) break;
    }
    return true;
  }

  // Between samples a and b, before and after them.
  bool stands_still(int a, int b) const {
    return near(a, b) && !is_gap(a, b) && stands_still_beside(a, -1) && stands_still_beside(b, 1);
  }

  JointVector between(int a, int b, double t) const {
    if (a == b) return q_[a];
    const double share = (t - joint_s_[a]) / (joint_s_[b] - joint_s_[a]);
    return q_[a] + share * (q_[b] - q_[a]);
  }

  [[noreturn]] void fail_without_rows(int outside, int moving) const {
    throw InputError(fmt::format(
        "{}: no point can be joined by time: {} lie before or after all joint angles of {}, at {} "
        "the joints move or have no samples within {:.6g} s; check the columns of times, "
        "--clock-offset-s and --max-gap-s",
        points_.table().file, outside, joints_.table().file, moving, options_.max_gap_s));
  }

  const TableReader& points_;
  const TableReader& joints_;
  const ImportOptions& options_;
  std::vector<double> point_s_, joint_s_;
  std::vector<JointVector> q_;
};

}  // namespace

void require_times(const TableReader& points, const TableReader& joints) {
  for (const TableReader* table : {&points, &joints})
    if (!table->has("t"))
      throw InputError(table->table().file +
                       ": has no column of times to join by; name it: --column t_s=NAME");
  constexpr double kMostApart = 1e5;  // s: no log is so slow; in ns any log is above it (0.1 ms)
  const TableReader::Clock clock = joints.clock();
  const int rows = joints.rows();
  if (rows < 2 || !clock.is_number) return;
  const double apart = (clock.seconds.back() - clock.seconds.front()) / (rows - 1);
  if (apart >= kMostApart)
    joints.fail(1, "t",
                fmt::format("the rows are {:.3g} s apart in the mean, as no joint angles are "
                            "logged: are the times in ns? Correct their unit",
                            apart));
}

namespace {

// Makes times of day of dates of one day: the other table has no dates.
void drop_the_day(TableReader::Clock& clock) {
  const auto day = [](const PlainTime& time) { return time.day; };
  if (std::ranges::adjacent_find(clock.times, std::ranges::not_equal_to(), day) !=
      clock.times.end())
    return;
  for (PlainTime& time : clock.times) time = PlainTime{.seconds = time.seconds};
}

}  // namespace

void bring_to_one_form(const TableReader& points, TableReader::Clock& a, const TableReader& joints,
                       TableReader::Clock& b) {
  static constexpr std::string_view kNumbers = "numbers", kTimes = "times of day",
                                    kDates = "dates without a time zone";
  const auto form = [](const TableReader::Clock& clock) -> std::string_view {
    if (clock.is_number) return kNumbers;
    if (!clock.times.front().has_date) return kTimes;
    return clock.times.front().has_zone ? "dates with a time zone" : kDates;
  };
  if (form(a) == kDates && form(b) == kTimes) drop_the_day(a);
  if (form(b) == kDates && form(a) == kTimes) drop_the_day(b);
  if (form(a) != form(b))
    throw InputError(fmt::format(
        "{}: its times are {}, those of {} are {}; give both in one form to join by time",
        points.table().file, form(a), joints.table().file, form(b)));
}

JointMatches match_joints(const TableReader& points, const TableReader& joints,
                          const ImportOptions& options) {
  const bool is_stated = !options.join.empty();
  const std::string how = is_stated ? options.join : join_by(points, joints);
  if (how == "id") return IdJoin(points, joints).match();
  if (how == "order") {
    JointMatches matches = match_by_order(points, joints);
    if (!is_stated && points.has("pose") && joints.has("pose"))
      matches.warnings.push_back(
          fmt::format("{}: the poses have other names than in {}; the rows are joined in their "
                      "order: is it the "
                      "same in both?",
                      points.table().file, joints.table().file));
    return matches;
  }
  if (how == "stops") return match_by_stops(points, joints, options);
  return TimeJoin(points, joints, options).match();
}

}  // namespace armtrue
