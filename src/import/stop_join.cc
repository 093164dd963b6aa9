#include "import/stop_join.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/observation/placement.h"
#include "armtrue/path/registration/standstills.h"
#include "armtrue/statistics/summary.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "import/covariance_columns.h"

namespace armtrue {
namespace {

constexpr double kStillAngle = 0.03 * kDegree;  // within half a second
constexpr double kStillTravel = 0.05 * kMillimetre;
constexpr double kLargestRest = 10 * kMillimetre;  // of the points of a machine at rest
constexpr double kThinned = 0.02;                  // [s] least time between samples that are used
constexpr double kStreamGap = 0.25;                // [s] largest median gap in a continuous record
constexpr double kStreamShare = 0.3;               // least samples * gap / duration of one
// Uncertainty of the begin and end of a standstill in a record of points and in one of joint angles
// [s]. A reading taken by hand lies well within.
constexpr double kPointEdge = 0.15, kJointEdge = 0.05;
constexpr double kTrimmed = 0.1;  // [s] left out at both ends of a mean, or a tenth
constexpr int kFewestStops = 5;
constexpr double kFewestPaired = 0.6;  // of the readings within the time of the joint angles
constexpr int kClearlyMore = 3;        // standstills, and a tenth, beyond the second best join
constexpr size_t kMostJudged = 10;     // candidate joins that are compared with the robot
constexpr double kImplausibleMiss = 20 * kMillimetre;  // as of a campaign, see diagnose()
constexpr double kSamePoint = 5 * kMillimetre;         // of the same joint angles
constexpr double kSameJoints = 0.02 * kDegree;         // [rad or m]
constexpr size_t kFewestRevisits = 3;

double median_gap(const Eigen::VectorXd& times) {
  std::vector<double> gaps;
  for (Eigen::Index k = 1; k < times.size(); ++k) gaps.push_back(times[k] - times[k - 1]);
  return gaps.empty() ? 0 : median(gaps);
}

std::string rate_text(double rate) {
  constexpr double kNone = 1e-9;  // 0.1 ms in a day
  if (std::abs(rate) < kNone) return "1";
  return fmt::format("1 {} {:.2g}", rate < 0 ? "-" : "+", std::abs(rate));
}

// Some columns of a record with their times, and the rows of the table that they stand in.
struct Record {
  Eigen::VectorXd times;
  Eigen::MatrixXd values;
  std::vector<int> rows;

  Record chosen(const std::vector<Eigen::Index>& samples) const {
    Record some;
    some.times = times(samples);
    some.values = values(Eigen::all, samples);
    for (const Eigen::Index k : samples) some.rows.push_back(rows[k]);
    return some;
  }
};

Record thinned(const Record& record) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < record.times.size(); ++k)
    if (kept.empty() || record.times[k] >= record.times[kept.back()] + kThinned) kept.push_back(k);
  return record.chosen(kept);
}

// The samples of a standstill but for its ends.
std::vector<Eigen::Index> inner_samples(const Record& record, const Standstill& span) {
  const double trim = std::min(kTrimmed, 0.1 * (span.end - span.begin));
  std::vector<Eigen::Index> samples;
  const auto begin = record.times.begin(), end = record.times.end();
  for (auto one = std::lower_bound(begin, end, span.begin + trim);
       one != end && *one <= span.end - trim; ++one)
    samples.push_back(one - begin);
  if (samples.empty()) samples.push_back(std::lower_bound(begin, end, span.begin) - begin);
  return samples;
}

class StopJoin {
 public:
  StopJoin(const TableReader& points, const TableReader& joints, const ImportOptions& options)
      : points_(points), joints_(joints), options_(options) {}

  JointMatches match() {
    require_times(points_, joints_);
    TableReader::Clock points = points_.clock(), joints = joints_.clock();
    if (knows_clock()) bring_to_one_form(points_, points, joints_, joints);
    read_joints(joints);
    read_points(points);
    find_stops();
    take_means();
    const StandstillMatch chosen = choose(candidates());
    return joined(chosen);
  }

 private:
  const std::string& points_file() const { return points_.table().file; }
  const std::string& joints_file() const { return joints_.table().file; }
  bool knows_clock() const { return options_.clock_offset_s.has_value(); }

  void read_joints(const TableReader::Clock& clock) {
    if (!clock.is_number) zero_ = clock.times.front();
    const int n = joints_.rows();
    joint_record_.times.resize(n);
    joint_record_.values.resize(joints_.joint_names().size(), n);
    for (int r = 0; r < n; ++r) {
      joint_record_.times[r] = clock.since(r, zero_);
      joint_record_.values.col(r) = joints_.joints(r);
      joint_record_.rows.push_back(r);
      if (r > 0 && joint_record_.times[r] <= joint_record_.times[r - 1])
        joints_.fail(r, "t",
                     "is not after the time of the row above; joint angles that are joined by "
                     "stops need increasing times");
    }
  }

  void read_points(const TableReader::Clock& clock) {
    const PlainTime own = clock.is_number ? PlainTime{} : clock.times.front();
    const PlainTime& zero = knows_clock() ? zero_ : own;
    std::vector<int> rows;
    for (int r = 0; r < points_.rows(); ++r)
      if (!points_.is_unmeasured(r)) rows.push_back(r);
    std::ranges::stable_sort(
        rows, [&](int a, int b) { return clock.since(a, zero) < clock.since(b, zero); });
    const Eigen::Index n = rows.size();
    point_record_.times.resize(n);
    point_record_.values.resize(3, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const int r = rows[k];
      point_record_.times[k] = clock.since(r, zero);
      point_record_.values.col(k) = points_.position(r);
    }
    point_record_.rows = rows;
    if (n == 0)
      throw InputError(points_file() + ": no row has a measured point; export the readings too");
  }

  void find_stops() {
    const Record joints = thinned(joint_record_);
    Eigen::VectorXd still(joints.values.rows());
    for (Eigen::Index j = 0; j < still.size(); ++j) {
      const JointName& joint = joints_.joint_names()[j];
      still[j] = joint.is_length ? kStillTravel : kStillAngle;
    }
    stops_ = find_standstills(joints.times, joints.values, still);
    if (std::ssize(stops_) < kFewestStops)
      throw InputError(fmt::format(
          "{}: the joints stand still for half a second {}, and at least {} are needed; "
          "record the joint angles from the first stop to the last",
          joints_file(), counted(stops_.size(), "time"), kFewestStops));
    const double duration = span(point_record_.times);
    const double gap = median_gap(point_record_.times);
    const auto samples = static_cast<double>(point_record_.times.size());
    is_stream_ = gap <= kStreamGap && gap * samples >= kStreamShare * duration;
    tolerance_ = kJointEdge + median_gap(joints.times);
    if (!is_stream_) {
      for (const double t : point_record_.times) readings_.push_back({t, t});
      const auto is_whole = [](double t) { return std::abs(t - std::round(t)) < 1e-9; };
      if (std::ranges::all_of(point_record_.times, is_whole)) tolerance_ += 0.5;
      return;
    }
    const Record points = thinned(point_record_);
    const double rest = rest_tolerance(points.times, points.values);
    if (rest <= kLargestRest)
      readings_ = find_standstills(points.times, points.values, Eigen::Vector3d::Constant(rest));
    if (std::ssize(readings_) < kFewestStops)
      throw InputError(fmt::format(
          "{}: the points stand still for half a second {}, and at least {} are needed; "
          "record from the first stop to the last, and stop for a second or more",
          points_file(), counted(readings_.size(), "time"), kFewestStops));
    tolerance_ += kPointEdge + median_gap(points.times);
  }

  static double span(const Eigen::VectorXd& times) { return times[times.size() - 1] - times[0]; }

  std::vector<StandstillMatch> candidates() const {
    if (!knows_clock()) return match_standstills(stops_, readings_, tolerance_);
    ClockFit clock;
    clock.offset = -*options_.clock_offset_s;
    return {match_by_clock(stops_, readings_, clock, tolerance_)};
  }

  StandstillMatch choose(std::vector<StandstillMatch> ways) const {
    if (ways.empty() || ways.front().standstills < kFewestStops)
      throw InputError(fmt::format(
          "{}: with no clock do more than {} of its {} standstills fall into the {} of {}; are "
          "both records of the same campaign, and do they overlap?",
          points_file(), ways.empty() ? 0 : ways.front().standstills, readings_.size(),
          stops_.size(), joints_file()));
    std::erase_if(ways, [&](const StandstillMatch& way) { return !returns_to_points(way); });
    if (ways.empty() || ways.front().standstills < kFewestStops)
      throw InputError(fmt::format(
          "{}: no way to join it with {} brings the same points where the joints are the same; are "
          "both records of the same campaign?",
          points_file(), joints_file()));
    if (options_.robot)
      if (const auto way = way_of_robot(ways)) return *way;
    return clearest(ways);
  }

  const JointVector& joints_at(int stop) const { return stop_joints_[stop]; }

  // Visits to the same joint angles must have measured the same point.
  bool returns_to_points(const StandstillMatch& way) const {
    std::vector<double> apart;
    std::vector<size_t> order;  // by the first joint, so that the same joints lie together
    for (size_t a = 0; a < readings_.size() && !points_.has("target"); ++a)
      if (way.standstill[a] >= 0) order.push_back(a);
    const auto joints_of = [&](size_t reading) { return joints_at(way.standstill[reading]); };
    std::ranges::sort(order, {}, [&](size_t a) { return std::pair(joints_of(a)[0], a); });
    for (size_t last = 0; last < order.size(); ++last)
      for (size_t k = last; k-- > 0;) {
        const size_t a = order[last], b = order[k];
        const JointVector difference = joints_of(a) - joints_of(b);
        if (std::abs(difference[0]) > kSameJoints) break;
        if (way.standstill[a] == way.standstill[b] ||
            difference.cwiseAbs().maxCoeff() > kSameJoints)
          continue;
        apart.push_back((reading_points_[a] - reading_points_[b]).norm());
      }
    return apart.size() < kFewestRevisits || median(apart) <= kSamePoint;
  }

  // The only candidate join whose positions agree with the robot; nothing if the readings are too
  // few.
  std::optional<StandstillMatch> way_of_robot(const std::vector<StandstillMatch>& ways) const {
    std::optional<StandstillMatch> best;
    double least = 0, next = -1;
    for (size_t w = 0; w < std::min(ways.size(), kMostJudged); ++w) {
      const auto placed =
          place_base_and_tool(*options_.robot, campaign_of(ways[w]), kImplausibleMiss);
      if (!placed) continue;
      const double miss = median(placed->miss);
      if (!best || miss < least) {
        if (best) next = least;
        best = ways[w];
        least = miss;
      } else if (next < 0 || miss < next) {
        next = miss;
      }
    }
    if (!best) return std::nullopt;
    if (least > kImplausibleMiss)
      throw InputError(fmt::format(
          "{}: however it is joined with {}, its points lie {:.3g} mm (median) from those of the "
          "robot, with base and tool fitted; are both records of the same campaign, is it this "
          "robot, and are the units right?",
          points_file(), joints_file(), least / kMillimetre));
    if (next >= 0 && next <= kImplausibleMiss)
      throw InputError(fmt::format(
          "{}: can be joined with {} in two ways that leave {:.3g} and {:.3g} mm (median) between "
          "the points and the robot; say which clock holds: --clock-offset-s, see --join time",
          points_file(), joints_file(), least / kMillimetre, next / kMillimetre));
    miss_of_robot_ = least;
    return best;
  }

  const StandstillMatch& clearest(const std::vector<StandstillMatch>& ways) const {
    const StandstillMatch& best = ways.front();
    const int next = ways.size() > 1 ? ways[1].standstills : 0;
    const int clearly = std::max(kClearlyMore, static_cast<int>(std::ceil(0.1 * best.standstills)));
    if (best.standstills - next < clearly)
      throw InputError(fmt::format(
          "{}: can be joined with {} in several ways: {} standstills belong together with one "
          "clock, {} others with one that is {:.3g} s off; give --robot, whose positions tell "
          "which is right, or say the clock: --clock-offset-s",
          points_file(), joints_file(), best.standstills, next,
          std::abs(shift_at_middle(ways[1].clock) - shift_at_middle(best.clock))));
    int within = 0, paired = 0;
    for (size_t k = 0; k < readings_.size(); ++k) {
      const double t = best.clock.program_time(0.5 * (readings_[k].begin + readings_[k].end));
      within += t >= stops_.front().begin && t <= stops_.back().end;
      paired += best.standstill[k] >= 0;
    }
    if (paired < kFewestPaired * within)
      throw InputError(fmt::format(
          "{}: with the best clock {} of {} standstills fall into those of {}, and the others into "
          "its moves; are both records of the same campaign?",
          points_file(), paired, within, joints_file()));
    return best;
  }

  // Clock of the joints minus that of the instrument, in the middle of the joints' record.
  double shift_at_middle(const ClockFit& clock) const {
    const double middle = 0.5 * (stops_.front().begin + stops_.back().end);
    return middle - (clock.offset + (1 + clock.rate) * middle);
  }

  std::vector<Eigen::Index> samples_of(Eigen::Index reading) const {
    if (is_stream_) return inner_samples(point_record_, readings_[reading]);
    return {reading};
  }

  void take_means() {
    for (const Standstill& stop : stops_)
      stop_joints_.emplace_back(
          joint_record_.values(Eigen::all, inner_samples(joint_record_, stop)).rowwise().mean());
    for (size_t k = 0; k < readings_.size(); ++k)
      reading_points_.emplace_back(
          point_record_.values(Eigen::all, samples_of(k)).rowwise().mean());
  }

  Campaign campaign_of(const StandstillMatch& way) const {
    Campaign campaign;
    std::vector<std::string> names;
    for (size_t k = 0; k < readings_.size(); ++k) {
      if (way.standstill[k] < 0) continue;
      campaign.q.push_back(joints_at(way.standstill[k]));
      campaign.position.push_back(reading_points_[k]);
      if (is_stream_ || !points_.has("target")) continue;
      const std::string& name = points_.name(point_record_.rows[k], "target");
      campaign.target.push_back(index_of(campaign.target_names, name));
    }
    return campaign;
  }

  std::shared_ptr<const MeanReading> mean_of(size_t reading) const {
    if (!is_stream_) return nullptr;
    auto mean = std::make_shared<MeanReading>();
    mean->position = reading_points_[reading];
    const std::vector<Eigen::Index> samples = samples_of(reading);
    if (points_.has("cov0"))
      for (const Eigen::Index k : samples)
        mean->covariance +=
            covariance_of(points_, point_record_.rows[k]) / static_cast<double>(samples.size());
    if (!points_.has_orientation()) return mean;
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (const Eigen::Index k : samples) {
      const Eigen::Vector4d one = points_.orientation(point_record_.rows[k]).coeffs();
      sum += sum.dot(one) < 0 ? -one : one;
    }
    mean->orientation = Eigen::Quaterniond(sum.normalized());
    return mean;
  }

  JointMatches joined(const StandstillMatch& way) const {
    JointMatches matches;
    matches.same_joints_are_one_pose = true;
    for (size_t k = 0; k < readings_.size(); ++k) {
      const int stop = way.standstill[k];
      if (stop < 0) continue;
      const std::vector<Eigen::Index> samples = inner_samples(joint_record_, stops_[stop]);
      const std::vector<Eigen::Index> of_point = samples_of(k);
      const size_t point = of_point[of_point.size() / 2];
      const size_t joint = samples[samples.size() / 2];
      matches.rows.push_back(
          {point_record_.rows[point], joint_record_.rows[joint], joints_at(stop), mean_of(k)});
    }
    if (const size_t lost = readings_.size() - matches.rows.size(); lost > 0)
      matches.warnings.push_back(fmt::format(
          "{}: {} of {} {} have no standstill of the joints and are left out", points_file(), lost,
          readings_.size(), is_stream_ ? "standstills" : "points"));
    if (const size_t lost = stops_.size() - way.standstills; lost > 0)
      matches.warnings.push_back(fmt::format("{}: {} of {} standstills of the joints have no point",
                                             joints_file(), lost, stops_.size()));
    matches.how = fmt::format(
        "by standstills, {} of {} of the points with {} of {} of the joints; clock offset {:.3f} s "
        "in the middle, rate of the points' clock {}",
        matches.rows.size(), readings_.size(), way.standstills, stops_.size(),
        shift_at_middle(way.clock), rate_text(way.clock.rate));
    if (miss_of_robot_ >= 0)
      matches.how += fmt::format("; {:.3g} mm (median) from the robot, base and tool fitted",
                                 miss_of_robot_ / kMillimetre);
    return matches;
  }

  const TableReader& points_;
  const TableReader& joints_;
  const ImportOptions& options_;
  PlainTime zero_;
  Record point_record_, joint_record_;
  std::vector<Standstill> stops_, readings_;  // of the joints, of the points
  std::vector<JointVector> stop_joints_;
  std::vector<Eigen::Vector3d> reading_points_;
  bool is_stream_ = false;
  double tolerance_ = 0;
  mutable double miss_of_robot_ = -1;
};

}  // namespace

JointMatches match_by_stops(const TableReader& points, const TableReader& joints,
                            const ImportOptions& options) {
  return StopJoin(points, joints, options).match();
}

}  // namespace armtrue
