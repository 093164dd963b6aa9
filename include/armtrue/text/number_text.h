#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace armtrue {

/// Largest number that files may hold, whatever the unit. With larger ones, squares would lose the
/// digits of all other numbers.
inline constexpr double kMaxNumber = 1e15;

/// The text of a number. The type distinguishes it from a name that looks like a number, such as
/// the pose 0032: YAML must quote the name, but not the number.
class NumberText : public std::string {
 public:
  NumberText() = default;
  explicit NumberText(std::string text) : std::string(std::move(text)) {}
};

/// Throws InputError for inf and nan, which no product may contain.
void require_finite(double value);

/// The number that the whole text represents; a leading `+` is allowed, and inf or nan. Empty if
/// the text is no number.
std::optional<double> read_number(std::string_view text);

/// The same for a whole number that an int holds.
std::optional<int> read_whole_number(std::string_view text);

/// The shortest decimal that reads back as exactly this number. The number must be finite, as in
/// the functions below.
NumberText number_text(double value);

/// Four significant digits, enough for a statistic; a 5 behind them is rounded away from zero, here
/// and in fixed_text(). Must be finite.
NumberText rounded(double value);

/// The value rounded to so many decimals, without zeros at the end.
NumberText decimal_text(double value, int decimals);

/// How many decimals show two significant digits of an uncertainty (GUM 7.2.6), which is above
/// zero: 3 of 0.0812, 2 of 0.0997, which is rounded to 0.10.
int decimals_of_uncertainty(double uncertainty);

/// The value with exactly so many decimals, zeros at the end included. Must be finite.
NumberText fixed_text(double value, int decimals);

/// The value with the decimals of its uncertainty; rounded() if that is zero.
NumberText as_known(double value, double uncertainty);

/// The same, but of a figure above zero at least the first digit: it does not read 0 beside a large
/// uncertainty.
int decimals_of_figure(double figure, double uncertainty);

/// The shortest decimal v with v * unit == si, so that a file with v reads back exactly. If
/// rounding leaves no such v, the nearest one.
NumberText number_text(double si, double unit);

/// All digits of a whole number.
NumberText whole_number(std::integral auto value) { return NumberText(std::to_string(value)); }

/// The count of what an English noun names: "1 row", "2 rows", "3 boundaries".
std::string counted(std::int64_t count, std::string_view noun);

/// A number in a form of fmt, such as "{:.3f}". Must be finite.
NumberText number_in_form(const char* form, double value);

}  // namespace armtrue
