#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace armtrue {

/// Largest number that files may hold, whatever the unit. With larger ones, squares would lose the
/// digits of all other numbers.
inline constexpr double kMaxNumber = 1e15;

/// Throws std::runtime_error for inf and nan, which no product may contain.
void require_finite(double value);

/// The number that the whole text represents, a leading `+` allowed; it may be inf or nan. Empty if
/// the text is no number.
std::optional<double> read_number(std::string_view text);

/// The shortest decimal that reads back as exactly this number. The number must be finite, as in
/// the functions below.
std::string number_text(double value);

/// Four significant digits, enough for a statistic. Must be finite.
std::string rounded(double value);

/// The value rounded to so many decimals, without zeros at the end.
std::string decimal_text(double value, int decimals);

/// The shortest decimal v with v * unit == si, so that a file with v reads back exactly. If
/// rounding leaves no such v, the nearest one.
std::string number_text(double si, double unit);

}  // namespace armtrue
