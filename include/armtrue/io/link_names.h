#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace armtrue {

/// Whether a robot file refuses this name for a link, because it means something else there.
inline bool is_reserved_link_name(std::string_view name) {
  constexpr std::array<std::string_view, 5> kReserved{"base", "base_link", "tool", "world",
                                                      "instrument"};
  return std::ranges::find(kReserved, name) != kReserved.end();
}

}  // namespace armtrue
