#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "armtrue/text/text_parts.h"

namespace armtrue {

/// What one cell says about the decimal sign of its table.
enum class DecimalEvidence {
  none,       ///< a number without comma and point
  point,      ///< a number only if the point is the decimal sign
  comma,      ///< a number only if the comma is
  ambiguous,  ///< 1,260 and 1.260: either may be
  no_number,
};
DecimalEvidence decimal_evidence(std::string_view cell);

struct PlainNumber {
  double value = 0;
  /// The other of comma and point was taken as thousands separator although it could be the decimal
  /// sign too, as in 1,260 in a table with decimal points.
  bool ambiguous = false;
};

/// The number of a cell with this decimal sign, ',' or '.'. Thousands may be separated by the other
/// sign, by blanks or by apostrophes, in groups of three digits. Nothing if the cell is no number.
std::optional<PlainNumber> plain_number(std::string_view cell, char decimal_sign);

/// A whole number of up to 19 digits, without sign: what clocks count, such as nanoseconds since
/// 1970. plain_number() refuses numbers so large.
std::optional<double> plain_count(std::string_view cell);

/// How dates with slashes are written: 3/5/2024 is the third of May or the fifth of March.
enum class DateOrder { day_first, month_first };

/// A date and time of ISO 8601 or a time of day.
struct PlainTime {
  bool has_date = false, has_zone = false;
  std::int64_t day = 0;  ///< since 1970-01-01, UTC if has_zone
  double seconds = 0;    ///< within the day
};

/// 2024-05-03T12:33:01.25, with blank for T, with Z or +02:00, or a time of day 12:33:01, also as
/// 12:33:01 PM. The date may also be 2024/5/3, 3-May-2024, 3.5.2024, whose points always follow the
/// day, or one of `order`.
std::optional<PlainTime> plain_time(std::string_view cell, DateOrder order = DateOrder::day_first);
/// 2024-05-03 or another of these forms: the day since 1970-01-01.
std::optional<std::int64_t> plain_date(std::string_view cell,
                                       DateOrder order = DateOrder::day_first);
/// The day of a date, alone or before a time.
std::optional<std::int64_t> day_of(std::string_view cell, DateOrder order);

/// a - b [s], rounded to microseconds.
double seconds_between(const PlainTime& a, const PlainTime& b);

}  // namespace armtrue
