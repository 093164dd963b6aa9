#include "programs/krl_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <string>
#include <vector>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr int kDecimals = 4;     // that a changed number has at least: 0.0001 mm
constexpr int kMaxDecimals = 9;  // a double of some metres has no more
constexpr const char* kComponentNames[kKrlComponents] = {"X",  "Y",  "Z",  "A",  "B",  "C",
                                                         "E1", "E2", "E3", "E4", "E5", "E6"};

double unit_of(int component) {
  return component < 3 ? kMillimetre : component < 6 ? kDegree : 1.0;
}

// Decimal places of a number as it is written: digits behind the point less the exponent.
int written_decimals(std::string_view number) {
  const size_t exponent = std::min(number.find_first_of("eE"), number.size());
  const size_t point = number.find('.');
  int decimals =
      point < exponent ? static_cast<int>(std::min<size_t>(exponent - point - 1, 20)) : 0;
  if (exponent < number.size()) {
    int power = 0;
    size_t from = exponent + 1;
    if (from < number.size() && number[from] == '+') ++from;
    std::from_chars(number.data() + from, number.data() + number.size(), power);
    decimals = power > decimals ? 0 : std::min(decimals - power, kMaxDecimals);
  }
  return std::min(decimals, kMaxDecimals);
}

// With kDecimals decimals, or more if `at_least` is more, but without zeros behind `at_least`.
std::string rounded(double value, int at_least) {
  std::string text = fmt::format("{:.{}f}", value, std::max(at_least, kDecimals));
  const size_t point = text.find('.');
  while (text.size() - point - 1 > static_cast<size_t>(at_least) && text.back() == '0')
    text.pop_back();
  if (text.back() == '.') text.pop_back();
  if (text.find_first_not_of("-0.") == std::string::npos && text[0] == '-') text.erase(0, 1);
  return text;
}

}  // namespace

bool is_krl_point_type(std::string_view name) {
  return name == "POS" || name == "E6POS" || name == "FRAME" || name == "AXIS" || name == "E6AXIS";
}

KrlAggregate take_krl_aggregate(KrlCursor& cursor) {
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
    const auto* const component =
        std::find(std::begin(kComponentNames), std::end(kComponentNames), name);
    const auto index = component - std::begin(kComponentNames);
    if (index < kKrlComponents) {
      cursor.next();
      const size_t begin = cursor.at();
      const auto value = cursor.take_number();
      if (!value || std::isfinite(frame.values[index])) return result;
      frame.values[index] = *value * unit_of(static_cast<int>(index));
      frame.numbers[static_cast<size_t>(index)] = {
          static_cast<unsigned>(begin - frame.begin),
          static_cast<unsigned>(cursor.at() - frame.begin)};
      positions |= index < 6;
    } else if (name == "S" || name == "T") {
      cursor.skip_to(",}");
    } else if (name.size() == 2 && name[0] == 'A' && name[1] >= '1' && name[1] <= '6') {
      axes = true;
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

std::string krl_frame_text(std::string_view text, const KrlFrame& frame, const KrlValues& values,
                           const KrlValues& before) {
  struct Change {
    size_t begin, end;
    std::string number;
  };
  std::vector<Change> changes;
  size_t after_xyz = frame.entries;
  std::string added;
  for (int i = 0; i < kKrlComponents; ++i) {
    const KrlFrame::Number& number = frame.numbers[static_cast<size_t>(i)];
    const bool present = number.end > 0;
    const size_t begin = frame.begin + number.begin, end = frame.begin + number.end;
    if (present && i < 3) after_xyz = std::max(after_xyz, end);
    if (!std::isfinite(values[i])) continue;
    const double value = values[i] / unit_of(i);
    const double now = (present ? frame.values[i] : before[i]) / unit_of(i);
    const int decimals = present ? written_decimals(text.substr(begin, end - begin)) : 0;
    const double step = std::pow(10.0, -std::max(decimals, kDecimals));
    if (std::abs(value - now) <= 0.5 * step) continue;
    if (present)
      changes.push_back({begin, end, rounded(value, decimals)});
    else
      added += fmt::format(",{} {}", kComponentNames[i], rounded(value, 0));
  }
  if (!added.empty()) {
    if (after_xyz == frame.entries) added = added.substr(1) + ",";
    changes.push_back({after_xyz, after_xyz, added});
  }
  std::stable_sort(changes.begin(), changes.end(),
                   [](const Change& a, const Change& b) { return a.begin < b.begin; });
  std::string result;
  size_t from = frame.begin;
  for (const Change& change : changes) {
    result += text.substr(from, change.begin - from);
    result += change.number;
    from = change.end;
  }
  result += text.substr(from, frame.end - from);
  return result;
}

}  // namespace armtrue
