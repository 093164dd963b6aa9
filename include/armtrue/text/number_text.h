#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace armtrue {

/// No file means a larger number, whatever the unit; squares of it would leave no digits to others.
inline constexpr double kMaxNumber = 1e15;

/// Throws std::runtime_error for inf and nan: no product states them as numbers.
void require_finite(double value);

/// The number that a whole text is, `+` before it allowed; it may be inf or nan. Nothing if it is
/// none.
std::optional<double> read_number(std::string_view text);

/// The shortest decimal that reads back as exactly this number. Must be finite, as below.
std::string number_text(double value);

/// Four significant digits, enough for a statistic. Must be finite.
std::string rounded(double value);

/// The value rounded to so many decimals, without zeros at the end.
std::string decimal_text(double value, int decimals);

/// The shortest decimal v with v * unit == si, as a file that holds v would be read; if rounding
/// leaves none, the nearest one.
std::string number_text(double si, double unit);

}  // namespace armtrue
