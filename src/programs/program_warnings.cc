#include "programs/program_warnings.h"

#include <fmt/format.h>

#include <algorithm>

namespace armtrue {

void ProgramWarnings::add(int line, const std::string& text) {
  const auto [place, is_new] = places_.try_emplace(text, kinds_.size());
  if (is_new) kinds_.push_back({text, {}, {}});
  Kind& kind = kinds_[place->second];
  if (!counted_.empty()) line = counted_[line - 1];
  // A copy of a routine has the lines of the routine.
  if (counted_.empty() || kind.known.insert(line).second) kind.lines.push_back(line);
}

std::vector<std::string> ProgramWarnings::list() const {
  constexpr size_t kShown = 5;
  std::vector<std::string> result;
  for (const Kind& kind : kinds_) {
    std::string text = fmt::format("{}:{}: {}", file_, kind.lines.front(), kind.text);
    for (size_t i = 1; i < std::min(kind.lines.size(), kShown); ++i)
      text += fmt::format("{}{}", i == 1 ? "; also lines " : ", ", kind.lines[i]);
    if (kind.lines.size() > kShown) text += fmt::format(" and {} more", kind.lines.size() - kShown);
    result.push_back(text);
  }
  return result;
}

}  // namespace armtrue
