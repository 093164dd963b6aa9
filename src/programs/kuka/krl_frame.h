#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string_view>

#include "armtrue/kinematics/pose.h"
#include "programs/kuka/krl_pose.h"
#include "programs/text_cursor.h"

namespace armtrue {

inline std::array<double, 6> unknown_krl_axes() {
  std::array<double, 6> axes{};
  axes.fill(std::numeric_limits<double>::quiet_NaN());
  return axes;
}

/// An aggregate {X 1.0,Y 2.0,...} in the .src or the .dat: where it stands and what it says.
struct KrlFrame {
  int text = 0;               ///< index in RobotProgram::texts
  size_t begin = 0, end = 0;  ///< in the text: of `{`, and behind `}`
  size_t entries = 0;         ///< in the text: behind `{` or `{E6POS:`
  struct Number {
    unsigned begin = 0, end = 0;  ///< counted from KrlFrame::begin; end = 0: not given
  };
  std::array<Number, kKrlComponents> numbers;
  KrlValues values = unknown_krl_values();
  /// A1 to A6 of joint angles [deg]; NaN: not given, or no plain number.
  std::array<Number, 6> axis_numbers;
  std::array<double, 6> axes = unknown_krl_axes();
  Number turn_number, status_number;  ///< T and S, if they are plain numbers
  std::optional<int> status, turn;
};

/// Tool and base of an inline form: DECL FDAT FP1={TOOL_NO 1,BASE_NO 3,IPO_FRAME #BASE}.
struct KrlFdat {
  std::optional<int> tool, base;
  bool is_external_tcp = false;
};

enum class KrlAggregateKind { frame, axes, other };

struct KrlAggregate {
  KrlAggregateKind kind = KrlAggregateKind::other;
  KrlFrame frame;
};

/// The pose of a frame; nothing if one of its six numbers is not given.
std::optional<Pose> krl_pose(const KrlFrame& frame);

/// The component of KrlValues with a name in capitals; -1 if there is none.
int krl_component(std::string_view name);
/// The unit of a component in SI; of an external axis 1.
double krl_unit(int component);

/// POS, E6POS, FRAME, AXIS or E6AXIS; `name` in capitals.
bool is_krl_point_type(std::string_view name);

/// Reads {X 1.0, ..} or {E6POS: X 1.0, ..}: the cursor stands on `{` before, behind `}` after. The
/// kind is `other`, and the cursor stands anywhere, if a component is no plain number, is given
/// twice or belongs to no position.
KrlAggregate take_krl_aggregate(TextCursor& cursor);

/// Reads {TOOL_NO 1,BASE_NO 3,IPO_FRAME #BASE,..}: the cursor stands on `{` before, behind `}`
/// after.
KrlFdat take_krl_fdat(TextCursor& cursor);

}  // namespace armtrue
