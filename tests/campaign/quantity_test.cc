#include <gtest/gtest.h>

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

}  // namespace
}  // namespace armtrue
