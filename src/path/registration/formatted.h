#pragma once

#include <string>

namespace armtrue {

/// One number by a format of printf, such as "%.3g".
std::string formatted(const char* format, double value);

}  // namespace armtrue
