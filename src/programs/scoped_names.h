#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace armtrue {

/// The routines of a program as scopes, by where they stand. Scope 0 is the text outside of them;
/// a routine may stand in another.
class Scopes {
 public:
  /// Where a routine begins and ends, in the order of the text.
  void open(size_t at);
  void close(size_t at);
  /// The innermost scope at a place.
  int at(size_t place) const;
  /// The scope that a routine stands in; -1 of scope 0.
  int parent(int scope) const { return parents_[scope]; }
  /// Whether `inner` is `outer` or stands in it.
  bool contains(int outer, int inner) const;

 private:
  void change(size_t at, int scope);

  std::vector<int> parents_{-1};
  std::vector<std::pair<size_t, int>> changes_;  // from this place on: this scope
  int now_ = 0;
};

/// Meanings of names by scope. A routine may give a name another meaning than the text around it.
template <class Value>
class ScopedNames {
 public:
  /// The meaning of a name in a scope, which is added if it is new.
  Value& declare(const std::string& name, int scope) { return values_[name][scope]; }

  /// The meaning of a name in a scope: that of the innermost one around it that has one; null if
  /// none has. `found`: that scope.
  Value* find(const Scopes& scopes, const std::string& name, int scope, int* found = nullptr) {
    const auto of_name = values_.find(name);
    if (of_name == values_.end()) return nullptr;
    for (; scope >= 0; scope = scopes.parent(scope))
      if (const auto value = of_name->second.find(scope); value != of_name->second.end()) {
        if (found) *found = scope;
        return &value->second;
      }
    return nullptr;
  }

  template <class Do>
  void each(Do with) {
    for (auto& [name, of_name] : values_)
      for (auto& [scope, value] : of_name) with(value);
  }

 private:
  std::map<std::string, std::map<int, Value>> values_;
};

}  // namespace armtrue
