// What a campaign shows without each effect that was found.

#include "armtrue/search/training.h"

#include <gtest/gtest.h>

#include "armtrue/campaign/simulation.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/robot_io.h"

namespace armtrue::training_test {
namespace {

Effect with(const std::string& name, const std::string& parameter, const std::string& driver,
            double value) {
  Effect effect{name, parameter, *parse_driver(driver), *parse_shape("linear"), {}};
  effect.coefficients.push_back({"c", value, 0, {0, 0}});
  return effect;
}

// The geometry takes back most of what an effect of gravity moves, so the model without it is
// another geometry: that of a fit from the nominal robot.
TEST(Training, WithoutAnEffectAllElseIsAdjusted) {
  const Robot nominal = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  Robot truth = nominal;
  truth.effects = {with("strong", "A2.theta", "gravity-torque 2", 4e-7),
                   with("weak", "A3.theta", "gravity-torque 3", 1e-8),
                   with("weak", "A6.theta", "joint-angle 5", 3e-5)};
  SimulationOptions simulated;
  simulated.poses = 300;
  simulated.noise_position = 0.05e-3;
  simulated.noise_orientation = 0.05e-3;
  const Campaign campaign = simulate(nominal, truth, simulated);
  const TraceOptions options;
  const Training training =
      search_training(nominal, campaign, Then::predict,
                      read_catalogue(ARMTRUE_CONFIG "/effects/catalogue.yaml"), options);
  const CalibrationResult& fit = training.trace.fit;
  const double complete = errors_of(fit.robot, campaign).position.mean;
  const auto first = fit.robot.effects.size() - training.without_effect.size();
  int weak = 0;
  ASSERT_GE(training.without_effect.size(), 2U);
  for (size_t k = 0; k < training.without_effect.size(); ++k) {
    Robot reduced = fit.robot;
    reduced.effects.erase(reduced.effects.begin() + static_cast<std::ptrdiff_t>(first + k));
    const double anew =
        errors_of(calibrate(reduced, campaign, fit.set).robot, campaign).position.mean;
    const double without = errors_of(training.without_effect[k], campaign).position.mean;
    EXPECT_NEAR(without, anew, 0.003 * anew) << fit.robot.effects[first + k].parameter;
    if (anew < 1.05 * complete) ++weak;
  }
  EXPECT_GT(weak, 0);
}

}  // namespace
}  // namespace armtrue::training_test
