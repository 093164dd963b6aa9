#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace armtrue {

/// Gives each text an index, in the order of first appearance. A hash table with linear probing,
/// which is fast enough for the million ids of a file of a million poses.
class TextIndex {
 public:
  explicit TextIndex(std::vector<std::string>& names) : names_(names), slots_(64) {}

  int of(std::string_view text) {
    const int place = static_cast<int>(names_.size());
    if (place > 0 && names_.back() == text) return place - 1;
    const auto hash = static_cast<std::uint32_t>(std::hash<std::string_view>{}(text));
    size_t slot = first_slot(hash);
    for (; slots_[slot].place >= 0; slot = next_slot(slot))
      if (slots_[slot].hash == hash && names_[slots_[slot].place] == text)
        return slots_[slot].place;
    names_.emplace_back(text);
    slots_[slot] = {hash, place};
    if (2 * names_.size() > slots_.size()) grow();
    return place;
  }

 private:
  struct Slot {
    std::uint32_t hash = 0;
    int place = -1;  // in names_; -1: none
  };

  size_t first_slot(std::uint32_t hash) const { return hash & (slots_.size() - 1); }
  size_t next_slot(size_t slot) const { return (slot + 1) & (slots_.size() - 1); }

  void grow() {
    const std::vector<Slot> before = std::exchange(slots_, std::vector<Slot>(2 * slots_.size()));
    for (const Slot& full : before) {
      if (full.place < 0) continue;
      size_t slot = first_slot(full.hash);
      while (slots_[slot].place >= 0) slot = next_slot(slot);
      slots_[slot] = full;
    }
  }

  std::vector<std::string>& names_;
  std::vector<Slot> slots_;  // a power of two of them, at most half of them full
};

}  // namespace armtrue
