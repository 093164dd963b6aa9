#include "search/driver_span.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "search/candidates.h"

namespace armtrue {
namespace {

constexpr int kPoses = 12, kRows = 24;

// Two visits of each pose.
Campaign campaign() {
  Campaign c;
  for (int row = 0; row < kRows; ++row) {
    c.pose.push_back(row % kPoses);
    c.q.push_back(JointVector::Zero(6));
    c.arrival.push_back({1, 1, 1, 1, 1, 1});
    c.stroke.push_back(JointVector::Ones(6));
    c.payload_kg.push_back(20);
    c.force_n.push_back({0, 0, 50});
    c.temperature_c.push_back({25});
    c.motor_torque_nm.push_back({3, 3, 3, 3, 3, 3});
    c.time_s.push_back(row);
  }
  c.temperature_names = {"air"};
  return c;
}

struct Column {
  const char* driver;
  std::function<void(Campaign&, int)> change;  // the value of a row
};

const Column kColumns[] = {
    {"arrival 2", [](Campaign& c, int row) { c.arrival[row][1] = -1; }},
    {"stroke 2", [](Campaign& c, int row) { c.stroke[row][1] = -0.5; }},
    {"payload", [](Campaign& c, int row) { c.payload_kg[row] = 0; }},
    {"force", [](Campaign& c, int row) { c.force_n[row] = {0, 0, 0}; }},
    {"temperature air", [](Campaign& c, int row) { c.temperature_c[row][0] = 31; }},
    {"motor-torque 2", [](Campaign& c, int row) { c.motor_torque_nm[row][1] = 9; }},
};

bool driven(const char* driver, const Campaign& c) {
  return is_driven(*parse_driver(driver), c, time_span(c));
}

// What is the same in all rows is a constant of the geometry, and what differs at one pose is the
// error of that pose.
TEST(DriverSpan, ADriverNeedsItsLevelsAtSeveralPoses) {
  for (const auto& [driver, change] : kColumns) {
    Campaign c = campaign();
    EXPECT_FALSE(driven(driver, c)) << driver;
    for (const int row : {4, 4 + kPoses}) change(c, row);
    EXPECT_FALSE(driven(driver, c)) << driver << " at one pose";
    for (const int row : {1, 7}) change(c, row);
    EXPECT_TRUE(driven(driver, c)) << driver << " at three poses";
    EXPECT_FALSE(driven("arrival 1", c));
  }
}

// At the first visit, and of a joint that has not moved, nothing is known.
TEST(DriverSpan, AnUnknownDirectionIsNoLevel) {
  Campaign c = campaign();
  for (const int row : {0, 1, 2, 3, 4, 5}) c.arrival[static_cast<size_t>(row)] = {};
  EXPECT_FALSE(driven("arrival 1", c));
}

TEST(DriverSpan, AFactorNeedsThemToo) {
  Campaign c = campaign();
  EXPECT_FALSE(driven("joint-angle 3 * payload", c));
  for (const int row : {1, 4, 7}) c.payload_kg[static_cast<size_t>(row)] = 0;
  EXPECT_TRUE(driven("joint-angle 3 * payload", c));
}

// Sessions say what comes before what where no times do: none are there, or each session begins anew.
TEST(DriverSpan, SessionsStandInTheirOrderWhereTimesShowNone) {
  Campaign c = campaign();
  EXPECT_FALSE(session_driver(c));
  c.session_names = {"b", "nothing", "a"};
  for (int row = 0; row < kRows; ++row) c.session.push_back(row < kPoses ? 0 : 2);
  EXPECT_FALSE(session_driver(c)) << "the times order them";
  for (int row = kPoses; row < kRows; ++row) c.time_s[row] -= kPoses;
  ASSERT_TRUE(session_driver(c));
  for (int row = 0; row < kRows; ++row) c.time_s[row] = row < kPoses ? row : row - 1;
  EXPECT_TRUE(session_driver(c)) << "two readings at one time";
  c.time_s.clear();
  const auto driver = session_driver(c);
  ASSERT_TRUE(driver);
  EXPECT_EQ(driver->sessions, (std::vector<std::string>{"b", "a"}));
  EXPECT_EQ(span_of(*driver, c).values, (std::vector<double>{0, 1}));
  EXPECT_EQ(step_places(span_of(*driver, c), kStepGrid), std::vector<double>{0.5});
  EXPECT_TRUE(is_driven(*driver, c, {}));
}

// Seconds since 1970, and since the record began.
TEST(DriverSpan, TimeCountsFromTheFirstReadingWhereZeroIsFar) {
  EXPECT_EQ(begin_of_time({{1.7e9, 1.7e9 + 600, 1.7e9 + 3600}}), 1.7e9);
  EXPECT_EQ(begin_of_time({{5, 600, 3600}}), 0);
  EXPECT_EQ(begin_of_time({}), 0);
}

// exp(-(x - middle)^2 / (2 sigma^2)) at the nearest reading, by hand; 1 outside their travel.
double shown(const Shape& bump, const std::vector<double>& readings) {
  const double sigma = (bump.high[0] - bump.low[0]) / 2, middle = bump.low[0] + sigma;
  if (middle < std::ranges::min(readings) || middle > std::ranges::max(readings)) return 1;
  double nearest = 1e9;
  for (const double x : readings) nearest = std::min(nearest, std::abs(x - middle));
  return std::exp(-0.5 * std::pow(nearest / sigma, 2));
}

// A bump that stands between readings, far from all of them, could have any height.
TEST(DriverSpan, ABumpIsSearchedWhereReadingsShowIt) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr10-r1100.yaml").robot;
  SimulationOptions options;
  options.poses = 60;
  const Campaign all = simulate(robot, robot, options);
  std::vector<int> rows;
  for (int row = 0; row < all.rows(); ++row)
    if (std::abs(all.q[row][3] - 52 * kDegree) > 16 * kDegree) rows.push_back(row);
  const Campaign with_gap = all.select(rows);
  std::vector<double> angles;
  for (const JointVector& q : with_gap.q) angles.push_back(q[3]);
  int searched = 0, in_gap = 0;
  for (const Candidate& found : open_candidates(robot, with_gap)) {
    if (found.effect.shape.basis != SeriesBasis::bump || found.effect.driver.joint != 3) continue;
    std::vector<Candidate> bumps = refined_candidates(found, with_gap);
    bumps.push_back(found);
    for (const Candidate& bump : bumps) {
      const Shape& shape = bump.effect.shape;
      EXPECT_GE(shown(shape, angles), 0.25) << shape.low[0] << " to " << shape.high[0];
      ++searched;
      const double middle = 0.5 * (shape.low[0] + shape.high[0]);
      in_gap += std::abs(middle - 52 * kDegree) < 10 * kDegree;
    }
  }
  EXPECT_GT(searched, 1000);
  EXPECT_GT(in_gap, 0);  // wide ones, which the readings beside it show
}

}  // namespace
}  // namespace armtrue
