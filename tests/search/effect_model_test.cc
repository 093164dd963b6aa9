#include "search/effect_model.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "armtrue/io/campaign_io.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/robot_io.h"

namespace armtrue {
namespace {

TEST(EffectModel, FewDrawsTellAClearScoreAndAllDrawsTheOthers) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  const Campaign campaign = read_campaign(ARMTRUE_CONFIG "/campaigns/tutorial.csv").campaign;
  const Catalogue catalogue = read_catalogue(ARMTRUE_CONFIG "/effects/catalogue.yaml");
  TraceOptions options;
  options.significance_without_lack_of_fit = options.significance;  // no more draws than `flips`
  EffectModel model(robot, campaign, catalogue, options);
  const std::vector<double> draws =
      model.view().projected.best_of_flipped(options.flips, options.seed);
  const auto [least, most] = std::ranges::minmax(draws);
  const double of_one = 1.0 / (1 + options.flips);

  EXPECT_DOUBLE_EQ(model.chance_of(most + 10 * (most - least)), of_one);
  EXPECT_DOUBLE_EQ(model.chance_of(most), 2 * of_one);
  EXPECT_EQ(model.null_run().flips, options.flips);
}

}  // namespace
}  // namespace armtrue
