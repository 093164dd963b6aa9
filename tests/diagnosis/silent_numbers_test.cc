// Mistakes of a log that leave plausible numbers: each must be an error or a warning that names it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "armtrue/campaign/simulation.h"
#include "armtrue/diagnosis/diagnosis.h"
#include "armtrue/diagnosis/log_check.h"
#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/pose.h"
#include "armtrue/kinematics/units.h"

namespace armtrue::silent_numbers_test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

Robot spindle() { return read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot; }

// 60 poses, each visited three times.
Campaign tutorial() { return read_campaign(ARMTRUE_CONFIG "/campaigns/tutorial.csv").campaign; }

std::vector<std::string> all_findings(const Robot& robot, const Campaign& campaign) {
  std::vector<std::string> all = diagnose(robot, campaign);
  for (const LogFindings& found :
       {check_log(campaign), check_travel(robot, campaign), find_suspicions(robot, campaign)}) {
    all.insert(all.end(), found.errors.begin(), found.errors.end());
    all.insert(all.end(), found.warnings.begin(), found.warnings.end());
  }
  return all;
}

using RowChange = std::function<void(Campaign&, int row)>;

// Changes every n-th pose.
Campaign with_poses_changed(int n, const RowChange& change) {
  Campaign campaign = tutorial();
  for (int row = 0; row < campaign.rows(); ++row)
    if (campaign.pose[row] % n == 0) change(campaign, row);
  return campaign;
}

RowChange scaled(double factor) {
  return [factor](Campaign& c, int row) { c.position[row] *= factor; };
}

void angles_in_radians(Campaign& c, int row) { c.q[row] *= kDegree; }

void orientation_in_radians(Campaign& c, int row) {
  const Eigen::Vector3d abc = kDegree * abc_from_rotation(c.orientation[row].toRotationMatrix());
  c.orientation[row] = rotation_from_abc(abc[0], abc[1], abc[2]);
}

RowChange exchanged(int j, int k) {
  return [j, k](Campaign& c, int row) { std::swap(c.q[row][j], c.q[row][k]); };
}

Campaign with_clock(const std::function<double(double)>& change) {
  Campaign campaign = tutorial();
  for (double& t : campaign.time_s) t = change(t);
  return campaign;
}

Campaign doubled(bool with_time) {
  const Campaign once = tutorial();
  std::vector<int> rows;
  for (int row = 0; row < once.rows(); ++row) rows.insert(rows.end(), 2, row);
  Campaign twice = once.select(rows);
  twice.repeat.clear();
  if (!with_time) twice.time_s.clear();
  return twice;
}

// The same readings, as if taken a day later.
Campaign doubled_later() {
  Campaign twice = doubled(true);
  for (int row = 0; row < twice.rows(); row += 2) twice.time_s[row] += 86400;
  return twice;
}

Campaign in_order_of_time_with_negated_directions() {
  Campaign campaign = tutorial();
  campaign.arrival.clear();
  campaign.stroke.clear();
  derive_arrival(campaign);
  for (Direction& directions : campaign.arrival)
    for (auto& direction : directions) direction = static_cast<std::int8_t>(-direction);
  return campaign;
}

// A file in the order of its visits whose clock begins anew after two thirds.
Campaign with_reset_clock() {
  Campaign campaign = tutorial();
  for (int row = 0; row < campaign.rows(); ++row)
    campaign.time_s[row] = 20.0 * (row < 120 ? row : row - 120);
  return campaign;
}

// The rows that `later` chooses in a frame that is turned and shifted.
Campaign in_two_frames(const std::function<bool(const Campaign&, int row)>& later) {
  Campaign campaign = tutorial();
  const Eigen::AngleAxisd turned(0.2 * kDegree, Eigen::Vector3d::UnitZ());
  for (int row = 0; row < campaign.rows(); ++row) {
    if (!later(campaign, row)) continue;
    campaign.position[row] = turned * campaign.position[row] + Eigen::Vector3d(2e-3, 0, 0);
    campaign.orientation[row] = turned * campaign.orientation[row];
  }
  return campaign;
}

Campaign with_rounded_angles(double step) {
  Campaign campaign = tutorial();
  for (auto q : campaign.q)
    for (double& angle : q) angle = step * kDegree * std::round(angle / (step * kDegree));
  return campaign;
}

// After half of the time the reflector sits elsewhere on the tool.
Campaign with_two_tools(bool orientation) {
  Campaign campaign = tutorial();
  for (int row = 0; row < campaign.rows(); ++row)
    if (campaign.time_s[row] > 2000)
      campaign.position[row] += campaign.orientation[row] * Eigen::Vector3d(1e-3, 0, 2e-3);
  if (!orientation) campaign.orientation.clear();
  return campaign;
}

Campaign with_a_session_copied() {
  Campaign campaign = doubled_later();
  campaign.session_names = {"monday", "tuesday"};
  for (int row = 0; row < campaign.rows(); ++row) campaign.session.push_back(row % 2);
  return campaign;
}

Campaign with_temperatures(double first) {
  Campaign campaign = tutorial();
  campaign.temperature_names = {"arm"};
  for (int row = 0; row < campaign.rows(); ++row)
    campaign.temperature_c.push_back({first + 0.05 * row});
  return campaign;
}

struct Mistake {
  std::string name;
  Campaign campaign;
  std::string says;
};

std::vector<Mistake> mistakes() {
  return {
      {"a tenth in metres", with_poses_changed(10, scaled(1e-3)), "metres among millimetres"},
      {"a third in metres", with_poses_changed(3, scaled(1e-3)), "metres among millimetres"},
      {"a tenth in inches", with_poses_changed(10, scaled(1 / 25.4)), "inches among millimetres"},
      {"a third in inches", with_poses_changed(3, scaled(1 / 25.4)), "inches among millimetres"},
      {"a third in centimetres", with_poses_changed(3, scaled(0.1)), "centimetres among"},
      {"a tenth of the angles in radians", with_poses_changed(10, angles_in_radians),
       "joint angles look like radians among degrees"},
      {"a third of the angles in radians", with_poses_changed(3, angles_in_radians),
       "joint angles look like radians among degrees"},
      {"a third of the orientations in radians", with_poses_changed(3, orientation_in_radians),
       "a, b, c look like radians among degrees"},
      {"joints 4 and 6 of a tenth exchanged", with_poses_changed(10, exchanged(3, 5)),
       "q4 and q6 look exchanged"},
      {"joints 4 and 5 of a third exchanged", with_poses_changed(3, exchanged(3, 4)),
       "q4 and q5 look exchanged"},
      {"an axis of a third mirrored",
       with_poses_changed(3, [](Campaign& c, int row) { c.position[row].y() *= -1; }),
       "y seems to have the wrong sign"},
      {"a turn of joint 2 counted",
       with_poses_changed(10, [](Campaign& c, int row) { c.q[row][1] += 2 * std::numbers::pi; }),
       "count no turns"},
      {"ten turns of joint 6 counted",
       with_poses_changed(1, [](Campaign& c, int row) { c.q[row][5] += 20 * std::numbers::pi; }),
       "count no turns"},
      {"the clock reset", with_reset_clock(), "was the clock reset?"},
      {"the clock still", with_clock([](double) { return 1000.0; }), "the clock stands still"},
      {"the clock in milliseconds", with_clock([](double t) { return 1e3 * t; }),
       "does it count milliseconds?"},
      {"the clock in hours", with_clock([](double t) { return t / 3600; }),
       "does it count minutes or hours?"},
      {"directions negated", in_order_of_time_with_negated_directions(), "is their sign wrong"},
      {"the later half in another frame",
       in_two_frames([](const Campaign& c, int row) { return c.time_s[row] > 2000; }),
       "in the order of the times, the readings lie in another frame"},
      {"the last lines in another frame",
       in_two_frames([](const Campaign& c, int row) { return 3 * row > 2 * c.rows(); }),
       "the readings lie in another frame"},
      {"angles rounded", with_rounded_angles(0.1), "the joint angles have steps of 0.1 deg"},
      {"another tool from a time on", with_two_tools(true),
       "in the order of the times, the reflector is elsewhere on the tool, 2.2"},
      {"another tool from a time on, points", with_two_tools(false),
       "in the order of the times, the reflector is elsewhere on the tool, 2.2"},
      {"the higher poses in another frame", in_two_frames([](const Campaign& c, int row) {
         return std::stoi(c.pose_ids[c.pose[row]]) > 30;
       }),
       "in the order of the poses, the readings lie in another frame"},
      {"rows doubled", doubled(true), "hold the same as another, time included"},
      {"rows without time doubled", doubled(false), "if they are copies, remove them"},
      {"rows doubled at a later time", doubled_later(), "but for the time"},
      {"a session copied", with_a_session_copied(), "hold the same as another in another session"},
      {"temperatures in kelvin", with_temperatures(291.15), "are these kelvin?"},
      {"all lengths 0.3 % long", with_poses_changed(1, scaled(1.003)),
       "the links come out longer by 0.32 % alike"},
      {"all lengths 1 % long", with_poses_changed(1, scaled(1.01)),
       "the links come out longer by 1 % alike"},
      {"all lengths 2 % short", with_poses_changed(1, scaled(0.98)),
       "the links come out shorter by 2 % alike"},
  };
}

TEST(SilentNumbers, RightReadingsHaveNoFindings) {
  EXPECT_THAT(all_findings(spindle(), tutorial()), IsEmpty());
}

TEST(SilentNumbers, TemperaturesOfAnArmAreNoMistake) {
  EXPECT_THAT(check_log(with_temperatures(18)).warnings, IsEmpty());
}

TEST(SilentNumbers, EachMistakeIsNamed) {
  const Robot robot = spindle();
  for (const Mistake& mistake : mistakes())
    EXPECT_THAT(all_findings(robot, mistake.campaign), Contains(HasSubstr(mistake.says)))
        << mistake.name;
}

// A tenth of a millimetre in a metre is how arms are made, and how instruments are.
TEST(SilentNumbers, LengthsOffByLittleAreNoMistake) {
  EXPECT_THAT(find_suspicions(spindle(), with_poses_changed(1, scaled(1.0001))).warnings,
              IsEmpty());
}

// Least squares can follow two such poses to an arm whose wrist is turned over.
TEST(SilentNumbers, ExchangedJointAnglesOfTwoPosesAreNoImpossibleArm) {
  const Robot truth = read_robot(ARMTRUE_CONFIG "/robots/kr360-table4.yaml").robot;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SimulationOptions options{.poses = 50, .repeats = 2, .noise_position = 1e-4, .seed = seed};
    options.orientation = false;
    Campaign campaign = simulate(spindle(), truth, options);
    JointVector first, second;
    for (int row = 0; row < campaign.rows(); ++row)
      (campaign.pose[row] == 0 ? first : second) = campaign.q[row];
    const int last = campaign.pose.back();
    for (int row = 0; row < campaign.rows(); ++row) {
      if (campaign.pose[row] == 0) campaign.q[row] = second;
      if (campaign.pose[row] == last) campaign.q[row] = first;
    }
    EXPECT_THAT(find_suspicions(spindle(), campaign).errors, IsEmpty()) << seed;
  }
}

// Gross poses are left out one by one: two alike are no mistake of the file.
TEST(SilentNumbers, TwoPosesAreNoMistakeOfTheFile) {
  Campaign campaign = tutorial();
  for (int row = 0; row < campaign.rows(); ++row)
    if (campaign.pose[row] < 2) campaign.position[row] *= 1e-3;
  EXPECT_THAT(diagnose(spindle(), campaign), IsEmpty());
}

// With a tool that is far from the file's, a few right readings fit a wrong arm nearly as well.
TEST(SilentNumbers, FewPosesAreNoMistakeOfTheFile) {
  Robot given = spindle();
  given.chain.tool.translation = {0.2, -0.15, 0.1};
  const Robot truth = read_robot(ARMTRUE_CONFIG "/robots/kr360-table4.yaml").robot;
  for (const int poses : {4, 5, 6, 8})
    for (unsigned seed = 1; seed <= 12; ++seed)
      for (const bool orientation : {false, true}) {
        SimulationOptions options;
        options.poses = poses;
        options.seed = seed;
        options.noise_position = options.noise_orientation = 1e-4;
        Campaign campaign = simulate(spindle(), truth, options);
        if (!orientation) campaign.orientation.clear();
        EXPECT_THAT(diagnose(given, campaign), IsEmpty()) << poses << " poses, seed " << seed;
      }
}

// Of a hundredth of a degree the sag of this arm and the noise are several times as much.
TEST(SilentNumbers, AnglesRoundedByLittleAreNoMistake) {
  EXPECT_THAT(all_findings(spindle(), with_rounded_angles(0.01)), IsEmpty());
}

// They do not show a wrong sign, but a wrong unit.
TEST(SilentNumbers, FewPosesShowAWrongUnit) {
  const Robot truth = read_robot(ARMTRUE_CONFIG "/robots/kr360-table4.yaml").robot;
  SimulationOptions options;
  options.poses = 5;
  options.noise_position = 1e-4;
  Campaign metres = simulate(spindle(), truth, options);
  metres.orientation.clear();
  Campaign radians = metres;
  for (Eigen::Vector3d& point : metres.position) point *= 1e-3;
  for (auto q : radians.q) q *= kDegree;
  EXPECT_THAT(diagnose(spindle(), metres), Contains(HasSubstr("look like metres")));
  EXPECT_THAT(diagnose(spindle(), radians), Contains(HasSubstr("look like radians")));
}

// Rows sorted by pose, each with the times of its visits: the clock was not reset.
TEST(SilentNumbers, RowsInAnotherOrderThanTheVisitsAreNoMistake) {
  const Campaign campaign = tutorial();
  std::vector<int> rows(campaign.q.size());
  for (size_t k = 0; k < rows.size(); ++k) rows[k] = static_cast<int>(k);
  std::ranges::stable_sort(rows, {}, [&](int row) { return campaign.pose[row]; });
  EXPECT_THAT(check_log(campaign.select(rows)).warnings, IsEmpty());
}

}  // namespace
}  // namespace armtrue::silent_numbers_test
