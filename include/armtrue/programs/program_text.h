#pragma once

#include <string>

namespace armtrue {

/// A text of a controller, byte by byte. Any encoding and any line ends are kept.
struct ProgramText {
  std::string name;  ///< for messages
  std::string text;
};

}  // namespace armtrue
