// Mistakes of a log that leave plausible numbers: each must be an error or a warning that names it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "armtrue/calibration/doubts.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/diagnosis/diagnosis.h"
#include "armtrue/diagnosis/log_check.h"
#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/chain.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/pose.h"
#include "armtrue/kinematics/units.h"

namespace armtrue::silent_numbers_test {
namespace {

using testing::Contains;
using testing::ContainsRegex;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Robot spindle() { return read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot; }

// 60 poses, each visited three times.
Campaign tutorial() { return read_campaign(ARMTRUE_CONFIG "/campaigns/tutorial.csv").campaign; }

std::vector<std::string> all_findings(const Robot& robot, const Campaign& campaign) {
  std::vector<std::string> all = diagnose(robot, campaign);
  for (const Findings& found :
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

// From a row on, each reading is that of the row before.
Campaign with_readings_late(int from) {
  Campaign campaign = tutorial();
  for (int row = campaign.rows() - 1; row >= from; --row) {
    campaign.position[row] = campaign.position[row - 1];
    campaign.orientation[row] = campaign.orientation[row - 1];
  }
  return campaign;
}

// One visit of each pose, and a change that begins at half of them.
Campaign with_half_changed(bool first, const RowChange& change) {
  std::vector<int> once;
  std::set<int> seen;
  const Campaign all = tutorial();
  for (int row = 0; row < all.rows(); ++row)
    if (seen.insert(all.pose[row]).second) once.push_back(row);
  Campaign campaign = all.select(once);
  for (int row = 0; row < campaign.rows(); ++row)
    if ((2 * row < campaign.rows()) == first) change(campaign, row);
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

Campaign in_order_of_visits(const Campaign& campaign) {
  std::vector<int> rows(campaign.q.size());
  for (size_t k = 0; k < rows.size(); ++k) rows[k] = static_cast<int>(k);
  std::ranges::stable_sort(rows, {}, [&](int row) { return campaign.time_s[row]; });
  return campaign.select(rows);
}

Campaign with_temperatures(double first) {
  Campaign campaign = tutorial();
  campaign.temperature_names = {"arm"};
  for (int row = 0; row < campaign.rows(); ++row)
    campaign.temperature_c.push_back({first + 0.05 * row});
  return campaign;
}

// A thermometer of steps of 0.05 K that gives a mark in every tenth visit.
Campaign with_lost_temperatures(double mark) {
  Campaign campaign = with_temperatures(20);
  for (int row = 0; row < campaign.rows(); row += 10) campaign.temperature_c[row][0] = mark;
  return campaign;
}

// It is switched on after forty visits.
Campaign with_a_late_thermometer() {
  Campaign campaign = tutorial();
  campaign.temperature_names = {"arm"};
  const Campaign ordered = in_order_of_visits(campaign);
  campaign = ordered;
  for (int row = 0; row < campaign.rows(); ++row)
    campaign.temperature_c.push_back({row < 40 ? 0 : 20 + 0.01 * row});
  return campaign;
}

Campaign with_lost_times(double mark) {
  Campaign campaign = in_order_of_visits(tutorial());
  for (int row = 5; row < campaign.rows(); row += 10) campaign.time_s[row] = mark;
  return campaign;
}

// A force that a sensor reads.
Campaign with_lost_forces(const Eigen::Vector3d& mark) {
  Campaign campaign = tutorial();
  for (int row = 0; row < campaign.rows(); ++row)
    campaign.force_n.push_back(row % 10 == 3
                                   ? mark
                                   : Eigen::Vector3d(200 + 0.31 * row, -50 + 0.17 * row, 0.07 * row));
  return campaign;
}

Campaign with_lost_torques(double mark) {
  Campaign campaign = tutorial();
  for (int row = 0; row < campaign.rows(); ++row) {
    auto& torque = campaign.motor_torque_nm.emplace_back();
    for (size_t j = 0; j < 6; ++j)
      torque[j] = row % 10 == 3 ? mark : 100.0 * static_cast<double>(j) - 0.37 * row;
  }
  return campaign;
}

Campaign with_payloads(double mark) {
  Campaign campaign = in_order_of_visits(tutorial());
  for (int row = 0; row < campaign.rows(); ++row)
    campaign.payload_kg.push_back(row % 12 == 3 ? mark : row < 90 ? 120 : 240);
  return campaign;
}

// The angles that are logged are those of a moment before standstill, when each joint still had
// `way` to go; in every n-th visit.
Campaign with_early_angles(double way, int n = 1) {
  Campaign campaign = tutorial();
  for (int row = 0; row < campaign.rows(); row += n)
    for (int j = 0; j < campaign.q[row].size(); ++j)
      campaign.q[row][j] -= way * campaign.arrival[row][static_cast<size_t>(j)];
  return campaign;
}

// Each gear has its own backlash, and its joint leads (factor 1) or lags (-1).
Campaign with_backlash_of_all_joints(double factor) {
  constexpr std::array<double, 6> kOfJoint{1.1e-4, 1.3e-4, 5e-5, 7e-5, 2e-4, 1.2e-4};  // rad
  Campaign campaign = tutorial();
  for (int row = 0; row < campaign.rows(); ++row)
    for (size_t j = 0; j < kOfJoint.size(); ++j)
      campaign.q[row][static_cast<Eigen::Index>(j)] -=
          factor * kOfJoint[j] * campaign.arrival[row][j];
  return campaign;
}

// Angles of a moment when each joint still had this share of its last motion to go.
Campaign with_a_share_to_go(double share) {
  const Campaign stood = in_order_of_visits(tutorial());
  Campaign campaign = stood;
  for (int row = 1; row < campaign.rows(); ++row)
    campaign.q[row] -= share * (stood.q[row] - stood.q[row - 1]);
  return campaign;
}

// An arm that is made as its file says, and read as one.
Campaign as_the_file_says(std::uint64_t seed) {
  return simulate(spindle(), spindle(),
                  {.poses = 60, .repeats = 2, .noise_position = 1e-4, .noise_orientation = 1.5e-4,
                   .seed = seed});
}

Campaign of_table_4(std::uint64_t seed) {
  const Robot truth = read_robot(ARMTRUE_CONFIG "/robots/kr360-table4.yaml").robot;
  return simulate(spindle(), truth,
                  {.poses = 60, .repeats = 2, .noise_position = 1e-4, .noise_orientation = 1.5e-4,
                   .seed = seed});
}

// Measured points, and the orientations that the model of a controller gives at the joint angles.
Campaign with_orientations_of(const Robot& controller, std::uint64_t seed) {
  Campaign campaign = of_table_4(seed);
  const ChainEvaluator chain(controller.chain);
  for (int row = 0; row < campaign.rows(); ++row)
    campaign.orientation[row] = Eigen::Quaterniond(chain.pose(campaign.q[row]).rotation);
  return campaign;
}

Campaign with_orientations(const std::function<Eigen::Quaterniond(Eigen::Quaterniond)>& written) {
  Campaign campaign = tutorial();
  for (Eigen::Quaterniond& q : campaign.orientation) q = written(q);
  return campaign;
}

// As a camera on the arm gives its board.
Campaign inverted(Campaign campaign) {
  for (int row = 0; row < campaign.rows(); ++row) {
    campaign.orientation[row] = campaign.orientation[row].conjugate();
    campaign.position[row] = -(campaign.orientation[row] * campaign.position[row]);
  }
  return campaign;
}

// The depth that a camera reads is long; the camera stands `away` and looks along z of R_A.
Campaign of_a_long_camera(double factor) {
  Campaign campaign = tutorial();
  for (Eigen::Vector3d& point : campaign.position) {
    point.z() += 4;
    point.z() *= factor;
  }
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
      {"the later half in metres", with_half_changed(false, scaled(1e-3)),
       "30 rows of 30 poses, the first in line 32, do not fit the others: their positions look "
       "like metres among millimetres"},
      {"a row lost at two thirds", with_readings_late(120),
       "the first in line 122, do not fit the others: their readings stand 1 row later than their "
       "joint angles"},
      {"the first half of the angles in radians", with_half_changed(true, angles_in_radians),
       "30 rows of 30 poses, the first in line 2, do not fit the others: their joint angles look "
       "like radians among degrees"},
      {"a third of joint 4 in radians",
       with_poses_changed(3, [](Campaign& c, int row) { c.q[row][3] *= kDegree; }),
       "q4 looks like radians among degrees in them"},
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
      {"angles rounded in rad", with_rounded_angles(1e-3 / kDegree),
       "the joint angles have steps of 0.001 rad"},
      {"another tool from a time on", with_two_tools(true),
       "in the order of the times, the reflector is elsewhere on the tool, 2.2"},
      {"another tool from a time on, points", with_two_tools(false),
       "in the order of the times, the reflector is elsewhere on the tool, 2.2"},
      {"the higher poses in another frame", in_two_frames([](const Campaign& c, int row) {
         return std::stoi(c.pose_ids[c.pose[row]]) > 30;
       }),
       "in the order of the poses, the readings lie in another frame"},
      {"rows doubled", doubled(true), "hold the same as another, time included"},
      {"a session copied", with_a_session_copied(), "hold the same as another in another session"},
      {"temperatures in kelvin", with_temperatures(291.15), "are these kelvin?"},
      {"temperatures in Fahrenheit", with_temperatures(64), "are these degrees Fahrenheit"},
      {"-127 deg C", with_lost_temperatures(-127), "temp_arm_c is -127 deg C in 18 rows"},
      {"0 deg C", with_lost_temperatures(0), "temp_arm_c is 0 deg C in 18 rows"},
      {"85 deg C", with_lost_temperatures(85), "temp_arm_c is 85 deg C in 18 rows"},
      {"the thermometer on late", with_a_late_thermometer(), "was the sensor connected"},
      {"times of 0", with_lost_times(0), "t_s is 0 s in 19 rows"},
      {"times of -1", with_lost_times(-1), "t_s is -1 s in 18 rows"},
      {"forces of -9999", with_lost_forces(Eigen::Vector3d::Constant(-9999)),
       "fx_n, fy_n and fz_n are all -9999 N in 18 rows"},
      {"forces of 3276.7 in x", with_lost_forces({3276.7, 1, 2}), "fx_n is 3276.7 N in 18 rows"},
      {"torques of -1", with_lost_torques(-1), "tau1_nm to tau6_nm are all -1 Nm in 18 rows"},
      {"torques of 0", with_lost_torques(0), "tau1_nm to tau6_nm are all 0 Nm in 18 rows"},
      {"payloads of 9999", with_payloads(9999), "payload_kg is 9999 kg in 15 rows"},
      {"payloads of 0", with_payloads(0), "payload_kg is 0 in 15 rows"},
      {"angles before standstill", with_early_angles(0.02 * kDegree),
       "not read at standstill: 6 of 6 joints went on from the angles that are logged by 0.02 deg"},
      {"angles ahead of the arm", with_early_angles(-0.02 * kDegree),
       "6 of 6 joints stay behind the angles that are logged by 0.02 deg"},
      {"a thousandth of the motion to go", with_a_share_to_go(0.001),
       "went on from the angles that are logged by 0.1 % of their last motion"},
      {"poses inverted", inverted(tutorial()), "the poses look inverted"},
      {"quaternions x, y, z, w", with_orientations([](const Eigen::Quaterniond& q) {
         return Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w());
       }),
       "x, y, z, w under the names qw,qx,qy,qz"},
      {"quaternions w, x, y, z", with_orientations([](const Eigen::Quaterniond& q) {
         return Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y());
       }),
       "as if qw came first"},
      {"inverted, with quaternions x, y, z, w",
       [] {
         Campaign campaign = inverted(tutorial());
         for (Eigen::Quaterniond& q : campaign.orientation) q = {q.x(), q.y(), q.z(), q.w()};
         return campaign;
       }(),
       "x, y, z, w under the names qw,qx,qy,qz; name the columns in the order of their values; "
       "with that, the poses look inverted"},
      {"depths 20 % short", of_a_long_camera(0.8),
       "along z of R_A the readings are 20 % too short"},
      {"depths 3 % long", of_a_long_camera(1.03), "along z of R_A the readings are 2.9 % too long"},
      {"all lengths 0.3 % long", with_poses_changed(1, scaled(1.003)),
       "the links come out longer by 0.32 % alike"},
      {"all lengths 1 % long", with_poses_changed(1, scaled(1.01)),
       "the links come out longer by 1 % alike"},
      {"all lengths 2 % short", with_poses_changed(1, scaled(0.98)),
       "the links come out shorter by 2 % alike"},
  };
}

// Of each reading one row stays.
TEST(SilentNumbers, CopiedRowsAreThoseOfOneReading) {
  const Campaign once = tutorial();
  EXPECT_THAT(copied_rows(once).rows, IsEmpty());
  for (const Campaign& twice : {doubled(false), doubled_later()}) {
    const CopiedRows copies = copied_rows(twice);
    ASSERT_EQ(std::ssize(copies.rows), once.rows());
    for (int row = 0; row < once.rows(); ++row) EXPECT_EQ(copies.rows[row], 2 * row + 1);
    EXPECT_EQ(copies.row, 1);
    EXPECT_EQ(copies.of, 0);
  }
}

// A display of steps of 0.05 mm makes visits equal by chance, in one coordinate more often than in
// all three. Copies among them are more than that.
TEST(SilentNumbers, EqualReadingsOfACoarseInstrumentAreNoCopies) {
  Campaign campaign = tutorial();
  for (Eigen::Vector3d& point : campaign.position)
    point = (point / 5e-5).array().round().matrix() * 5e-5;
  campaign.orientation.clear();
  EXPECT_THAT(copied_rows(campaign).rows, IsEmpty());
  std::map<int, int> first;
  int copied = 0;
  for (int row = 0; row < campaign.rows(); ++row)
    if (const auto [known, is_new] = first.try_emplace(campaign.pose[row], row);
        !is_new && campaign.pose[row] % 3 == 0) {
      campaign.position[row] = campaign.position[known->second];
      ++copied;
    }
  EXPECT_GE(std::ssize(copied_rows(campaign).rows), copied);
}

TEST(SilentNumbers, RightReadingsHaveNoFindings) {
  EXPECT_THAT(all_findings(spindle(), tutorial()), IsEmpty());
}

TEST(SilentNumbers, BacklashOfAllJointsIsNoEarlyReading) {
  for (const double factor : {-1.0, 1.0, 3.0})
    EXPECT_THAT(all_findings(spindle(), with_backlash_of_all_joints(factor)),
                Not(Contains(HasSubstr("standstill"))));
}

// The gears of a wrist move one joint with another; the robot file does not say so, or otherwise.
TEST(SilentNumbers, CouplingsOfAWristAreNamed) {
  const auto coupled = [](Robot robot, const std::vector<Coupling>& couplings) {
    for (const Coupling& coupling : couplings) robot.chain.couplings.push_back(coupling);
    return robot;
  };
  const auto findings = [](const Robot& robot, const Robot& truth) {
    return all_findings(
        robot,
        simulate(robot, truth,
                 {.poses = 60, .noise_position = 5e-5, .noise_orientation = 1e-4, .seed = 3}));
  };
  constexpr int kA4 = 3, kA5 = 4, kA6 = 5;
  const Robot one = coupled(spindle(), {{kA5, kA4, 0.0125}}),
              two = coupled(spindle(), {{kA5, kA4, 0.0125}, {kA6, kA5, -0.02}}),
              other = coupled(spindle(), {{kA6, kA5, -0.01}});
  // The last of three digits is noise.
  const auto names = [](const std::string& pair, const std::string& coefficient) {
    return Contains(ContainsRegex(pair + ".*: " + coefficient + "[}]"));
  };
  EXPECT_THAT(findings(spindle(), one), names("A5 with A4", "0.012[456]"));
  const auto of_two = findings(spindle(), two);
  EXPECT_THAT(of_two, names("A5 with A4", "0.012[456]"));
  EXPECT_THAT(of_two, names("A6 with A5", "-0.0(199|2|201)"));
  EXPECT_THAT(findings(other, coupled(spindle(), {{kA6, kA5, -0.02}})),
              names("A6 with A5", "-0.0(199|2|201)"));
  EXPECT_THAT(findings(two, two), IsEmpty());
  // So large that the file fits no more; a sign, as the file has the other.
  const Robot large = coupled(spindle(), {{kA6, kA4, 0.1}});
  EXPECT_THAT(diagnose(spindle(), simulate(spindle(), large, {.poses = 60, .seed = 3})),
              names("A6 with A4", "0[.](0999|1|100)"));
  EXPECT_THAT(
      findings(coupled(spindle(), {{kA6, kA5, 0.5}}), coupled(spindle(), {{kA6, kA5, -0.5}})),
      names("A6 with A5", "-0.5"));
}

TEST(SilentNumbers, TemperaturesOfAnArmAreNoMistake) {
  EXPECT_THAT(check_log(with_temperatures(18)).warnings, IsEmpty());
}

// A gear that warms up to 85 deg C and stays there, with steps of 1 K.
TEST(SilentNumbers, AHotGearIsNoMistake) {
  Campaign campaign = tutorial();
  campaign.temperature_names = {"gear3"};
  for (int row = 0; row < campaign.rows(); ++row)
    campaign.temperature_c.push_back({std::min(85.0, std::round(60 + 0.2 * row))});
  const Findings found = check_log(campaign);
  EXPECT_THAT(found.errors, IsEmpty());
  EXPECT_THAT(found.warnings, IsEmpty());
}

// Loads that are there and not there, and times of a coarse clock, repeat by themselves.
TEST(SilentNumbers, ValuesThatRepeatAreNoMistake) {
  Campaign loads = in_order_of_visits(tutorial());
  Campaign clock = loads;
  for (int row = 0; row < loads.rows(); ++row) {
    loads.payload_kg.push_back(row % 3 == 0 ? 0 : row % 3 == 1 ? 60 : 120);
    loads.force_n.emplace_back(row % 5 == 0 ? 0 : 500, 0, row % 5 == 1 ? -500 : 0);
    clock.time_s[row] = 60 * std::floor(clock.time_s[row] / 60);
  }
  for (const Campaign& campaign : {loads, clock}) {
    EXPECT_THAT(check_log(campaign).errors, IsEmpty());
    EXPECT_THAT(check_log(campaign).warnings, IsEmpty());
  }
}

// Three runs, each of which counts from zero, without sessions.
TEST(SilentNumbers, ClocksThatBeginAnewHoldNoLostTimes) {
  Campaign campaign = in_order_of_visits(tutorial());
  for (int row = 0; row < campaign.rows(); ++row)
    campaign.time_s[row] = 20.0 * (row % 60) + (row % 60 == 0 ? 0 : 0.01 * row);
  EXPECT_THAT(check_log(campaign).errors, IsEmpty());
}

TEST(SilentNumbers, OrientationsOfTheControllerAreNamed) {
  for (const std::uint64_t seed : {1, 2}) {
    const auto found =
        find_computed_orientations(spindle(), with_orientations_of(spindle(), seed));
    ASSERT_TRUE(found) << seed;
    EXPECT_THAT(*found, HasSubstr("they look computed by the controller"));
  }
}

// The controller's orientations in a part of the rows, in any order, or from a row on.
TEST(SilentNumbers, OrientationsOfTheControllerInSomeRowsAreNamed) {
  const auto at_random = [](int row) { return row * 7919 % 10 < 4; };
  const auto in_a_new_file = [](int row) { return row >= 36; };
  const auto most = [](int row) { return row % 5 != 0; };
  for (const std::uint64_t seed : {1, 2})
    for (const auto& is_computed :
         std::vector<std::function<bool(int)>>{at_random, in_a_new_file, most}) {
      Campaign campaign = of_table_4(seed);
      const Campaign computed = with_orientations_of(spindle(), seed);
      std::vector<int> lines;
      for (int row = 0; row < campaign.rows(); ++row)
        if (is_computed(row)) {
          campaign.orientation[row] = computed.orientation[row];
          lines.push_back(campaign.line[row]);
        }
      const auto found = find_computed_orientations(spindle(), campaign);
      ASSERT_TRUE(found) << seed;
      EXPECT_THAT(*found, HasSubstr(lines_in_words(lines)));
      EXPECT_THAT(*found, HasSubstr("those look computed by the controller"));
    }
}

// Poses under a load that turns the flange are not those of an instrument among computed ones.
TEST(SilentNumbers, ALoadInSomePosesIsNoMeasuringBesideComputing) {
  Campaign campaign =
      simulate(spindle(), spindle(), {.poses = 60, .noise_position = 1e-4, .seed = 1});
  for (int row = 0; row < campaign.rows(); row += 2) {
    const Eigen::Vector3d tilt(4e-4, -3e-4, 2e-4);
    campaign.orientation[row] =
        Eigen::AngleAxisd(tilt.norm(), tilt.normalized()) * campaign.orientation[row];
    campaign.position[row] += tilt.cross(campaign.position[row]);
  }
  EXPECT_EQ(find_computed_orientations(spindle(), campaign), std::nullopt);
}

TEST(SilentNumbers, MeasuredOrientationsAreNotNamed) {
  const Robot table_4 = read_robot(ARMTRUE_CONFIG "/robots/kr360-table4.yaml").robot;
  EXPECT_EQ(find_computed_orientations(spindle(), tutorial()), std::nullopt);
  for (const std::uint64_t seed : {1, 2, 3}) {
    EXPECT_EQ(find_computed_orientations(spindle(), of_table_4(seed)), std::nullopt);
    EXPECT_EQ(find_computed_orientations(table_4, of_table_4(seed)), std::nullopt);
    // Simulated without noise of the orientations: they agree with the points.
    const Campaign exact =
        simulate(spindle(), table_4, {.poses = 60, .noise_position = 1e-4, .seed = seed});
    EXPECT_EQ(find_computed_orientations(spindle(), exact), std::nullopt);
    EXPECT_EQ(find_computed_orientations(table_4, exact), std::nullopt);
  }
}

TEST(SilentNumbers, AnArmThatNeedsNoCalibrationIsNamed) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto found = find_needless_calibration(spindle(), as_the_file_says(seed));
    ASSERT_TRUE(found) << seed;
    EXPECT_THAT(*found, HasSubstr("Is the absolute accuracy of the controller active"));
    EXPECT_EQ(find_needless_calibration(spindle(), of_table_4(seed)), std::nullopt);
  }
}

// Axis 3 of the tutorial's arm gives way under gravity.
TEST(SilentNumbers, AGravityThatPointsUpIsNamed) {
  Robot ceiling = spindle();
  ceiling.gravity = -ceiling.gravity;
  EXPECT_THAT(find_suspicions(ceiling, tutorial()).warnings,
              ElementsAre(HasSubstr("A3 turns against the torque of gravity")));
  EXPECT_THAT(find_suspicions(spindle(), tutorial()).warnings, IsEmpty());
  for (const std::uint64_t seed : {1, 2, 3})
    EXPECT_THAT(find_suspicions(ceiling, of_table_4(seed)).warnings, IsEmpty());
}

// Base and tool take up all that a table of one axis does.
TEST(SilentNumbers, ATableOfOneAxisIsAskedNothing) {
  Robot table = spindle();
  table.chain.links.resize(1);
  table.chain.links.front().r = 0.5;
  table.bodies.clear();
  Robot truth = table;
  truth.chain.tool.translation.x() += 1.5e-3;
  const Campaign readings = simulate(
      table, truth,
      {.poses = 60, .repeats = 2, .noise_position = 1e-4, .noise_orientation = 1.5e-4, .seed = 1});
  EXPECT_EQ(find_needless_calibration(table, readings), std::nullopt);
}

TEST(SilentNumbers, LimitsInAnotherUnitAreNamed) {
  const auto found = [](double factor) {
    Robot robot = spindle();
    for (Link& link : robot.chain.links) {
      link.min *= factor;
      link.max *= factor;
    }
    return check_limits(robot).warnings;
  };
  EXPECT_THAT(found(1), IsEmpty());
  EXPECT_THAT(found(kDegree), Contains(HasSubstr("radians")));
  EXPECT_THAT(found(0.1), Contains(HasSubstr("ten times too small")));
  EXPECT_THAT(found(10), Contains(HasSubstr("ten times too large")));
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

// One wrong reading bends a fit by least squares, and another frame from some reading on
// straightens it. Beside a frame that did move it hides nothing.
TEST(SilentNumbers, OneBlunderIsNoMovedFrame) {
  const Robot truth = read_robot(ARMTRUE_CONFIG "/robots/kr360-table4.yaml").robot;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SimulationOptions options{.poses = 40, .repeats = 2, .noise_position = 3e-5, .seed = seed};
    options.orientation = false;
    Campaign campaign = simulate(spindle(), truth, options);
    const auto rows = static_cast<std::uint64_t>(campaign.rows());
    campaign.position[static_cast<int>(7 * seed % rows)].x() += 0.015;
    EXPECT_THAT(find_suspicions(spindle(), campaign).warnings, IsEmpty()) << seed;
    for (int row = 40; row < campaign.rows(); ++row) campaign.position[row].y() += 2e-3;
    EXPECT_THAT(find_suspicions(spindle(), campaign).warnings,
                Contains(HasSubstr("lie in another frame")))
        << seed;
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

// The tutorial's first visits before, and later ones after the zero of A3 has moved by 0.1 deg.
Campaign with_a_moved_zero() {
  Campaign campaign = tutorial();
  const std::vector<double>& times = campaign.time_s;
  const double middle = (*std::ranges::min_element(times) + *std::ranges::max_element(times)) / 2;
  for (int row = 0; row < campaign.rows(); ++row)
    if (times[row] > middle) campaign.q[row][2] += 0.1 * kDegree;
  return campaign;
}

TEST(SilentNumbers, AMovedZeroExplainsWhatAFitLeaves) {
  const Campaign campaign = with_a_moved_zero();
  const auto explanation = explanation_of_rest(calibrate(spindle(), campaign), campaign);
  ASSERT_TRUE(explanation);
  EXPECT_THAT(*explanation, HasSubstr("the zero of A3 is 0.10"));
}

TEST(SilentNumbers, WhatTheModelHoldsExplainsNoRest) {
  const Campaign as_it_was = tutorial();
  EXPECT_FALSE(explanation_of_rest(calibrate(spindle(), as_it_was), as_it_was));
  // An effect that holds the step.
  const Campaign campaign = with_a_moved_zero();
  Robot robot = spindle();
  Effect& effect = robot.effects.emplace_back();
  effect.name = "re-mastered joint";
  effect.parameter = "A3.theta";
  effect.driver = parse_driver("time").value();
  effect.shape = parse_shape("step").value();
  const std::vector<double>& times = campaign.time_s;
  effect.shape.at = (*std::ranges::min_element(times) + *std::ranges::max_element(times)) / 2;
  EXPECT_FALSE(explanation_of_rest(calibrate(robot, campaign), campaign));
}

}  // namespace
}  // namespace armtrue::silent_numbers_test
