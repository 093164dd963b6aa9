// A machine that stops and goes on, an instrument and a recorder of joint angles with clocks of
// their own. The point is a function of the joint angles, so each row that comes out shows whether
// its joint angles and its point belong together.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <set>

#include "armtrue/import/import_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "support/temporary_file.h"

namespace armtrue::stop_join_test {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

constexpr double kNoiseMm = 0.1;

struct Set {
  double offset = 0, rate = 0;       // t_instrument = offset + (1 + rate) t_joints
  std::set<int> hidden, not_logged;  // stops that the instrument or the recorder lost
  int earlier_stops = 0;             // that the instrument alone saw, before the recorder began
  bool is_list = false, is_regular = false, is_in_whole_seconds = false;
  int stops = 40;
  unsigned seed = 1;
  double longer = 1, move = 3;  // stops, times 1.5 to 3 s; [s], moves take 1 to 1 + this
  double step = 0.05;           // [s] of both records
  double swing = 60;            // [deg] to both sides
  int program = 0;              // stops, after which the joint angles repeat; never if 0
};

class Campaigns {
 public:
  explicit Campaigns(const Set& set) : set_(set), random_(set.seed) {
    std::uniform_real_distribution<double> uniform(0, 1);
    double t = 10;
    for (int k = 0; k < set.stops + set.earlier_stops; ++k) {
      Stop stop;
      for (double& q : stop.q) q = set.swing * (2 * uniform(random_) - 1);
      if (set.program > 0 && k >= set.program)
        stop.q = stops_[static_cast<size_t>(k - set.program)].q;
      stop.begin = t;
      stop.end = t + (set.is_regular ? 2.0 : set.longer * (1.5 + 1.5 * uniform(random_)));
      t = stop.end + (set.is_regular ? 3.0 : 1.0 + set.move * uniform(random_));
      stops_.push_back(stop);
    }
  }

  // [mm]
  static std::array<double, 3> point_at(const std::array<double, 6>& q) {
    const auto rad = [&](int j) { return q[static_cast<size_t>(j)] * kDegree; };
    const double reach = 1500 + 400 * std::sin(rad(2)) + 30 * std::cos(rad(3));
    const double across = reach * std::cos(rad(1));
    return {across * std::cos(rad(0)), across * std::sin(rad(0)),
            reach * std::sin(rad(1)) + 80 * std::sin(rad(4) + rad(5))};
  }

  std::string joint_log() {
    std::string text = "t_s,A1 [deg],A2 [deg],A3 [deg],A4 [deg],A5 [deg],A6 [deg]\n";
    std::normal_distribution<double> noise(0, 0.002);
    const double first = stops_[static_cast<size_t>(set_.earlier_stops)].begin - 1;
    for (double t = first; t < stops_.back().end + 1; t += set_.step) {
      const int at = stop_at(t);
      if (at >= 0 && set_.not_logged.contains(at - set_.earlier_stops)) continue;
      text += number("%.3f", t);
      for (const double q : joints_at(t)) text += number(",%.4f", q + noise(random_));
      text += "\n";
    }
    return text;
  }

  std::string points() {
    std::string text = "t_s,X [mm],Y [mm],Z [mm]\n";
    std::normal_distribution<double> noise(0, kNoiseMm);
    const auto add = [&](double t, bool is_hidden) {
      const double clock = set_.offset + (1 + set_.rate) * t;
      text += number(set_.is_in_whole_seconds ? "%.0f" : "%.3f", clock);
      for (const double x : point_at(joints_at(t)))
        text += "," + (is_hidden ? std::string() : number("%.3f", x + noise(random_)));
      text += "\n";
    };
    if (!set_.is_list) {
      for (double t = stops_.front().begin - 1; t < stops_.back().end + 1; t += 0.8 * set_.step)
        add(t, set_.hidden.contains(stop_at(t) - set_.earlier_stops));
      return text;
    }
    std::uniform_real_distribution<double> inside(0.3, 0.9);
    for (size_t k = 0; k < stops_.size(); ++k)
      if (!set_.hidden.contains(static_cast<int>(k) - set_.earlier_stops))
        add(stops_[k].begin + inside(random_) * (stops_[k].end - stops_[k].begin), false);
    return text;
  }

 private:
  struct Stop {
    std::array<double, 6> q{};
    double begin = 0, end = 0;
  };

  static std::string number(const char* format, double value) {
    char text[40];
    std::snprintf(text, sizeof text, format, value);
    return text;
  }

  int stop_at(double t) const {
    for (size_t k = 0; k < stops_.size(); ++k)
      if (t >= stops_[k].begin && t <= stops_[k].end) return static_cast<int>(k);
    return -1;
  }

  std::array<double, 6> joints_at(double t) const {
    if (t <= stops_.front().begin) return stops_.front().q;
    for (size_t k = 0; k < stops_.size(); ++k) {
      if (t <= stops_[k].end) return stops_[k].q;
      if (k + 1 == stops_.size() || t >= stops_[k + 1].begin) continue;
      const double s = (t - stops_[k].end) / (stops_[k + 1].begin - stops_[k].end);
      const double share = s * s * s * (10 - 15 * s + 6 * s * s);  // without jerk at its ends
      std::array<double, 6> q{};
      for (size_t j = 0; j < 6; ++j)
        q[j] = stops_[k].q[j] + share * (stops_[k + 1].q[j] - stops_[k].q[j]);
      return q;
    }
    return stops_.back().q;
  }

  Set set_;
  std::mt19937_64 random_;
  std::vector<Stop> stops_;
};

ImportedReadings joined(const std::string& points, const std::string& joints,
                        const std::optional<Robot>& robot = {}) {
  ImportOptions options;
  options.join = "stops";
  options.robot = robot;
  return import_readings(TemporaryFile(points).path, TemporaryFile(joints).path, options);
}

std::string error_of(const std::string& points, const std::string& joints,
                     const std::optional<Robot>& robot = {}) {
  try {
    return "no error: " + joined(points, joints, robot).mapping;
  } catch (const InputError& error) {
    return error.what();
  }
}

// Largest distance of a point from where its joint angles put it [mm].
double worst(const Campaign& campaign) {
  double largest = 0;
  for (int r = 0; r < campaign.rows(); ++r) {
    const auto row = static_cast<size_t>(r);
    std::array<double, 6> q{};
    for (int j = 0; j < 6; ++j) q[static_cast<size_t>(j)] = campaign.q[row][j] / kDegree;
    const std::array<double, 3> point = Campaigns::point_at(q);
    const Eigen::Vector3d at(point[0], point[1], point[2]);
    largest = std::max(largest, (campaign.position[row] / kMillimetre - at).norm());
  }
  return largest;
}

// As the mapping shows it: "rate of the points' clock 1 + 0.0001".
double found_rate(const std::string& mapping) {
  const std::string before = "clock 1 ";
  const size_t at = mapping.rfind(before) + before.size();
  return (mapping[at] == '-' ? -1 : 1) * std::atof(mapping.c_str() + at + 2);
}

void expect_joined(const Set& set, int expected) {
  Campaigns cell(set);
  const std::string points = cell.points(), joints = cell.joint_log();
  const ImportedReadings readings = joined(points, joints);
  EXPECT_EQ(readings.campaign.rows(), expected) << readings.mapping;
  // Visits to the same joint angles are one pose.
  const int poses = set.program > 0 ? set.program : expected;
  EXPECT_EQ(readings.campaign.pose_ids.size(), static_cast<size_t>(poses));
  EXPECT_LT(worst(readings.campaign), set.is_list ? 5 * kNoiseMm : kNoiseMm) << readings.mapping;
}

TEST(StopJoin, ClocksMayDifferByAnyOffsetAndByTheirRate) {
  expect_joined({}, 40);
  expect_joined({.offset = 5000, .rate = 1e-4}, 40);
  expect_joined({.offset = -123.4, .rate = -1e-4, .seed = 2}, 40);
  expect_joined({.offset = 1.7e9, .rate = 1e-4, .seed = 3}, 40);
}

TEST(StopJoin, ALongRecordShowsTheRate) {
  for (const double rate : {1e-4, -1e-4}) {
    const Set set{.offset = 5000, .rate = rate, .longer = 25, .step = 0.2};
    expect_joined(set, 40);
    Campaigns cell(set);
    const std::string points = cell.points();
    // What is known of clocks beforehand draws the rate to zero.
    EXPECT_NEAR(found_rate(joined(points, cell.joint_log()).mapping), rate, 3e-5);
  }
}

// Stops of irregular length, read in their middles by the clock of the joints; times `scale` s.
std::pair<std::string, std::string> on_one_clock(double scale) {
  std::string points = "t_s,X [mm],Y [mm],Z [mm]\n";
  std::string joints = "t_s,A1 [deg],A2 [deg],A3 [deg],A4 [deg],A5 [deg],A6 [deg]\n";
  int tick = 0;  // 0.05 s
  for (int k = 0; k < 20; ++k) {
    const int ticks = 30 + 2 * (7 * k % 16);
    const auto time = [&](int at) { return std::to_string(scale * (tick + at) / 20); };
    for (int i = 0; i <= ticks; ++i)
      joints += time(i) + "," + std::to_string(10 + 5 * k) + ",0,0,0,0,0\n";
    points += time(ticks / 2) + "," + std::to_string(1000 + 20 * k) + ",0," +
              std::to_string(k * k % 7) + "\n";
    tick += ticks + 20 + 61 * k * k % 240;
  }
  return {points, joints};
}

// The fit leaves 1e-19 of the rate.
TEST(StopJoin, OfOneClockHasTheRateOne) {
  const auto [points, joints] = on_one_clock(1);
  const std::string mapping = joined(points, joints).mapping;
  EXPECT_THAT(mapping, HasSubstr("rate of the points' clock 1\n"));
}

TEST(StopJoin, TimesInNanosecondsAreNamed) {
  const auto [points, joints] = on_one_clock(1e9);
  EXPECT_THAT(error_of(points, joints), HasSubstr("are the times in ns?"));
  ImportOptions options;
  options.join = "time";
  const TemporaryFile of_points(points), of_joints(joints);
  try {
    import_readings(of_points.path, of_joints.path, options);
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("are the times in ns?"));
  }
}

TEST(StopJoin, ARecordOfHoursMayDriftByMoreThanAStop) {
  expect_joined({.offset = -30, .rate = 4e-4, .stops = 1000, .step = 0.1}, 1000);
}

// More than 200 standstills are searched in runs; only some of them lie where the records overlap.
TEST(StopJoin, LongRecordsMayOverlapInPart) {
  expect_joined({.offset = -77, .rate = 2e-4, .earlier_stops = 400, .stops = 300, .step = 0.1}, 300);
}

// A program that runs twenty-five times, with pauses that differ: a run fits many of its cycles.
TEST(StopJoin, ALongRecordOfOneProgramIsJoined) {
  expect_joined({.offset = 500, .rate = 1e-4, .stops = 500, .step = 0.1, .program = 20}, 500);
}

TEST(StopJoin, EitherLogMayHaveLostStopsAndTheInstrumentMayHaveSeenMore) {
  expect_joined({.offset = 77, .rate = 1e-4, .hidden = {3, 4, 17, 30}}, 36);
  expect_joined({.offset = 77, .rate = -1e-4, .not_logged = {0, 9, 21}}, 37);
  expect_joined({.offset = 77, .hidden = {5, 6}, .not_logged = {6, 30}, .seed = 4}, 37);
  expect_joined({.offset = -77, .earlier_stops = 1, .seed = 5}, 40);
  expect_joined({.offset = -77, .earlier_stops = 7, .seed = 6}, 40);
}

TEST(StopJoin, ReadingsTakenOneByOneAreJoinedAsTheyAre) {
  expect_joined({.offset = 5000, .rate = 1e-4, .is_list = true, .move = 12}, 40);
  expect_joined({.offset = 50, .hidden = {7, 8, 9}, .is_list = true, .seed = 2, .move = 12}, 37);
}

TEST(StopJoin, TheClockThatIsGivenHolds) {
  Campaigns cell({.offset = 100, .is_regular = true});
  const TemporaryFile points(cell.points()), joints(cell.joint_log());
  ImportOptions options;
  options.join = "stops";
  options.clock_offset_s = -100;
  const Campaign campaign = import_readings(points.path, joints.path, options).campaign;
  EXPECT_EQ(campaign.rows(), 40);
  EXPECT_LT(worst(campaign), kNoiseMm);
}

TEST(StopJoin, WhatTheTimesDoNotTellIsRefused) {
  Campaigns regular({.offset = 100, .is_regular = true});
  EXPECT_THAT(error_of(regular.points(), regular.joint_log()), HasSubstr("in several ways"));
  EXPECT_THAT(error_of(regular.points(), regular.joint_log()), HasSubstr("give --robot"));
  // The instrument was started when the recorder had ended.
  Set apart{.offset = 100};
  for (int k = 0; k < 20; ++k) {
    apart.hidden.insert(k);
    apart.not_logged.insert(k + 20);
  }
  Campaigns halves(apart);
  EXPECT_THAT(error_of(halves.points(), halves.joint_log()),
              AnyOf(HasSubstr("same campaign"), HasSubstr("in several ways")));
  // Moves that take nearly the same time, and times in whole seconds: a clock that is off by one
  // stop does nearly as well.
  Campaigns coarse({.is_list = true, .is_in_whole_seconds = true, .stops = 60, .seed = 3});
  EXPECT_THAT(error_of(coarse.points(), coarse.joint_log()), HasSubstr("in several ways"));
  for (unsigned seed = 1; seed <= 10; ++seed)
    EXPECT_THAT(
        error_of(Campaigns({.seed = seed}).points(), Campaigns({.seed = seed + 100}).joint_log()),
        AnyOf(HasSubstr("same campaign"), HasSubstr("in several ways")));
}

TEST(StopJoin, StopsOfAnotherProgramAreRefused) {
  // As long as those of the first, but the arm returns where it did not.
  Campaigns first({}), other({.program = 20});
  EXPECT_THAT(error_of(first.points(), other.joint_log()),
              HasSubstr("same points where the joints are the same"));
  Set gaps;
  for (int k = 0; k < gaps.stops; k += 2) gaps.not_logged.insert(k);
  Campaigns half(gaps);
  EXPECT_THAT(error_of(half.points(), half.joint_log()), HasSubstr("20 of 40 standstills"));
}

TEST(StopJoin, ARobotThatHardlyMovesDoesNotTellTheClock) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360.yaml").robot;
  Campaigns cell({.is_regular = true, .swing = 0.3});
  EXPECT_THAT(error_of(cell.points(), cell.joint_log(), robot), HasSubstr("in two ways"));
}

TEST(StopJoin, LogsWithoutStopsAreRefused) {
  Campaigns cell({});
  std::string still = "t_s,A1 [deg],A2 [deg],A3 [deg],A4 [deg],A5 [deg],A6 [deg]\n";
  std::string moving = still, at_rest = "t_s,X [mm],Y [mm],Z [mm]\n";
  for (int k = 0; k < 4000; ++k) {
    const std::string t = std::to_string(0.05 * k);
    still += t + ",1,2,3,4,5,6\n";
    moving += t + "," + std::to_string(0.2 * k) + ",2,3,4,5,6\n";
    at_rest += t + ",1,2,3\n";
  }
  EXPECT_THAT(error_of(cell.points(), still), HasSubstr("stand still for half a second 1 time,"));
  EXPECT_THAT(error_of(cell.points(), moving), HasSubstr("stand still for half a second 0 times"));
  EXPECT_THAT(error_of(at_rest, cell.joint_log()), HasSubstr("the points stand still"));
}

}  // namespace
}  // namespace armtrue::stop_join_test
