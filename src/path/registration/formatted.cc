#include "path/registration/formatted.h"

#include <array>
#include <cstdio>

namespace armtrue {

std::string formatted(const char* format, double value) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

}  // namespace armtrue
