#pragma once

#include <string>
#include <string_view>

// Numbers of robot programs as text.

namespace armtrue {

/// Decimal places of a number as it is written: digits behind the point less the exponent, at most
/// 9, as a double of some metres has no more.
int written_decimals(std::string_view number);

/// With `decimals` decimals, or more if `at_least` is more, but without zeros behind `at_least`.
std::string rounded_text(double value, int at_least, int decimals);

}  // namespace armtrue
