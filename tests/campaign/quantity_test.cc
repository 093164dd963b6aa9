#include <gtest/gtest.h>

#include <vector>

#include "armtrue/campaign/campaign.h"

namespace armtrue {
namespace {

// A row that gets a quantity has it: the coordinates x, y, z where some rows read those, then the
// distances from the anchors.
TEST(Quantity, IsTheOneThatWasSet) {
  for (const bool has_coordinates : {false, true}) {
    Campaign campaign;
    campaign.distance.assign(1, 0);
    campaign.anchor_names = {"left", "right"};
    campaign.anchor.assign(1, 0);
    if (has_coordinates) campaign.coordinate.resize(1);
    ASSERT_EQ(campaign.quantities(), has_coordinates ? 5 : 2);
    for (int quantity = 0; quantity < campaign.quantities(); ++quantity) {
      campaign.set_quantity(0, quantity);
      EXPECT_EQ(campaign.quantity(0), quantity);
      EXPECT_EQ(campaign.kind(0),
                has_coordinates && quantity < 3 ? ReadingKind::coordinate : ReadingKind::distance);
      EXPECT_LT(campaign.anchor[0], 2);
    }
  }
}

// Of two targets on one line of the file, of a point whose y is missing, and of distances.
TEST(Readings, RisingCoordinatesOfALineAreOne) {
  Campaign campaign;
  for (const int axis : {0, 1, 2, 0, 1, 2}) campaign.coordinate.push_back(Coordinate{axis, 0});
  for (const int axis : {0, 2}) campaign.coordinate.push_back(Coordinate{axis, 0});
  campaign.coordinate.resize(10);
  campaign.line = {1, 1, 1, 1, 1, 1, 2, 2, 3, 3};
  campaign.pose = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  campaign.distance.assign(10, 1.5);
  campaign.q.assign(10, JointVector::Zero(6));
  EXPECT_EQ(campaign.first_rows_of_readings(), (std::vector<int>{0, 3, 6, 8, 9}));
}

}  // namespace
}  // namespace armtrue
