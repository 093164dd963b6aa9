#include "search/evidence.h"

#include <gtest/gtest.h>

#include <cmath>

#include "armtrue/effects/driver.h"

namespace armtrue::evidence_test {
namespace {

// a sin x + b cos x = A sin(x + phase)
TEST(Cycle, HasTheAmplitudeAndPhaseOfItsSineAndCosine) {
  CalibrationResult fit;
  fit.set.kept = {6, 7};
  Effect& cycle = fit.robot.effects.emplace_back();
  cycle.shape = harmonic_shape(1);
  cycle.coefficients = {{"sin", 3e-4}, {"cos", 4e-4}};
  fit.covariance = Eigen::MatrixXd::Zero(4, 4);
  fit.covariance.diagonal() << 1, 1, 4e-10, 1e-10;
  const auto found = fixed_cycle(fit, Eigen::MatrixXd::Zero(50, 2), 0, 30);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->amplitude, 5e-4, 1e-12);
  for (const double x : {0.0, 0.7, 2.9, -1.3})
    EXPECT_NEAR(found->amplitude * std::sin(x + found->phase),
                3e-4 * std::sin(x) + 4e-4 * std::cos(x), 1e-12);
  // By the derivatives 0.6 and 0.8 of the amplitude.
  EXPECT_NEAR(found->amplitude_std, std::sqrt(0.36 * 4e-10 + 0.64 * 1e-10), 1e-12);
}

// The instrument was knocked, and what is left of that looks like a drift of the arm. The other way
// round the motion of the instrument is no rest of anything.
TEST(Event, ItsRestMayBeInTheArmAndNotInTheStation) {
  const auto follows_time = [](const char* parameter) {
    Effect effect;
    effect.parameter = parameter;
    effect.driver = *parse_driver("time");
    return effect;
  };
  Robot robot;
  robot.effects = {follows_time("base.x"), follows_time("A2.theta")};
  EXPECT_TRUE(may_be_rest_of_event(robot.effects[1], robot));
  EXPECT_FALSE(may_be_rest_of_event(robot.effects[0], robot));
  robot.effects.erase(robot.effects.begin());
  EXPECT_FALSE(may_be_rest_of_event(robot.effects[0], robot));
}

}  // namespace
}  // namespace armtrue::evidence_test
