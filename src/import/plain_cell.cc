#include "import/plain_cell.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdlib>

#include "armtrue/text/number_text.h"

namespace armtrue {
namespace {

bool only_digits(std::string_view text) {
  return std::ranges::all_of(text, [](unsigned char c) { return std::isdigit(c) != 0; });
}

// Most cells: read_number() reads them as they are.
bool is_bare(std::string_view cell, char decimal_sign) {
  return std::ranges::all_of(cell, [&](unsigned char c) {
    return std::isdigit(c) != 0 || c == '-' || c == '+' || c == 'e' || c == 'E' ||
           (c == '.' && decimal_sign == '.');
  });
}

bool is_ascii(std::string_view text) {
  return std::ranges::all_of(text, [](unsigned char c) { return c < 0x80; });
}

std::optional<PlainNumber> number_within_range(std::string_view text, bool ambiguous) {
  const auto value = read_number(text);
  if (!value || !std::isfinite(*value) || std::abs(*value) > kMaxNumber) return std::nullopt;
  return PlainNumber{*value, ambiguous};
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

// 1'260'000: one to three digits, then groups of three. A number is not grouped behind a zero.
bool is_grouped(std::string_view text, char separator) {
  const size_t first = text.find(separator);
  if (first == std::string_view::npos || first == 0 || first > 3 || text.front() == '0')
    return false;
  if (!only_digits(text.substr(0, first))) return false;
  for (size_t at = first; at < text.size(); at += 4)
    if (text[at] != separator || at + 4 > text.size() || !only_digits(text.substr(at + 1, 3)))
      return false;
  return true;
}

struct Mantissa {
  std::string digits;  // with a decimal point
  char thousands = 0;
};

std::optional<Mantissa> read_mantissa(std::string_view text, char decimal_sign) {
  const size_t sign = text.find(decimal_sign);
  const std::string_view whole = text.substr(0, sign);
  const std::string_view fraction =
      sign == std::string_view::npos ? std::string_view() : text.substr(sign + 1);
  if (!only_digits(fraction) || whole.size() + fraction.size() == 0) return std::nullopt;
  Mantissa mantissa{std::string(whole)};
  if (!only_digits(whole)) {
    for (const char separator : {decimal_sign == '.' ? ',' : '.', '\'', ' '})
      if (is_grouped(whole, separator)) mantissa.thousands = separator;
    if (!mantissa.thousands) return std::nullopt;
    std::erase(mantissa.digits, mantissa.thousands);
  }
  if (mantissa.digits.empty()) mantissa.digits = "0";
  if (!fraction.empty()) (mantissa.digits += '.') += fraction;
  return mantissa;
}

struct NumberParts {
  std::string sign, mantissa, exponent;
};

NumberParts split_number(std::string_view cell) {
  std::string text(cell);
  if (!is_ascii(text)) {
    replace_all(text, "\xC2\xA0", " ");      // no-break space
    replace_all(text, "\xE2\x80\xAF", " ");  // narrow no-break space
    replace_all(text, "\xE2\x88\x92", "-");  // minus sign
  }
  text = trimmed(text);
  NumberParts parts;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    if (text.front() == '-') parts.sign = "-";
    text.erase(0, 1);
  }
  const size_t exponent = text.find_first_of("eE");
  parts.mantissa = text.substr(0, exponent);
  if (exponent != std::string::npos) parts.exponent = text.substr(exponent);
  return parts;
}

// The `count` digits at `at`, which moves behind them.
std::optional<int> take_digits(std::string_view text, size_t& at, size_t count) {
  if (at + count > text.size() || !only_digits(text.substr(at, count))) return std::nullopt;
  const int value = std::atoi(std::string(text.substr(at, count)).c_str());
  at += count;
  return value;
}

bool take(std::string_view text, size_t& at, std::string_view any_of) {
  if (at >= text.size() || any_of.find(text[at]) == std::string_view::npos) return false;
  ++at;
  return true;
}

// Two digits, or one before another sign.
std::optional<int> take_one_or_two(std::string_view text, size_t& at) {
  if (const auto two = take_digits(text, at, 2)) return two;
  return take_digits(text, at, 1);
}

// The number of a month by the first three letters of its English name, as MATLAB writes it.
std::optional<int> take_month(std::string_view text, size_t& at) {
  constexpr std::string_view kMonths = "janfebmaraprmayjunjulaugsepoctnovdec";
  constexpr size_t kLetters = 3;
  if (at + kLetters > text.size()) return std::nullopt;
  std::string name(text.substr(at, kLetters));
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  const size_t place = kMonths.find(name);
  if (place == std::string_view::npos || place % kLetters != 0) return std::nullopt;
  at += kLetters;
  return static_cast<int>(place / kLetters) + 1;
}

// Three numbers with the same sign between them, the year in four digits, at one of the ends. The
// month may be a name, as in 02-Dec-2025.
std::optional<std::int64_t> take_date(std::string_view text, size_t& at, DateOrder order) {
  const auto leading_year = take_digits(text, at, 4);
  const auto first = leading_year ? leading_year : take_one_or_two(text, at);
  const char sign = at < text.size() ? text[at] : '\0';
  if (!first || !take(text, at, "-./ ")) return std::nullopt;
  const auto named = take_month(text, at);
  if (sign == ' ' && !named) return std::nullopt;
  const auto second = named ? named : take_one_or_two(text, at);
  if (!second || !take(text, at, std::string_view(&sign, 1))) return std::nullopt;
  const auto third = leading_year ? take_one_or_two(text, at) : take_digits(text, at, 4);
  if (!third) return std::nullopt;
  const int year = leading_year ? *first : *third;
  const bool day_first = !leading_year && (named || sign == '.' || order == DateOrder::day_first);
  const int month = leading_year || day_first ? *second : *first;
  const int day = leading_year ? *third : day_first ? *first : *second;
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(month),
                                         std::chrono::day(day)};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch().count();
}

// AM, PM, a.m., p.m., behind blanks; nothing if something else stands there.
enum class HalfOfDay { morning, afternoon };
std::optional<HalfOfDay> take_half_of_day(std::string_view text, size_t& at) {
  constexpr std::string_view kNarrowBlank = "\u202f", kFixedBlank = "\u00a0";
  size_t next = at;
  while (next < text.size()) {
    if (text[next] == ' ')
      ++next;
    else if (text.substr(next).starts_with(kNarrowBlank))
      next += kNarrowBlank.size();
    else if (text.substr(next).starts_with(kFixedBlank))
      next += kFixedBlank.size();
    else
      break;
  }
  const bool is_afternoon = next < text.size() && (text[next] == 'p' || text[next] == 'P');
  if (!take(text, next, "apAP")) return std::nullopt;
  const bool has_points = take(text, next, ".");
  if (!take(text, next, "mM") || (has_points && !take(text, next, "."))) return std::nullopt;
  at = next;
  return is_afternoon ? HalfOfDay::afternoon : HalfOfDay::morning;
}

// [s] within the day.
std::optional<double> take_time_of_day(std::string_view text, size_t& at) {
  auto hour = take_one_or_two(text, at);
  if (!hour || *hour > 23 || !take(text, at, ":")) return std::nullopt;
  const auto minute = take_digits(text, at, 2);
  if (!minute || *minute > 59 || !take(text, at, ":")) return std::nullopt;
  const size_t begin = at;
  const auto second = take_digits(text, at, 2);
  if (!second || *second > 59) return std::nullopt;
  std::string seconds(text.substr(begin, 2));
  if (take(text, at, ".,")) {
    const size_t fraction = at;
    while (at < text.size() && std::isdigit(static_cast<unsigned char>(text[at]))) ++at;
    if (at == fraction) return std::nullopt;
    (seconds += '.') += text.substr(fraction, at - fraction);
  }
  if (const auto half = take_half_of_day(text, at)) {
    if (*hour < 1 || *hour > 12) return std::nullopt;
    hour = *hour % 12 + (half == HalfOfDay::afternoon ? 12 : 0);
  }
  return 3600.0 * *hour + 60.0 * *minute + *read_number(seconds);
}

// Z or +02:00 [s]; nothing if it is none.
std::optional<double> read_zone(std::string_view text) {
  if (text == "Z") return 0;
  size_t at = 0;
  const bool west = text.starts_with('-');
  if (!take(text, at, "+-")) return std::nullopt;
  const auto hour = take_digits(text, at, 2);
  take(text, at, ":");
  const auto minute = take_digits(text, at, 2);
  if (!hour || !minute || *hour > 14 || *minute > 59 || at != text.size()) return std::nullopt;
  return (west ? -1 : 1) * (3600.0 * *hour + 60.0 * *minute);
}

}  // namespace

std::optional<PlainNumber> plain_number(std::string_view cell, char decimal_sign) {
  if (is_bare(cell, decimal_sign)) return number_within_range(cell, false);
  const NumberParts parts = split_number(cell);
  const auto mantissa = read_mantissa(parts.mantissa, decimal_sign);
  if (!mantissa) return std::nullopt;
  const char other = decimal_sign == '.' ? ',' : '.';
  return number_within_range(
      parts.sign + mantissa->digits + parts.exponent,
      mantissa->thousands == other && read_mantissa(parts.mantissa, other).has_value());
}

std::optional<double> plain_count(std::string_view cell) {
  const std::string text(trimmed(cell));
  if (text.empty() || text.size() > 19 || !only_digits(text)) return std::nullopt;
  return std::strtod(text.c_str(), nullptr);
}

DecimalEvidence decimal_evidence(std::string_view cell) {
  const bool point = plain_number(cell, '.').has_value();
  const bool comma = plain_number(cell, ',').has_value();
  if (point != comma) return point ? DecimalEvidence::point : DecimalEvidence::comma;
  if (!point) return DecimalEvidence::no_number;
  return cell.find_first_of(".,") == std::string_view::npos ? DecimalEvidence::none
                                                            : DecimalEvidence::ambiguous;
}

std::optional<PlainTime> plain_time(std::string_view cell, DateOrder order) {
  const std::string_view text = trimmed(cell);
  PlainTime time;
  size_t at = 0;
  if (const auto day = take_date(text, at, order)) {
    time.has_date = true;
    time.day = *day;
    if (!take(text, at, "T ,")) return std::nullopt;
    while (take(text, at, " ")) {
    }
  } else {
    at = 0;
  }
  const auto seconds = take_time_of_day(text, at);
  if (!seconds) return std::nullopt;
  time.seconds = *seconds;
  if (at == text.size()) return time;
  const auto zone = read_zone(text.substr(at));
  if (!zone || !time.has_date) return std::nullopt;
  time.has_zone = true;
  time.seconds -= *zone;
  return time;
}

std::optional<std::int64_t> plain_date(std::string_view cell, DateOrder order) {
  const std::string_view text = trimmed(cell);
  size_t at = 0;
  const auto day = take_date(text, at, order);
  return at == text.size() ? day : std::nullopt;
}

std::optional<std::int64_t> day_of(std::string_view cell, DateOrder order) {
  if (const auto day = plain_date(cell, order)) return day;
  const auto time = plain_time(cell, order);
  return time && time->has_date ? std::optional(time->day) : std::nullopt;
}

double seconds_between(const PlainTime& a, const PlainTime& b) {
  const double seconds = 86400.0 * static_cast<double>(a.day - b.day) + (a.seconds - b.seconds);
  return std::round(seconds * 1e6) / 1e6;
}

}  // namespace armtrue
