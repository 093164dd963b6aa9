#include "programs/kuka/krl_frame.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <string>
#include <system_error>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr const char* kComponentNames[kKrlComponents] = {"X",  "Y",  "Z",  "A",  "B",  "C",
                                                         "E1", "E2", "E3", "E4", "E5", "E6"};

KrlFrame::Number place_from(const KrlFrame& frame, size_t begin, const TextCursor& cursor) {
  return {static_cast<unsigned>(begin - frame.begin),
          static_cast<unsigned>(cursor.at() - frame.begin)};
}

bool is_at_end_of_entry(TextCursor& cursor) { return cursor.next() == ',' || cursor.next() == '}'; }

// A whole number, or bits as 'B100011', or 'H23'.
std::optional<int> take_whole(TextCursor& cursor) {
  if (cursor.take('\'')) {
    const std::string digits = cursor.take_name();
    int value = 0;
    const char* const end = digits.data() + digits.size();
    const int base = digits.starts_with('B') ? 2 : digits.starts_with('H') ? 16 : 0;
    if (base == 0) return std::nullopt;
    const auto [rest, error] = std::from_chars(digits.data() + 1, end, value, base);
    if (error != std::errc() || rest != end || !cursor.take('\'')) return std::nullopt;
    return value;
  }
  const auto value = cursor.take_number();
  constexpr double kLargestWord = 0xffff;
  if (!value || !(*value >= 0 && *value <= kLargestWord) || *value != std::floor(*value))
    return std::nullopt;
  return static_cast<int>(*value);
}

void take_bits(TextCursor cursor, bool is_turn, KrlFrame& frame) {
  cursor.next();
  const size_t begin = cursor.at();
  const auto value = take_whole(cursor);
  const KrlFrame::Number place = place_from(frame, begin, cursor);
  if (!value || !is_at_end_of_entry(cursor)) return;
  (is_turn ? frame.turn : frame.status) = value;
  (is_turn ? frame.turn_number : frame.status_number) = place;
}

void take_axis(TextCursor cursor, size_t axis, KrlFrame& frame) {
  cursor.next();
  const size_t begin = cursor.at();
  const auto value = cursor.take_number();
  const KrlFrame::Number place = place_from(frame, begin, cursor);
  if (!value || !is_at_end_of_entry(cursor)) return;
  frame.axes[axis] = *value;
  frame.axis_numbers[axis] = place;
}

}  // namespace

int krl_component(std::string_view name) {
  const auto* const found = std::find(std::begin(kComponentNames), std::end(kComponentNames), name);
  return found == std::end(kComponentNames) ? -1
                                            : static_cast<int>(found - std::begin(kComponentNames));
}

std::optional<Pose> krl_pose(const KrlFrame& frame) {
  const KrlValues& v = frame.values;
  if (!v.head<6>().array().isFinite().all()) return std::nullopt;
  return Pose{rotation_from_abc(v[3], v[4], v[5]), v.head<3>()};
}

double krl_unit(int component) {
  return component < 3 ? kMillimetre : component < 6 ? kDegree : 1.0;
}

bool is_krl_point_type(std::string_view name) {
  return name == "POS" || name == "E6POS" || name == "FRAME" || name == "AXIS" || name == "E6AXIS";
}

KrlAggregate take_krl_aggregate(TextCursor& cursor) {
  KrlAggregate result;
  KrlFrame& frame = result.frame;
  cursor.next();
  frame.begin = cursor.at();
  cursor.step();
  frame.entries = cursor.at();
  bool positions = false, axes = false;
  while (!cursor.done()) {
    std::string name = cursor.take_name();
    if (frame.entries == frame.begin + 1 && cursor.take(':')) {
      if (!is_krl_point_type(name)) return result;
      frame.entries = cursor.at();
      name = cursor.take_name();
    }
    const int index = krl_component(name);
    if (index >= 0) {
      cursor.next();
      const size_t begin = cursor.at();
      const auto value = cursor.take_number();
      if (!value || std::isfinite(frame.values[index])) return result;
      frame.values[index] = *value * krl_unit(index);
      frame.numbers[index] = {static_cast<unsigned>(begin - frame.begin),
                              static_cast<unsigned>(cursor.at() - frame.begin)};
      positions |= index < 6;
    } else if (name == "S" || name == "T") {
      take_bits(cursor, name == "T", frame);
      cursor.skip_to(",}");
    } else if (name.size() == 2 && name[0] == 'A' && name[1] >= '1' && name[1] <= '6') {
      axes = true;
      take_axis(cursor, name[1] - '1', frame);
      cursor.skip_to(",}");
    } else {
      return result;
    }
    if (cursor.take('}')) {
      frame.end = cursor.at();
      if (positions != axes) result.kind = axes ? KrlAggregateKind::axes : KrlAggregateKind::frame;
      return result;
    }
    if (!cursor.take(',')) return result;
  }
  return result;
}

KrlFdat take_krl_fdat(TextCursor& cursor) {
  KrlFdat fdat;
  const auto number = [&]() -> std::optional<int> {
    constexpr double kMost = 1000;
    const auto value = cursor.take_number();
    if (!value || !(std::abs(*value) < kMost)) return std::nullopt;
    return static_cast<int>(*value);
  };
  cursor.take('{');
  while (!cursor.done() && cursor.next() != '}') {
    const std::string entry = cursor.take_name();
    if (entry == "TOOL_NO") fdat.tool = number();
    if (entry == "BASE_NO") fdat.base = number();
    if (entry == "IPO_FRAME" && cursor.take('#'))
      fdat.is_external_tcp = cursor.take_name() == "TCP";
    cursor.skip_to(",}");
    if (!cursor.take(',')) break;
  }
  cursor.take('}');
  return fdat;
}

}  // namespace armtrue
