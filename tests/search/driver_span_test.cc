#include "search/driver_span.h"

#include <gtest/gtest.h>

#include <functional>

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
  c.time_s.clear();
  const auto driver = session_driver(c);
  ASSERT_TRUE(driver);
  EXPECT_EQ(driver->sessions, (std::vector<std::string>{"b", "a"}));
  EXPECT_EQ(span_of(*driver, c).values, (std::vector<double>{0, 1}));
  EXPECT_EQ(step_places(span_of(*driver, c), kStepGrid), std::vector<double>{0.5});
  EXPECT_TRUE(is_driven(*driver, c, {}));
}

}  // namespace
}  // namespace armtrue
