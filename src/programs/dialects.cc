#include "programs/dialects.h"

#include <algorithm>

#include "programs/text_cursor.h"

namespace armtrue {

const std::vector<const Dialect*>& dialects() {
  static const std::vector<const Dialect*> all{
      &krl_dialect(),      &rapid_dialect(),     &fanuc_dialect(),
      &urscript_dialect(), &polyscope_dialect(), &inform_dialect(),
  };
  return all;
}

const Dialect* find_dialect(const std::string& name) {
  for (const Dialect* dialect : dialects())
    if (dialect->facts().name == name) return dialect;
  return nullptr;
}

const Dialect* dialect_of_file(const std::string& path) {
  const size_t point = path.find_last_of("./");
  if (point == std::string::npos || path[point] != '.') return nullptr;
  const std::string ending = upper(path.substr(point));
  for (const Dialect* dialect : dialects())
    if (std::ranges::find(dialect->facts().endings, ending) != dialect->facts().endings.end())
      return dialect;
  return nullptr;
}

const Dialect& likely_dialect(const std::string& path) {
  const Dialect* const found = dialect_of_file(path);
  return found ? *found : *dialects().front();
}

}  // namespace armtrue
