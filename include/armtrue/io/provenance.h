#pragma once

#include <string>
#include <utility>
#include <vector>

namespace armtrue {

/// The command and version that made a document, and its input files.
struct Provenance {
  std::string command;
  std::string version;
  std::vector<std::pair<std::string, std::string>> inputs;  ///< file, SHA-256
  std::vector<std::string> warnings;                        ///< of the command
};

}  // namespace armtrue
