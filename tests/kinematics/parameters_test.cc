// Values and changes of parameters: the reverse of move_parameter().

#include "armtrue/kinematics/parameters.h"

#include <gmock/gmock.h>

#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

KinematicChain with_all_owners() {
  KinematicChain chain = read_robot(ARMTRUE_CONFIG "/robots/kr360-rail.yaml").robot.chain;
  chain.base.rotation = rotation_from_abc(0.3, -0.2, 0.1);
  chain.tool.rotation = rotation_from_abc(-1, 0.4, 2);
  chain.targets = {{"1", {0.01, 0, 0.02}}, {"2", {0, 0.03, 0}}};
  chain.anchors = {{"a", {2, 1, 0.1}, 0.5}};
  Contact point, plane;
  point.name = "socket";
  plane.name = "wall";
  plane.kind = ContactKind::plane;
  plane.place = {rotation_from_abc(0.5, 0.6, -0.7), {1, 2, 3}};
  chain.contacts = {point, plane};
  return chain;
}

TEST(Parameters, ChangeIsWhatWasMoved) {
  const KinematicChain chain = with_all_owners();
  const ParameterLayout layout = layout_of(chain);
  for (int k = 0; k < parameter_count(chain); ++k) {
    if (!layout.has_constant(k)) {
      EXPECT_FALSE(parameter_change(chain, chain, k));
      EXPECT_FALSE(parameter_value(chain, k));
      continue;
    }
    KinematicChain moved = chain;
    move_parameter(moved, k, 0.0123);
    for (int other = 0; other < parameter_count(chain); ++other)
      if (const auto change = parameter_change(chain, moved, other))
        EXPECT_NEAR(*change, other == k ? 0.0123 : 0.0, 1e-14)
            << parameter_name(chain, k) << ", " << parameter_name(chain, other);
    const auto before = parameter_value(chain, k), after = parameter_value(moved, k);
    ASSERT_EQ(before.has_value(), after.has_value());
    if (before) EXPECT_NEAR(*after - *before, 0.0123, 1e-14) << parameter_name(chain, k);
  }
}

TEST(Parameters, ValuesAreThoseOfTheFile) {
  KinematicChain chain = with_all_owners();
  const auto value = [&](const char* name) {
    return parameter_value(chain, *find_parameter(chain, name));
  };
  EXPECT_DOUBLE_EQ(*value("A2.d"), 0.5);
  EXPECT_DOUBLE_EQ(*value("target 2.y"), 0.03);
  EXPECT_DOUBLE_EQ(*value("anchor a.zero"), 0.5);
  for (const char* name : {"base.rx", "tool.rz", "contact wall.x", "contact wall.rx"})
    EXPECT_FALSE(value(name)) << name;
  EXPECT_DOUBLE_EQ(*value("contact socket.x"), 0);
  chain.contacts[0].is_placed = false;
  EXPECT_FALSE(value("contact socket.x"));
  EXPECT_FALSE(
      parameter_change(with_all_owners(), chain, *find_parameter(chain, "contact socket.x")));
}

}  // namespace
}  // namespace armtrue
