#pragma once

#include <array>
#include <string>
#include <string_view>

#include "programs/krl_cursor.h"
#include "programs/krl_pose.h"

namespace armtrue {

/// An aggregate {X 1.0,Y 2.0,...} in the .src or the .dat: where it stands and what it says.
struct KrlFrame {
  bool in_dat = false;
  size_t begin = 0, end = 0;  ///< in the text: of `{`, and behind `}`
  size_t entries = 0;         ///< in the text: behind `{` or `{E6POS:`
  struct Number {
    unsigned begin = 0, end = 0;  ///< counted from KrlFrame::begin; end = 0: not given
  };
  std::array<Number, kKrlComponents> numbers;
  KrlValues values = unknown_krl_values();
};

enum class KrlAggregateKind { frame, axes, other };

struct KrlAggregate {
  KrlAggregateKind kind = KrlAggregateKind::other;
  KrlFrame frame;
};

/// POS, E6POS, FRAME, AXIS or E6AXIS; `name` in capitals.
bool is_krl_point_type(std::string_view name);

/// Reads {X 1.0, ..} or {E6POS: X 1.0, ..}: the cursor stands on `{` before, behind `}` after. The
/// kind is `other`, and the cursor stands anywhere, if a component is no plain number, is given
/// twice or belongs to no position.
KrlAggregate take_krl_aggregate(KrlCursor& cursor);

/// The text of the frame with other `values` (NaN: as it is). `text`: the whole text that the frame
/// stands in. Numbers are rounded as correct_krl() says; a number that is the same after rounding
/// stays as it was written. A component that is not given is added unless `before`, the pose that
/// the controller takes it from, has the value.
std::string krl_frame_text(std::string_view text, const KrlFrame& frame, const KrlValues& values,
                           const KrlValues& before);

}  // namespace armtrue
