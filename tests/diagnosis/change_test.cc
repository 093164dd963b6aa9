#include "armtrue/diagnosis/change.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <utility>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/prediction.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/statistics/random.h"
#include "calibration/carried_campaign.h"
#include "support/thinned.h"
#include "tracing/hidden_campaign.h"

namespace armtrue::change_test {
namespace {

constexpr unsigned kNewPoses = 1000;  // seeds of the new poses lie apart from those calibrated on

Robot shipped(const std::string& name) {
  return read_robot(ARMTRUE_CONFIG "/robots/" + name + ".yaml").robot;
}

Campaign measured(const Robot& truth, int poses, int repeats, unsigned seed, double blunders = 0) {
  SimulationOptions options;
  options.poses = poses;
  options.repeats = repeats;
  options.seed = seed;
  options.noise_position = 0.095e-3;
  options.noise_orientation = 0.15e-3;
  options.blunders = blunders;
  return simulate(shipped("kr360-spindle"), truth, options);
}

struct Previous {
  Robot robot;
  ReadingSigma spread;
};

// A robot calibrated from 60 poses x 3, once for all tests.
const Previous& calibrated(unsigned seed, bool orientation) {
  static std::map<std::pair<unsigned, bool>, Previous> known;
  const auto [at, is_new] = known.try_emplace({seed, orientation});
  if (is_new) {
    Campaign campaign = measured(shipped("kr360-table4"), 60, 3, seed);
    if (!orientation) campaign.orientation.clear();
    const CalibrationResult result = calibrate(shipped("kr360-spindle"), campaign);
    at->second = {result.robot, result.spread};
    at->second.robot.uncertainty = uncertainty_of(result, campaign);
  }
  return at->second;
}

// New poses of such a robot, whose truth has moved.
ChangeResult after(unsigned seed, const std::map<std::string, double>& moved, double blunders = 0,
                   int repeats = 1, bool orientation = true, int poses = 10) {
  Robot truth = shipped("kr360-table4");
  for (const auto& [name, change] : moved)
    move_parameter(truth.chain, *find_parameter(truth.chain, name), change);
  Campaign fresh = measured(truth, poses, repeats, kNewPoses + seed, blunders);
  if (!orientation) fresh.orientation.clear();
  const Previous& previous = calibrated(seed, orientation);
  return detect_change(previous.robot, previous.spread, fresh);
}

// What is named first, and what cannot be told from it.
std::vector<Move> class_of(const ChangeResult& result) {
  if (result.moved.empty()) return {};
  std::vector<Move> moves{result.moved.front()};
  for (const Move& rival : moves.front().indistinguishable) moves.push_back(rival);
  return moves;
}

struct Count {
  int holds = 0, first = 0, in_class = 0, alone = 0;
  double covered = 0, after_over_before = 0, class_size = 0;
};

Count repeated(int seeds, const std::string& what, const std::map<std::string, double>& moved,
               double blunders = 0, int repeats = 1, bool orientation = true) {
  Count count;
  for (int seed = 1; seed <= seeds; ++seed) {
    const ChangeResult result = after(seed, moved, blunders, repeats, orientation);
    count.holds += result.holds;
    count.alone += result.moved.size() == 1;
    const std::vector<Move> moves = class_of(result);
    for (size_t k = 0; k < moves.size(); ++k) {
      const Move& move = moves[k];
      if (move.what != what) continue;
      count.first += k == 0;
      ++count.in_class;
      double inside = 0;
      for (const ParameterChange& change : move.changes) {
        const auto found = moved.find(parameter_name(shipped("kr360").chain, change.parameter));
        const double truth = found == moved.end() ? 0 : found->second;
        inside += change.ci95[0] <= truth && truth <= change.ci95[1];
      }
      count.covered += inside / static_cast<double>(move.changes.size());
    }
    count.class_size += static_cast<double>(moves.size());
    count.after_over_before += result.after / result.before;
  }
  std::printf(
      "%d seeds: holds %d, first %d, in the class %d (size %.1f), alone %d, intervals cover %.3f, "
      "after/before %.3f\n",
      seeds, count.holds, count.first, count.in_class, count.class_size / seeds, count.alone,
      count.covered / std::max(1, count.in_class), count.after_over_before / seeds);
  return count;
}

// At 1 per cent, six or more false alarms in 100 would come once in 2000 times, four or more in 50
// once in 600.
void expect_few_alarms(double blunders, int repeats, bool orientation) {
  const int part = thinned(2), seeds = 100 / part;
  EXPECT_GE(repeated(seeds, "", {}, blunders, repeats, orientation).holds,
            seeds - (part == 1 ? 5 : 3));
}

TEST(Change, HoldsWhenNothingHasChanged) { expect_few_alarms(0, 1, true); }

TEST(Change, HoldsWhenOneReadingInTenIsABlunder) { expect_few_alarms(0.1, 1, true); }

TEST(Change, HoldsOnPointsAndOnReplicates) {
  expect_few_alarms(0, 1, false);
  expect_few_alarms(0, 3, true);
}

// The spread that a calibration of 60 poses states is not exact: 1000 poses would show its error.
TEST(Change, HoldsFromManyPoses) {
  int holds = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) holds += after(seed, {}, 0, 1, true, 1000).holds;
  std::printf("1000 new poses: holds %d of 20\n", holds);
  EXPECT_GE(holds, 18);
}

// 0.1 to 0.2 mm at the tool: among 6000 coordinates their chi-square hardly shows it.
TEST(Change, FindsASmallMoveAmongManyPoses) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const ChangeResult result = after(seed, {{"A3.theta", 0.1e-3}}, 0, 1, true, 1000);
    EXPECT_FALSE(result.holds) << result.p_value;
    ASSERT_FALSE(result.moved.empty());
    EXPECT_EQ(result.moved.front().what, "A3.theta");
  }
}

TEST(Change, NamesAZeroOffsetThatHasMoved) {
  const Count count = repeated(20, "A2.theta", {{"A2.theta", 0.5e-3}});
  EXPECT_EQ(count.holds, 0);
  EXPECT_GE(count.in_class, 18);
}

TEST(Change, NamesAZeroOffsetBesideBlunders) {
  const Count count = repeated(20, "A2.theta", {{"A2.theta", 0.5e-3}}, 0.1);
  EXPECT_EQ(count.holds, 0);
  EXPECT_GE(count.in_class, 18);
}

TEST(Change, NamesABaseThatHasMoved) {
  const Count count = repeated(20, "base", {{"base.x", 0.8e-3}, {"base.y", 0.6e-3}});
  EXPECT_EQ(count.holds, 0);
  EXPECT_GE(count.in_class, 18);
}

TEST(Change, NamesABaseThatWasKnockedFar) {
  const Count count = repeated(20, "base", {{"base.x", 30e-3}, {"base.rz", 10e-3}});
  EXPECT_EQ(count.holds, 0);
  EXPECT_GE(count.in_class, 18);
  EXPECT_LT(count.after_over_before, 0.01 * 20);
}

TEST(Change, NamesAToolThatIsSeatedAnew) {
  const Count count =
      repeated(20, "tool", {{"tool.x", 0.3e-3}, {"tool.z", 0.2e-3}, {"tool.ry", 1e-3}});
  EXPECT_EQ(count.holds, 0);
  EXPECT_GE(count.in_class, 18);
}

TEST(Change, FindsTheVeryRowsThatAreBlunders) {
  const Robot truth = shipped("kr360-table4");
  const CalibrationResult previous = calibrate(shipped("kr360-spindle"), measured(truth, 60, 3, 1));
  Campaign fresh = measured(truth, 10, 1, kNewPoses);
  fresh.position[4].x() += 2e-3;
  const ChangeResult result = detect_change(previous.robot, previous.spread, fresh);
  EXPECT_EQ(result.blunders, std::vector<int>{4});
  EXPECT_TRUE(result.holds);
}

// From points the errors of base, tool and links are known only relative to each other. Taken as
// independent, they explained what they cannot: a zero 0.05 deg off held.
TEST(Change, PointsAloneShowWhatMoved) {
  for (const auto& [name, change] :
       std::map<std::string, double>{{"A3.theta", 0.35e-3}, {"A5.theta", 0.87e-3}}) {
    int holds = 0;
    for (unsigned seed = 1; seed <= 12; ++seed)
      holds += after(seed, {{name, change}}, 0, 1, false).holds;
    EXPECT_EQ(holds, 0) << name;
  }
  int holds = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) holds += after(seed, {}, 0, 1, false).holds;
  EXPECT_GE(holds, 38);
}

// Three moved at once: all are named, and nothing else, or it is said that something is left.
TEST(Change, NamesSeveralThatHaveMoved) {
  int all = 0, said = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const ChangeResult result =
        after(seed, {{"A2.theta", 0.5e-3}, {"A3.theta", -0.6e-3}, {"A5.theta", 0.8e-3}});
    EXPECT_FALSE(result.holds);
    std::vector<std::string> names;
    for (const Move& move : result.moved) names.push_back(move.what);
    const bool named =
        testing::Matches(testing::UnorderedElementsAre("A2.theta", "A3.theta", "A5.theta"))(names);
    all += named;
    said += named || result.p_value_left < kChangeSignificance;
  }
  std::printf("three moved: all named in %d of 20, or a rest in %d\n", all, said);
  EXPECT_GE(all, 18);
}

// Ten poses, each once.
Campaign ten_of(const Campaign& campaign) {
  std::vector<int> rows;
  for (int row = 0; rows.size() < 10; ++row)
    if (campaign.repeat[row] == campaign.repeat[0]) rows.push_back(row);
  return campaign.select(rows);
}

// Effects that geometry lacks put whole poses off. A calibration says how far: an arm that has not
// changed holds, also one whose poses were visited several times.
TEST(Change, HoldsBesideWhatTheGeometryLacks) {
  int holds = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = seed;
    const HiddenCampaign hidden(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml", "compliance", 0.2,
                                plan);
    const CalibrationResult previous = calibrate(shipped("kr360-spindle"), hidden.training);
    const ChangeResult result =
        detect_change(previous.robot, previous.spread, ten_of(hidden.held_out));
    holds += result.holds;
    if (result.moved.empty()) {
      EXPECT_LE(result.p_value, 2 * result.p_value_left);
    }
  }
  std::printf("compliance that geometry lacks: holds %d of 40\n", holds);
  EXPECT_GE(holds, 37);
}

// Each joint comes to rest elsewhere in every pose, so that all that is read of a pose errs alike:
// its readings count for fewer than they are. Taken as independent they hold in half of the cases.
TEST(Change, HoldsMoreOftenWhereReadingsOfAPoseErrAlike) {
  int holds = 0;
  for (unsigned seed = 1; seed <= 50; ++seed) {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = seed;
    plan.rest_mrad = 0.1;
    const HiddenCampaign hidden(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml", "null", 0, plan);
    const CalibrationResult previous = calibrate(shipped("kr360-spindle"), hidden.training);
    holds += detect_change(previous.robot, previous.spread, ten_of(hidden.held_out)).holds;
  }
  std::printf("joints at rest elsewhere: holds %d of 50\n", holds);
  EXPECT_GE(holds, 46);
}

// Each pose errs by another angle: no move explains it, and the poses scatter by their distance
// from the axis too, which is no overdispersion of noise.
TEST(Change, AnAxisThatIsLooseBreaksTheCalibration) {
  const Robot truth = shipped("kr360-table4");
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Campaign calibrated_on = measured(truth, 60, 2, seed);
    CalibrationResult previous = calibrate(shipped("kr360-spindle"), calibrated_on);
    previous.robot.uncertainty = uncertainty_of(previous, calibrated_on);
    Campaign fresh = measured(truth, 20, 2, kNewPoses + seed);
    Random random(seed);
    std::vector<double> angle(fresh.pose_ids.size());
    for (double& a : angle) a = 1e-3 * random.normal();
    for (int row = 0; row < fresh.rows(); ++row) fresh.q[row][2] += angle[fresh.pose[row]];
    const ChangeResult result = detect_change(previous.robot, previous.spread, fresh);
    EXPECT_FALSE(result.holds) << seed << ": " << result.p_value;
    EXPECT_LT(result.p_value, 1e-6) << seed;
  }
}

// Where each visit errs by another angle the replicates show it, and the test takes it for noise.
TEST(Change, VisitsThatScatterMoreThanAtTheCalibrationAreNamed) {
  const Robot truth = shipped("kr360-table4");
  const CalibrationResult previous = calibrate(shipped("kr360-spindle"), measured(truth, 60, 2, 1));
  int named = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Campaign fresh = measured(truth, 20, 3, kNewPoses + seed);
    named +=
        noisier_in_words(detect_change(previous.robot, previous.spread, fresh)).empty() ? 0 : 1;
    Random random(seed);
    for (int row = 0; row < fresh.rows(); ++row) fresh.q[row][2] += 5e-4 * random.normal();
    EXPECT_THAT(noisier_in_words(detect_change(previous.robot, previous.spread, fresh)),
                testing::HasSubstr("times as much as the readings did at the calibration"))
        << seed;
  }
  EXPECT_EQ(named, 0);
}

// Single readings of a noisier instrument, whose rows say so.
TEST(Change, HoldsWhereTheRowsStateMoreNoise) {
  const Robot truth = shipped("kr360-table4");
  const CalibrationResult previous = calibrate(shipped("kr360-spindle"), measured(truth, 60, 3, 1));
  int holds = 0, holds_if_moved = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SimulationOptions options;
    options.poses = 25;
    options.seed = kNewPoses + seed;
    options.noise_position = 0.4e-3;
    options.orientation = false;
    Campaign fresh = simulate(shipped("kr360-spindle"), truth, options);
    EXPECT_FALSE(detect_change(previous.robot, previous.spread, fresh).holds) << seed;
    fresh.sigma_position.assign(fresh.q.size(), 0.4e-3);
    holds += detect_change(previous.robot, previous.spread, fresh).holds;
    for (int row = 0; row < fresh.rows(); ++row) fresh.q[row][1] += 3e-3;
    holds_if_moved += detect_change(previous.robot, previous.spread, fresh).holds;
  }
  EXPECT_GE(holds, 19);
  EXPECT_EQ(holds_if_moved, 0);
}

TEST(Change, NeedsAPreviousCalibration) {
  const Robot nominal = shipped("kr360-spindle");
  const Campaign fresh = measured(nominal, 10, 1, 1);
  EXPECT_THROW(detect_change(nominal, {1e-4, 1e-4}, fresh), std::invalid_argument);
  Robot calibrated = nominal;
  calibrated.std["A2.theta"] = 1e-5;
  EXPECT_THROW(detect_change(calibrated, {1e-4, 0}, fresh), std::invalid_argument);
}

// Campaigns of the oracle: visits of one arm to calibrate it, then ten in each of some sessions.
struct Later {
  int sessions = 2;
  int calibrated_in = 1;                              // sessions
  ZeroOffsets offset = [](int, int) { return 0.0; };  // the calibrated sessions first
  bool orientation = true;
  bool carried = true;
};

ChangeResult changed(const Later& later, unsigned seed,
                     const std::vector<std::string>& per_session = {}) {
  constexpr int kCalibrationVisits = 90, kLaterVisits = 10;
  std::vector<int> visits(static_cast<size_t>(later.calibrated_in),
                          kCalibrationVisits / later.calibrated_in);
  for (int s = 0; s < later.sessions; ++s) visits.push_back(kLaterVisits);
  armtrue_oracle::CampaignPlan plan;
  plan.orientation = later.orientation;
  plan.seed = seed;
  const Campaign all = carried_campaign(visits, plan, later.offset, later.carried);
  Robot robot = shipped("kr360-spindle");
  robot.identify_per_session = per_session;
  const int first = later.calibrated_in;
  const CalibrationResult previous = calibrate(robot, sessions_of(all, 0, first - 1));
  return detect_change(previous.robot, previous.spread,
                       sessions_of(all, first, first + later.sessions - 1));
}

// How often `what`, in these sessions, is what is named first.
int named(int seeds, const Later& later, const std::string& what,
          const std::vector<std::string>& sessions,
          const std::vector<std::string>& per_session = {}) {
  int first = 0, alone = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const ChangeResult result = changed(later, static_cast<unsigned>(seed), per_session);
    EXPECT_FALSE(result.holds);
    if (result.moved.empty() || result.moved.front().what != what ||
        result.moved.front().sessions != sessions)
      continue;
    ++first;
    alone += result.moved.size() == 1;
  }
  std::printf("%s: first in %d, alone in %d of %d\n", what.c_str(), first, alone, seeds);
  return first;
}

// An instrument that stands elsewhere is no change of the robot.
TEST(ChangeOverSessions, HoldsWhenOnlyTheInstrumentWasCarried) {
  for (const Later& later : {Later{}, Later{.orientation = false}, Later{.sessions = 1}}) {
    int holds = 0;
    for (unsigned seed = 1; seed <= 40; ++seed) holds += changed(later, seed).holds;
    std::printf("holds %d of 40\n", holds);
    EXPECT_GE(holds, 38);  // at 1 per cent, three false alarms come once in 130 times
  }
}

TEST(ChangeOverSessions, NamesWhatMovedBetweenThem) {
  Later later;
  later.offset = [](int j, int session) { return j == 1 && session >= 2 ? 0.5e-3 : 0; };
  EXPECT_GE(named(10, later, "A2.theta", {"day 2"}), 9);
}

TEST(ChangeOverSessions, NamesWhatMovedBefore) {
  Later later;
  later.offset = [](int j, int session) { return j == 1 && session >= 1 ? 0.5e-3 : 0; };
  EXPECT_GE(named(10, later, "A2.theta", {}), 9);
}

TEST(ChangeOverSessions, NamesTheFirstOfThreeThatIsMoved) {
  Later later{.sessions = 3};
  later.offset = [](int j, int session) { return j == 2 && session >= 2 ? -0.6e-3 : 0; };
  EXPECT_GE(named(5, later, "A3.theta", {"day 2", "day 3"}), 5);
}

// The offset of a session is compared with that session's, not with the robot's.
TEST(ChangeOverSessions, KnowsTheirOwnZeroOffsets) {
  Later later{.calibrated_in = 2};
  later.offset = [](int j, int session) { return j == 2 && session % 2 == 1 ? 2e-3 : 0; };
  int holds = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) holds += changed(later, seed, {"A3.theta"}).holds;
  EXPECT_GE(holds, 18);
  later.offset = [](int j, int session) {
    return j == 2 && session % 2 == 1 ? 2e-3 + (session == 3 ? 0.6e-3 : 0) : 0;
  };
  EXPECT_GE(named(10, later, "A3.theta", {"day 2"}, {"A3.theta"}), 9);
}

TEST(ChangeOverSessions, SaysWhichInstrumentStandsElsewhere) {
  Later later{.calibrated_in = 2};
  const ChangeResult carried = changed(later, 1);
  EXPECT_TRUE(carried.holds);
  ASSERT_EQ(carried.stations.size(), 2u);
  EXPECT_EQ(carried.stations[1].sessions, std::vector<std::string>{"day 2"});
  later.carried = false;
  int seen = 0;
  for (unsigned seed = 1; seed <= 20; ++seed)
    seen += static_cast<int>(changed(later, seed).stations.size());
  EXPECT_LE(seen, 2);
}

TEST(ChangeOverSessions, OneThatOnlyPlacesItsBaseIsAnError) {
  const Robot truth = shipped("kr360-table4");
  const CalibrationResult previous = calibrate(shipped("kr360-spindle"), measured(truth, 60, 3, 1));
  Campaign fresh = measured(truth, 10, 1, kNewPoses);
  fresh.session.assign(10, 0);
  fresh.session.back() = 1;
  fresh.session_names = {"long", "short"};
  EXPECT_THROW(detect_change(previous.robot, previous.spread, fresh), std::invalid_argument);
}

}  // namespace
}  // namespace armtrue::change_test
