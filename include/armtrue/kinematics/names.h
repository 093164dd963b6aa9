#pragma once

#include <concepts>
#include <iterator>
#include <optional>
#include <string_view>
#include <vector>

namespace armtrue {

/// The name of an item: a text is its own name; links, targets, anchors and others have a member.
template <typename Item>
std::string_view name_of(const Item& item) {
  if constexpr (std::convertible_to<const Item&, std::string_view>)
    return item;
  else
    return item.name;
}

/// Index of the first item with this name; empty if none has it.
template <typename Items>
std::optional<int> find_name(const Items& items, std::string_view name) {
  for (int k = 0; k < std::ssize(items); ++k)
    if (name_of(items[k]) == name) return k;
  return std::nullopt;
}

/// Index of the first item with the name of `item`, which is added if there is none.
template <typename Item>
int index_of(std::vector<Item>& items, const Item& item) {
  if (!find_name(items, name_of(item))) items.push_back(item);
  return *find_name(items, name_of(item));
}

}  // namespace armtrue
