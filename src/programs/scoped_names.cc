#include "programs/scoped_names.h"

#include <algorithm>

namespace armtrue {

void Scopes::open(size_t at) {
  parents_.push_back(now_);
  change(at, static_cast<int>(parents_.size()) - 1);
}

void Scopes::close(size_t at) {
  if (now_ > 0) change(at, parent(now_));
}

void Scopes::change(size_t at, int scope) {
  now_ = scope;
  changes_.emplace_back(at, scope);
}

int Scopes::at(size_t place) const {
  const auto behind = std::ranges::upper_bound(changes_, place, {}, &std::pair<size_t, int>::first);
  return behind == changes_.begin() ? 0 : std::prev(behind)->second;
}

bool Scopes::contains(int outer, int inner) const {
  while (inner >= 0 && inner != outer) inner = parent(inner);
  return inner == outer;
}

}  // namespace armtrue
