#pragma once

#include <string>
#include <utility>
#include <vector>

namespace armtrue {

/// Which command, in which version, made a document from which files.
struct Provenance {
  std::string command;
  std::string version;
  std::vector<std::pair<std::string, std::string>> inputs;  ///< file, SHA-256
  std::vector<std::string> warnings;                        ///< that were given while it was made
};

}  // namespace armtrue
