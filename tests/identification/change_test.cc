#include "armtrue/identification/change.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>

#include "armtrue/identification/calibration.h"
#include "armtrue/identification/simulation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"

namespace armtrue {
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

// A robot calibrated from 60 poses x 3, whose truth then moves, and ten new poses of it.
ChangeResult after(unsigned seed, const std::map<std::string, double>& moved, double blunders = 0,
                   int repeats = 1, bool orientation = true) {
  Robot truth = shipped("kr360-table4");
  Campaign calibrated_on = measured(truth, 60, 3, seed);
  for (const auto& [name, change] : moved)
    move_parameter(truth.chain, *find_parameter(truth.chain, name), change);
  Campaign fresh = measured(truth, 10, repeats, kNewPoses + seed, blunders);
  if (!orientation) {
    calibrated_on.orientation.clear();
    fresh.orientation.clear();
  }
  const CalibrationResult previous = calibrate(shipped("kr360-spindle"), calibrated_on);
  return detect_change(previous.robot, previous.scale, fresh);
}

struct Count {
  int holds = 0, first = 0, in_class = 0;
  double covered = 0, after_over_before = 0, class_size = 0;
};

Count repeated(int seeds, const std::string& what, const std::map<std::string, double>& moved,
               double blunders = 0, int repeats = 1, bool orientation = true) {
  Count count;
  for (int seed = 1; seed <= seeds; ++seed) {
    const ChangeResult result = after(seed, moved, blunders, repeats, orientation);
    count.holds += result.holds;
    for (int k = 0; k <= result.indistinguishable; ++k) {
      const Move& move = result.moves[k];
      if (move.what != what) continue;
      count.first += k == 0;
      ++count.in_class;
      double inside = 0;
      for (const ParameterChange& change : move.changes) {
        const auto found = moved.find(parameter_name(shipped("kr360").chain, change.parameter));
        const double truth = found == moved.end() ? 0 : found->second;
        inside += change.ci95()[0] <= truth && truth <= change.ci95()[1];
      }
      count.covered += inside / static_cast<double>(move.changes.size());
    }
    count.class_size += 1 + result.indistinguishable;
    count.after_over_before += result.after / result.before;
  }
  std::printf(
      "%d seeds: holds %d, first %d, in the class %d (size %.1f), intervals cover %.3f, "
      "after/before %.3f\n",
      seeds, count.holds, count.first, count.in_class, count.class_size / seeds,
      count.covered / std::max(1, count.in_class), count.after_over_before / seeds);
  return count;
}

// At 1 per cent, six or more false alarms in 100 would come once in 2000 times.
TEST(Change, HoldsWhenNothingHasChanged) { EXPECT_GE(repeated(100, "", {}).holds, 95); }

TEST(Change, HoldsWhenOneReadingInTenIsABlunder) {
  EXPECT_GE(repeated(100, "", {}, 0.1).holds, 95);
}

TEST(Change, HoldsOnPointsAndOnReplicates) {
  EXPECT_GE(repeated(100, "", {}, 0, 1, false).holds, 95);
  EXPECT_GE(repeated(100, "", {}, 0, 3).holds, 95);
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
  const ChangeResult result = detect_change(previous.robot, previous.scale, fresh);
  EXPECT_EQ(result.blunders, std::vector<int>{4});
  EXPECT_TRUE(result.holds);
}

TEST(Change, NeedsAPreviousCalibration) {
  const Robot nominal = shipped("kr360-spindle");
  const Campaign fresh = measured(nominal, 10, 1, 1);
  EXPECT_THROW(detect_change(nominal, {1e-4, 1e-4}, fresh), std::invalid_argument);
  Robot calibrated = nominal;
  calibrated.std["A2.theta"] = 1e-5;
  EXPECT_THROW(detect_change(calibrated, {1e-4, 0}, fresh), std::invalid_argument);
}

}  // namespace
}  // namespace armtrue
