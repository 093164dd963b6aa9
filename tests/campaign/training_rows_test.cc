#include "armtrue/campaign/training_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/random.h"

namespace armtrue::training_rows_test {
namespace {

constexpr int kPoses = 40, kRowsOfPose = 6;

// Poses of so many numbers each; `read` sets the number of a row.
template <typename Read>
Campaign poses(const Read& read) {
  Campaign campaign;
  for (int row = 0; row < kPoses * kRowsOfPose; ++row) {
    const int pose = row / kRowsOfPose;
    campaign.pose.push_back(pose);
    campaign.q.push_back(JointVector::Constant(6, 0.01 * pose));
    if (row % kRowsOfPose == 0) campaign.pose_ids.push_back(std::to_string(pose + 1));
    read(campaign, row);
  }
  return campaign;
}

// Three corners of each image, their pixels with three decimals.
Campaign images(double metre_per_pixel, double noise) {
  Random random(7);
  Campaign campaign = poses([&](Campaign& c, int row) {
    const double pixel = 100 + 3.7 * row + noise * random.normal();
    c.touch.push_back({row % kRowsOfPose / 2, row % 2, true});
    c.distance.push_back(metre_per_pixel * std::round(1e3 * pixel) / 1e3);
  });
  campaign.metre_per_pixel = metre_per_pixel;
  campaign.contact_names = {"eye/plate/0", "eye/plate/1", "eye/plate/2"};
  return campaign;
}

// Beside other images a pixel is another length at the board.
TEST(TrainingRows, PixelsAreKnownWhateverTheyAreAtTheBoard) {
  const TrainingRows training = training_rows(images(2.37e-4, 0));
  for (const double metre_per_pixel : {2.37e-4, 2.41e-4, 1e-3 / 3})
    EXPECT_EQ(seen_poses(training, images(metre_per_pixel, 0)).seen, kPoses) << metre_per_pixel;
  EXPECT_EQ(seen_poses(training, images(2.37e-4, 0.2)).seen, 0);
}

Campaign distances(double noise) {
  Random random(5);
  return poses([&](Campaign& c, int row) {
    c.distance.push_back(2 + 1e-3 * row + noise * random.normal());
  });
}

// Of the distances of a pose that is measured again some are the same by chance.
TEST(TrainingRows, ANumberThatIsTheSameByChanceIsNotOneOfTheCalibration) {
  const TrainingRows training = training_rows(distances(0));
  EXPECT_EQ(seen_poses(training, distances(0)).seen, kPoses);
  EXPECT_EQ(seen_poses(training, distances(3e-5)).seen, 0);
}

// All points of a profile are touches at one posture.
TEST(TrainingRows, ProfilesDifferByTheirPoints) {
  const auto profiles = [](double shift) {
    return poses([&](Campaign& c, int row) {
      c.distance.push_back(0);
      c.touch.push_back({0, -1, false});
      c.profile.push_back({1e-3 * (row % kRowsOfPose), 0.2 + shift, row % kRowsOfPose});
    });
  };
  const TrainingRows training = training_rows(profiles(0));
  EXPECT_EQ(seen_poses(training, profiles(0)).seen, kPoses);
  EXPECT_EQ(seen_poses(training, profiles(4e-5)).seen, 0);
}

}  // namespace
}  // namespace armtrue::training_rows_test
