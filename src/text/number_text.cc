#include "armtrue/text/number_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "armtrue/text/input_error.h"

namespace armtrue {

void require_finite(double value) {
  if (!std::isfinite(value))
    throw InputError(
        "a result is no finite number: numbers of the input are too large or too small to compute "
        "with; check their units");
}

std::optional<double> read_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || rest != end) return std::nullopt;
  return value;
}

std::optional<int> read_whole_number(std::string_view text) {
  const auto value = read_number(text);
  if (!value || *value != std::floor(*value)) return std::nullopt;
  if (std::abs(*value) > std::numeric_limits<int>::max()) return std::nullopt;
  return static_cast<int>(*value);
}

namespace {

// Decimals that end in 5 are a little less than that as doubles, some of them, and fmt rounds the
// others to even; all are rounded away from zero.
double with_ties_away(double value) {
  return value * (1 + 2 * std::numeric_limits<double>::epsilon());
}

}  // namespace

NumberText number_text(double value) {
  if (value == 0) return NumberText("0");  // no "-0"
  return number_in_form("{}", value);
}

NumberText rounded(double value) { return number_in_form("{:.4g}", with_ties_away(value)); }

std::string counted(std::int64_t count, std::string_view noun) {
  std::string text = std::to_string(count) + " ";
  const auto ends = [&](std::string_view ending) { return noun.ends_with(ending); };
  if (count == 1) return text += noun;
  const bool is_vowel_before_y = ends("ay") || ends("ey") || ends("oy") || ends("uy");
  if (ends("y") && !is_vowel_before_y) return (text += noun.substr(0, noun.size() - 1)) += "ies";
  const bool hisses = ends("s") || ends("x") || ends("sh") || ends("ch");
  return (text += noun) += hisses ? "es" : "s";
}

NumberText number_in_form(const char* form, double value) {
  require_finite(value);
  return NumberText(fmt::format(fmt::runtime(form), value));
}

NumberText decimal_text(double value, int decimals) {
  double scale = 1;
  for (int k = 0; k < decimals; ++k) scale *= 10;
  return number_text(std::round(value * scale) / scale);
}

int decimals_of_uncertainty(double uncertainty) {
  const std::string text = fmt::format("{:.1e}", uncertainty);
  const int power = read_whole_number(text.substr(text.find('e') + 1)).value();
  return std::max(0, 1 - power);
}

int decimals_of_figure(double figure, double uncertainty) {
  const int of_first_digit = figure > 0 ? decimals_of_uncertainty(figure) - 1 : 0;
  return std::max(of_first_digit, uncertainty > 0 ? decimals_of_uncertainty(uncertainty) : 3);
}

NumberText fixed_text(double value, int decimals) {
  require_finite(value);
  const std::string text = fmt::format("{:.{}f}", with_ties_away(value), decimals);
  const bool is_zero = text.find_first_not_of("-0.") == text.npos;
  return NumberText(is_zero && text.front() == '-' ? text.substr(1) : text);
}

NumberText as_known(double value, double uncertainty) {
  return uncertainty > 0 ? fixed_text(value, decimals_of_uncertainty(uncertainty)) : rounded(value);
}

NumberText number_text(double si, double unit) {
  if (si == 0) return NumberText("0");
  const double value = si / unit;
  require_finite(value);
  for (int digits = 15; digits <= 17; ++digits) {
    const auto rounded = read_number(fmt::format("{:.{}g}", value, digits));
    if (rounded && *rounded * unit == si) return number_text(*rounded);
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double side : {kInfinity, -kInfinity})
    if (const double neighbour = std::nextafter(value, side); neighbour * unit == si)
      return number_text(neighbour);
  return number_text(value);
}

}  // namespace armtrue
