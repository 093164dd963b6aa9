#include "armtrue/tracing/nested_validation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/tracing/loop.h"
#include "tracing/hidden_campaign.h"

namespace armtrue::nested_validation_test {
namespace {

const std::string kNominal = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";

struct Setting {
  Robot robot = read_robot(kNominal).robot;
  Catalogue catalogue = read_catalogue(ARMTRUE_CONFIG "/effects/catalogue.yaml");
  TraceOptions options;

  Setting() { options.beyond_catalogue = false; }
};

HiddenCampaign hidden(const std::string& family) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 91;
  return {kNominal, family, 0.12, plan};
}

TEST(NestedValidation, FindsAgainWhatIsThereAndTellsTheErrorOfPosesLeftOut) {
  const Setting setting;
  const HiddenCampaign campaign = hidden("ratio");
  const TraceResult found =
      trace(setting.robot, campaign.training, setting.catalogue, setting.options);
  ASSERT_EQ(found.effects.size(), 1u);
  std::vector<TracedEffect> asked = found.effects;
  asked.emplace_back();  // one that is not there
  asked.back().effect = {"none", "A1.r", {DriverKind::time, -1, -1, ""}, {}, {}};
  const NestedValidation nested = nested_validation(setting.robot, campaign.training,
                                                    setting.catalogue, 3, asked, setting.options);
  EXPECT_EQ(nested.folds, 3);
  EXPECT_EQ(nested.found_again, (std::vector<int>{3, 0}));
  EXPECT_NEAR(nested.gain.mean, nested.before.mean - nested.after.mean, 1e-12);
  EXPECT_GT(nested.gain.mean, 3 * nested.gain.error);
  // The oracle's other poses, which took no part in anything.
  const double before =
      summarize(evaluate(found.stages.front().robot, campaign.held_out).position).mean;
  const double after = summarize(evaluate(found.fit.robot, campaign.held_out).position).mean;
  EXPECT_NEAR(nested.before.mean, before, 0.15 * before);
  EXPECT_NEAR(nested.after.mean, after, 0.15 * after);
}

// 24 poses read once leave the geometry much to overfit: its error on poses that it has seen is
// below the noise, on others no model is.
TEST(NestedValidation, JudgesOnPosesThatTookNoPart) {
  const Setting setting;
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 92;
  plan.poses = 24;
  plan.repeats = 1;
  const HiddenCampaign campaign(kNominal, "null", 0, plan);
  const double noise = campaign.written.floor_mean_mm * kMillimetre;
  const CalibrationResult fit = calibrate(setting.robot, campaign.training);
  EXPECT_LT(summarize(evaluate(fit.robot, campaign.training).position).mean, 0.95 * noise);
  const NestedValidation nested = nested_validation(setting.robot, campaign.training,
                                                    setting.catalogue, 6, {}, setting.options);
  EXPECT_GT(nested.before.mean, noise);
  EXPECT_GT(nested.after.mean, noise);
}

TEST(NestedValidation, DoesNotDependOnTheOrderOfRows) {
  const Setting setting;
  const HiddenCampaign campaign = hidden("null");
  std::vector<int> backwards(campaign.training.rows());
  for (int row = 0; row < campaign.training.rows(); ++row)
    backwards[row] = campaign.training.rows() - 1 - row;
  const auto run = [&](const Campaign& readings) {
    return nested_validation(setting.robot, readings, setting.catalogue, 2, {}, setting.options);
  };
  const NestedValidation a = run(campaign.training), b = run(campaign.training.select(backwards));
  EXPECT_NEAR(a.after.mean, b.after.mean, 1e-6 * a.after.mean);
  EXPECT_NEAR(a.after.error, b.after.error, 1e-4 * a.after.error);
}

TEST(NestedValidation, LeavesPosesOfEverySessionToLearnFrom) {
  const Setting setting;
  Campaign campaign = hidden("null").training;
  campaign.session_names = {"day 1", "day 2"};
  // Two poses only on the second day: one in each fold.
  campaign.session.assign(campaign.rows(), 0);
  for (int row = 0; row < campaign.rows(); ++row)
    if (campaign.pose[row] < 2) campaign.session[row] = 1;
  const NestedValidation nested =
      nested_validation(setting.robot, campaign, setting.catalogue, 2, {}, setting.options);
  EXPECT_LT(nested.after.mean, 0.5 * kMillimetre);
}

TEST(NestedValidation, NeedsAtLeastTwoFoldsAndAPoseForEach) {
  const Setting setting;
  const Campaign campaign = hidden("null").training;
  for (int folds : {-1, 0, 1, 61})
    EXPECT_THROW(
        nested_validation(setting.robot, campaign, setting.catalogue, folds, {}, setting.options),
        std::invalid_argument)
        << folds;
}

}  // namespace
}  // namespace armtrue::nested_validation_test
