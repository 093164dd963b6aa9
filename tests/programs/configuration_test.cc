// What KUKA's status and FANUC's CONFIG say, in the words of their manuals.

#include "armtrue/programs/configuration.h"

#include <gtest/gtest.h>

#include "programs/fanuc/fanuc_positions.h"
#include "programs/kuka/krl_frame.h"

namespace armtrue::configuration_test {
namespace {

TEST(KrlStatus, IsAWholeNumberBitsOrHexadecimal) {
  for (const auto& [written, status] :
       {std::pair{"18", 18}, {"'B10010'", 18}, {"'H12'", 18}, {"'Hff'", 255}}) {
    const std::string text = std::string("{X 1,Y 2,Z 3,A 0,B 0,C 0,S ") + written + ",T 'B11'}";
    TextCursor cursor(text, 0, text.size());
    const KrlAggregate found = take_krl_aggregate(cursor);
    EXPECT_EQ(found.kind, KrlAggregateKind::frame) << written;
    EXPECT_EQ(found.frame.status, status) << written;
    EXPECT_EQ(found.frame.turn, 3) << written;
  }
}

// Turn 0 is from -180 to 180 deg, 1 the turn above, -1 the turn below.
TEST(FanucConfiguration, TurnsAreRangesOfJointAngles) {
  const Configuration found = fanuc_configuration("F U T, 0, 1, -1");
  EXPECT_EQ(found.sides, (std::array<int, 3>{1, 1, -1}));
  for (const auto& [joint, low] : {std::pair{3, -180.0}, {4, 180.0}, {5, -540.0}}) {
    EXPECT_NEAR(found.low[joint] / kDegree, low, 1e-12) << joint;
    EXPECT_NEAR(found.high[joint] / kDegree, low + 360, 1e-12) << joint;
  }
}

// Nothing says which of the two the controller takes.
TEST(FanucPositions, OneThatIsGivenTwiceIsNotKnown) {
  const std::string one = "P[1]{\n GP1:\n UF : 1, UT : 1,\n X = 1.0 mm\n};\n";
  const auto is_changed = [](const std::string& positions) {
    const std::string text = "/POS\n" + positions + "/END\n";
    return fanuc_positions(text, text, 5, text.size() - 5).at(1).is_changed;
  };
  EXPECT_FALSE(is_changed(one));
  EXPECT_TRUE(is_changed(one + one));
}

}  // namespace
}  // namespace armtrue::configuration_test
