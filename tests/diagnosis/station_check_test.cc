// Mistakes of the set-up that leave plausible numbers: one session, or the instrument, is another.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/campaign/simulation.h"
#include "armtrue/diagnosis/diagnosis.h"
#include "armtrue/diagnosis/mistakes.h"
#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/conventions.h"
#include "armtrue/kinematics/units.h"

namespace armtrue::station_check_test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

Robot spindle() { return read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot; }

// The arm that is measured, by an instrument that stands some metres from it.
Robot real_arm() {
  Robot truth = read_robot(ARMTRUE_CONFIG "/robots/kr360-table4.yaml").robot;
  truth.chain.base = {rotation_from_abc(0.3, 0.02, -0.01), {2.5, -3.5, 0.4}};
  return truth;
}

Robot from_another_station(Robot truth) {
  truth.chain.base = {rotation_from_abc(-1.2, -0.01, 0.02), {3.5, 2.5, 0.6}};
  return truth;
}

Campaign points_of(const Robot& truth, std::uint64_t seed = 1, int poses = 60) {
  SimulationOptions options;
  options.poses = poses;
  options.orientation = false;
  options.noise_position = 0.05 * kMillimetre;
  options.seed = seed;
  return simulate(spindle(), truth, options);
}

// The rows of the later half are those of the second campaign, of the same poses.
Campaign in_two_sessions(Campaign first, const Campaign& second) {
  first.session_names = {"monday", "tuesday"};
  for (int row = 0; row < first.rows(); ++row) {
    const bool later = row >= first.rows() / 2;
    first.session.push_back(later ? 1 : 0);
    if (later) first.position[row] = second.position[row];
  }
  return first;
}

void longer_by(double constant, Eigen::Vector3d& point) { point *= 1 + constant / point.norm(); }

std::vector<std::string> all_findings(const Robot& robot, const Campaign& campaign) {
  std::vector<std::string> all = diagnose(robot, campaign);
  const Findings found = find_suspicions(robot, campaign);
  all.insert(all.end(), found.errors.begin(), found.errors.end());
  all.insert(all.end(), found.warnings.begin(), found.warnings.end());
  return all;
}

TEST(StationCheck, RightSessionsHaveNoFindings) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
    EXPECT_THAT(
        all_findings(spindle(), in_two_sessions(points_of(real_arm(), seed),
                                                points_of(from_another_station(real_arm()), seed))),
        IsEmpty())
        << seed;
}

TEST(StationCheck, WhatIsAnotherInASessionIsNamed) {
  struct Mistake {
    std::string name;
    std::function<void(Robot&)> of_arm;
    std::function<void(Campaign&)> of_readings;
    std::string says;
  };
  const auto none = [](auto&) {};
  const std::vector<Mistake> mistakes{
      {"arm mastered", [](Robot& r) { r.chain.links[4].theta += 0.3 * kDegree; }, none,
       "in session 'tuesday' the zero of A5 is 0.30"},
      {"reflector seated anew",
       [](Robot& r) { r.chain.tool.translation += Eigen::Vector3d(1e-3, 0, 2e-3); }, none,
       "the reflector is elsewhere on the tool, 2.2"},
      {"scale", none,
       [](Campaign& c) {
         for (auto& p : c.position) p *= 1.002;
       },
       "in session 'tuesday' the instrument reads lengths 0.2 % longer"},
      {"constant of the reflector", none,
       [](Campaign& c) {
         for (auto& p : c.position) longer_by(-0.01, p);
       },
       "in session 'tuesday' the points lie 10 mm too near to the place of the instrument"},
      {"a sign", none,
       [](Campaign& c) {
         for (auto& p : c.position) p.y() *= -1;
       },
       "session 'tuesday': the positions look left-handed"},
      {"a unit", none,
       [](Campaign& c) {
         for (auto& p : c.position) p /= 25.4;
       },
       "session 'tuesday': the lengths look like inches"},
  };
  for (const Mistake& mistake : mistakes) {
    Robot arm = from_another_station(real_arm());
    mistake.of_arm(arm);
    Campaign second = points_of(arm);
    mistake.of_readings(second);
    EXPECT_THAT(all_findings(spindle(), in_two_sessions(points_of(real_arm()), second)),
                Contains(HasSubstr(mistake.says)))
        << mistake.name;
  }
}

TEST(StationCheck, WhatAllSessionsShareIsNamed) {
  Campaign scaled =
      in_two_sessions(points_of(real_arm()), points_of(from_another_station(real_arm())));
  Campaign farther = scaled;
  for (Eigen::Vector3d& point : scaled.position) point *= 1.01;
  for (Eigen::Vector3d& point : farther.position) longer_by(0.01, point);
  EXPECT_THAT(all_findings(spindle(), scaled), Contains(HasSubstr("longer by 1 % alike")));
  EXPECT_THAT(all_findings(spindle(), farther),
              Contains(HasSubstr("too far from the place of the instrument, the origin")));
}

TEST(StationCheck, AConstantOfTheReflectorIsNamed) {
  Campaign campaign = points_of(real_arm());
  for (Eigen::Vector3d& point : campaign.position) longer_by(-0.0344, point);
  EXPECT_THAT(all_findings(spindle(), campaign),
              Contains(HasSubstr("mm too near to the place of the instrument")));
}

// The positions that a controller shows are those of its model.
TEST(StationCheck, ComputedPointsAreNoReadings) {
  Robot shown = spindle();
  shown.chain.tool.translation = {0.1, 0.02, 0.25};
  SimulationOptions options;
  options.poses = 20;
  options.orientation = false;
  Campaign campaign = simulate(spindle(), shown, options);
  for (Eigen::Vector3d& point : campaign.position)
    for (double& x : point) x = 1e-6 * std::round(1e6 * x);
  EXPECT_THAT(find_computed_points(spindle(), campaign).value_or(""),
              HasSubstr("as no arm is made"));
  for (int row = 0; row < campaign.rows(); ++row)
    campaign.position[row].x() += row % 2 == 0 ? 5e-5 : -5e-5;
  EXPECT_EQ(find_computed_points(spindle(), campaign), std::nullopt);
}

// A base of its own fits the pose of a session exactly.
TEST(StationCheck, SessionsOfOnePoseAreNotCalledComputed) {
  constexpr int kAlone = 15, kTogether = 4;
  Campaign campaign =
      simulate(spindle(), real_arm(),
               {.poses = kAlone + kTogether, .noise_position = 1e-4, .noise_orientation = 1e-4});
  for (int row = 0; row < campaign.rows(); ++row) campaign.session.push_back(std::min(row, kAlone));
  for (int s = 0; s <= kAlone; ++s) campaign.session_names.push_back(std::to_string(s));
  EXPECT_EQ(find_computed_points(spindle(), campaign), std::nullopt);
}

// A calibration follows them, but what it is compared with is another model.
TEST(StationCheck, ARobotFileOfAnotherModelIsNamed) {
  const Campaign campaign = points_of(real_arm());
  Robot longer = spindle(), turned = spindle();
  longer.chain.links[2].d += 0.05;
  turned.chain.links[2].theta += 10 * kDegree;
  EXPECT_THAT(all_findings(longer, campaign),
              Contains(HasSubstr("is the robot file that of this")));
  EXPECT_THAT(all_findings(turned, campaign), Contains(HasSubstr("is the zero of this joint")));
  EXPECT_THAT(all_findings(spindle(), campaign), IsEmpty());
}

TEST(StationCheck, ExchangedColumnsAreNamedWhicheverTheyAre) {
  for (const auto& [j, k] : {std::pair{3, 5}, {0, 3}, {1, 4}}) {
    Campaign campaign = points_of(real_arm());
    for (auto q : campaign.q) std::swap(q[j], q[k]);
    EXPECT_THAT(all_findings(spindle(), campaign),
                Contains(HasSubstr("q" + std::to_string(j + 1) + "_deg and q" +
                                   std::to_string(k + 1) + "_deg look exchanged")));
  }
}

TEST(StationCheck, ARailInMetresIsNamed) {
  const Robot rail = read_robot(ARMTRUE_CONFIG "/robots/kr360-rail.yaml").robot;
  Robot truth = rail;
  for (Link& link : truth.chain.links) link.theta += 1e-3;
  Campaign campaign = simulate(rail, truth, {.poses = 40, .noise_position = 5e-5});
  EXPECT_THAT(all_findings(rail, campaign), IsEmpty());
  for (auto q : campaign.q) q[0] *= 1e-3;
  EXPECT_THAT(all_findings(rail, campaign), Contains(HasSubstr("name the column e1_m")));
}

// In one session the zero of a joint jumps, as when a motor slips.
TEST(StationCheck, AZeroThatJumpsIsNamed) {
  Robot later = real_arm();
  later.chain.links[2].theta += 0.1 * kDegree;
  Campaign campaign = in_two_sessions(points_of(real_arm()), points_of(later));
  campaign.session.clear();
  campaign.session_names.clear();
  EXPECT_THAT(all_findings(spindle(), campaign),
              Contains(HasSubstr("the zero of A3 is 0.0993 deg away")));
}

// The readings from a share of them on are those of another campaign of the same poses.
void go_on_with(const Campaign& other, double share, Campaign& campaign) {
  for (int row = static_cast<int>(share * campaign.rows()); row < campaign.rows(); ++row) {
    campaign.position[row] = other.position[row];
    if (campaign.has_orientation()) campaign.orientation[row] = other.orientation[row];
  }
}

Campaign poses_of(const Robot& truth, bool orientation) {
  SimulationOptions options;
  options.noise_position = 0.05 * kMillimetre;
  options.noise_orientation = 0.1 * kMilliradian;
  options.orientation = orientation;
  return simulate(spindle(), truth, options);
}

// Where no part has most of the readings, no fit to all is near one of them.
TEST(StationCheck, AnInstrumentThatWasMovedIsNamedWhereverItWas) {
  std::vector<Robot> moved(3, real_arm());
  moved[0] = from_another_station(real_arm());
  moved[1].chain.base.translation += Eigen::Vector3d(0.05, 0.03, 0);
  moved[2].chain.base.rotation = rotation_from_abc(0.3 + 3, 0.02, -0.01);
  for (const Robot& after : moved)
    for (const bool orientation : {false, true})
      for (const double share : {0.2, 0.4, 0.5, 0.55, 0.7}) {
        Campaign campaign = poses_of(real_arm(), orientation);
        go_on_with(poses_of(after, orientation), share, campaign);
        const int time = 20 * static_cast<int>(share * campaign.rows());
        EXPECT_THAT(all_findings(spindle(), campaign),
                    Each(AllOf(HasSubstr("from t_s = " + std::to_string(time) + " on"),
                               HasSubstr("in another frame"),
                               HasSubstr("--new-session-at-s " + std::to_string(time) + " or"))))
            << share << (orientation ? " poses" : " points");
        EXPECT_THAT(all_findings(spindle(), campaign), Not(IsEmpty()));
      }
}

TEST(StationCheck, AnInstrumentThatWasMovedTwiceIsNamed) {
  Robot third = real_arm();
  third.chain.base.translation.x() -= 1;
  Campaign campaign = poses_of(real_arm(), false);
  go_on_with(poses_of(from_another_station(real_arm()), false), 0.3, campaign);
  go_on_with(poses_of(third, false), 0.65, campaign);
  EXPECT_THAT(all_findings(spindle(), campaign),
              Contains(HasSubstr("--new-session-at-s 360 --new-session-at-s 780 or")));
}

TEST(StationCheck, AToolThatIsChangedAtHalfIsNamed) {
  Robot later = real_arm();
  later.chain.tool.translation += Eigen::Vector3d(0.06, 0, 0.08);
  Campaign campaign = poses_of(real_arm(), true);
  go_on_with(poses_of(later, true), 0.5, campaign);
  EXPECT_THAT(all_findings(spindle(), campaign),
              Contains(HasSubstr("from t_s = 600 on, in the order of the times, the reflector is "
                                 "elsewhere on the tool, 100 mm")));
}

// No frame and no tool makes right readings of these.
TEST(StationCheck, WrongColumnsOfHalfTheRowsAreNoMovedInstrument) {
  std::vector<std::function<void(Campaign&, int)>> mistakes;
  for (const int j : {0, 2, 5}) {
    mistakes.emplace_back([j](Campaign& c, int row) { c.q[row][j] *= -1; });
    mistakes.emplace_back(
        [j](Campaign& c, int row) { std::swap(c.q[row][j], c.q[row][(j + 2) % 6]); });
  }
  for (const double factor : {1e-3, 1 / 25.4, 1000.0})
    mistakes.emplace_back([factor](Campaign& c, int row) { c.position[row] *= factor; });
  mistakes.emplace_back([](Campaign& c, int row) { c.q[row] *= kDegree; });
  mistakes.emplace_back([](Campaign& c, int row) { c.position[row].x() *= -1; });
  mistakes.emplace_back(
      [](Campaign& c, int row) { std::swap(c.position[row].y(), c.position[row].z()); });
  for (size_t k = 0; k < mistakes.size(); ++k) {
    Campaign campaign = points_of(real_arm());
    for (int row = campaign.rows() / 2; row < campaign.rows(); ++row) mistakes[k](campaign, row);
    const Findings found = find_mistakes(spindle(), campaign);
    EXPECT_THAT(found.errors, SizeIs(1)) << k;
    EXPECT_THAT(found.errors,
                Each(AllOf(Not(HasSubstr("another frame")), Not(HasSubstr("elsewhere")))))
        << k;
  }
}

// Twelve points leave hardly more freedom than another base has unknowns.
TEST(StationCheck, FewRightPointsAreInOneFrame) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed)
    EXPECT_THAT(all_findings(spindle(), points_of(real_arm(), seed, 12)), IsEmpty()) << seed;
}

}  // namespace
}  // namespace armtrue::station_check_test
