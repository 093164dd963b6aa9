// Poses that are read many times: the search takes the readings of one context as their mean, and
// finds what it finds in the means themselves.

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/selection.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/search/trace.h"
#include "search/linearization.h"

namespace armtrue::many_readings_test {
namespace {

constexpr int kPoses = 40, kRepeats = 25;
constexpr double kNoise = 0.095e-3, kNoiseOfTurn = 0.15e-3;

Robot nominal() { return read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot; }

Campaign readings(int repeats = kRepeats) {
  SimulationOptions options;
  options.poses = kPoses;
  options.repeats = repeats;
  options.noise_position = kNoise;
  options.noise_orientation = kNoiseOfTurn;
  options.seed = 4;
  return simulate(nominal(), read_robot(ARMTRUE_CONFIG "/robots/kr360-undeclared.yaml").robot,
                  options);
}

// As if the arm had come to each pose once, and all its readings had been taken there.
Campaign standing_still(Campaign campaign) {
  campaign.time_s.clear();
  campaign.stroke.clear();
  campaign.arrival.assign(campaign.q.size(), Direction{});
  return campaign;
}

Campaign means_of(const Campaign& campaign) {
  std::map<int, std::vector<int>> rows_of_pose;
  for (int row = 0; row < campaign.rows(); ++row) rows_of_pose[campaign.pose[row]].push_back(row);
  std::vector<int> first;
  for (const auto& [pose, rows] : rows_of_pose) first.push_back(rows.front());
  Campaign means = campaign.select(first);
  int mean = 0;
  for (const auto& [pose, rows] : rows_of_pose) {
    means.position[mean].setZero();
    Eigen::Vector4d turn = Eigen::Vector4d::Zero();
    for (int row : rows) {
      means.position[mean] += campaign.position[row] / static_cast<double>(rows.size());
      const Eigen::Vector4d own = campaign.orientation[row].coeffs();
      turn += own.dot(campaign.orientation[rows.front()].coeffs()) > 0 ? own : -own;
    }
    means.orientation[mean].coeffs() = turn.normalized();
    ++mean;
  }
  means.sigma_position.assign(first.size(), kNoise / std::sqrt(kRepeats));
  means.sigma_orientation.assign(first.size(), kNoiseOfTurn / std::sqrt(kRepeats));
  return means;
}

TraceResult traced(const Campaign& campaign, const TraceOptions& options = {}) {
  return trace(nominal(), campaign, read_catalogue(ARMTRUE_CONFIG "/effects/catalogue.yaml"),
               options);
}

TEST(ManyReadings, AreWorthTheirMeans) {
  const Campaign all = standing_still(readings()), means = means_of(all);
  const TraceResult of_all = traced(all), of_means = traced(means);
  ASSERT_FALSE(of_means.effects.empty());
  ASSERT_EQ(of_all.effects.size(), of_means.effects.size());
  for (size_t k = 0; k < of_all.effects.size(); ++k) {
    const Effect &one = of_all.effects[k].effect, &other = of_means.effects[k].effect;
    EXPECT_TRUE(same_form(one, other)) << one.parameter << ", " << other.parameter;
    for (size_t c = 0; c < one.coefficients.size(); ++c)
      EXPECT_NEAR(one.coefficients[c].value, other.coefficients[c].value,
                  0.1 * other.coefficients[c].std);
  }
  EXPECT_EQ(Linearization(of_all.fit, all).rows(), kPoses);
}

// A reading that is off alone loses its weight, and neither its pose nor the effects suffer.
TEST(ManyReadings, ABlunderAmongThemIsOneReading) {
  Campaign all = standing_still(readings());
  const TraceResult sound = traced(all);
  constexpr int kOff = 17;
  all.position[kOff].x() += 5e-3;
  const TraceResult off = traced(all);
  EXPECT_EQ(assess(off.fit, all).blunders, std::vector<int>{kOff});
  ASSERT_FALSE(sound.effects.empty());
  ASSERT_EQ(off.effects.size(), sound.effects.size());
  for (size_t k = 0; k < off.effects.size(); ++k) {
    const Effect &one = off.effects[k].effect, &other = sound.effects[k].effect;
    EXPECT_TRUE(same_form(one, other)) << one.parameter << ", " << other.parameter;
    EXPECT_NEAR(one.coefficients[0].value, other.coefficients[0].value,
                0.2 * other.coefficients[0].std);
  }
}

// What a time moves differs from visit to visit: then each is a row of its own, and so it is for
// directions of arrival, but for those that are alike.
TEST(ManyReadings, AreApartWhereTheModelTellsThemApart) {
  const Campaign all = readings();
  Robot robot = nominal();
  const auto rows_with = [&](DriverKind kind, ShapeKind shape, int joint) {
    robot.effects = {{"by hand", "A1.theta", {kind, joint, -1, ""}, Shape{shape}, {}}};
    return Linearization(calibrate(robot, all), all).rows();
  };
  EXPECT_EQ(rows_with(DriverKind::joint_angle, ShapeKind::linear, 0), kPoses);
  EXPECT_EQ(rows_with(DriverKind::time, ShapeKind::linear, -1), kPoses * kRepeats);
  const int by_direction = rows_with(DriverKind::arrival, ShapeKind::sign, 0);
  EXPECT_GT(by_direction, kPoses);
  EXPECT_LE(by_direction, 3 * kPoses);
}

// A search of a part has readings of every pose, as many of each where there are as many.
TEST(ManyReadings, ArePartlyChosenFromTheVisitsOfEveryPose) {
  const Campaign all = readings();
  std::vector<int> rows(all.q.size());
  std::iota(rows.begin(), rows.end(), 0);
  for (const int each : {1, 5, kRepeats}) {
    const std::vector<int> some = rows_of_some_visits(all, rows, kPoses * each);
    EXPECT_TRUE(std::ranges::is_sorted(some));
    std::map<int, int> readings_of_pose;
    for (int row : some) ++readings_of_pose[all.pose[row]];
    ASSERT_EQ(readings_of_pose.size(), kPoses);
    for (const auto& [pose, count] : readings_of_pose) EXPECT_EQ(count, each) << pose;
  }
  EXPECT_EQ(rows_of_some_visits(all, rows, 3).size(), kPoses);  // fewer would leave poses out
  // Of those that are given alone.
  const std::vector<int> last = {all.rows() - 2, all.rows() - 1};
  EXPECT_EQ(rows_of_some_visits(all, last, 2), last);
}

// More visits than a search looks at: it finds the effect that was hidden, and the fit has all.
TEST(ManyReadings, AreSearchedInPartAndFittedWhole) {
  const Campaign all = readings(200);
  TraceOptions options;
  bool in_part = false;
  options.progress = [&](const std::string& what) {
    in_part = in_part || what == "fitting what was found to all poses";
  };
  const TraceResult found = traced(all, options);
  EXPECT_TRUE(in_part);
  const Robot truth = read_robot(ARMTRUE_CONFIG "/robots/kr360-undeclared.yaml").robot;
  ASSERT_FALSE(found.effects.empty());
  EXPECT_TRUE(same_form(found.effects.front().effect, truth.effects.front()));
  EXPECT_EQ(std::ssize(found.fit.weights), all.rows());
  EXPECT_EQ(std::ssize(found.stages.front().weights), all.rows());
  CalibrationOptions tight;
  tight.tolerance = 1e-9;
  const CalibrationResult again = calibrate(found.fit.robot, all, found.fit.set, tight);
  const Coefficient& of_found = found.effects.front().effect.coefficients.front();
  EXPECT_NEAR(of_found.value,
              again.robot.effects[found.fit.robot.effects.size() - found.effects.size()]
                  .coefficients.front()
                  .value,
              0.05 * of_found.std);
}

}  // namespace
}  // namespace armtrue::many_readings_test
