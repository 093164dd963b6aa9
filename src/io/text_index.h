#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

namespace armtrue {

/// Gives each text an index, in the order of first appearance.
class TextIndex {
 public:
  explicit TextIndex(std::vector<std::string>& names)
      : names_(names), places_(64, Hash{&names}, Equal{&names}) {}

  int of(std::string_view text) {
    if (!names_.empty() && names_.back() == text) return static_cast<int>(names_.size()) - 1;
    if (const auto found = places_.find(text); found != places_.end()) return *found;
    names_.emplace_back(text);
    const int place = static_cast<int>(names_.size()) - 1;
    places_.insert(place);
    return place;
  }

 private:
  struct Hash {
    using is_transparent = void;
    const std::vector<std::string>* names;
    size_t operator()(std::string_view text) const { return std::hash<std::string_view>{}(text); }
    size_t operator()(int place) const { return (*this)(std::string_view((*names)[place])); }
  };
  struct Equal {
    using is_transparent = void;
    const std::vector<std::string>* names;
    bool operator()(int a, int b) const { return a == b; }
    bool operator()(std::string_view text, int place) const { return (*names)[place] == text; }
    bool operator()(int place, std::string_view text) const { return (*names)[place] == text; }
  };
  std::vector<std::string>& names_;
  std::unordered_set<int, Hash, Equal> places_;
};

}  // namespace armtrue
