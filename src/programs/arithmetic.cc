#include "programs/arithmetic.h"

namespace armtrue {
namespace {

constexpr int kMostBrackets = 32;  // in one another

std::optional<double> take_factor(TextCursor& cursor, const NamedNumber& named, int depth) {
  if (const auto number = cursor.take_number()) return number;
  if (depth > kMostBrackets) return std::nullopt;
  if (cursor.take('-')) {
    const auto value = take_factor(cursor, named, depth + 1);
    return value ? std::optional(-*value) : std::nullopt;
  }
  if (cursor.take('(')) {
    const auto value = take_sum(cursor, named, depth + 1);
    return cursor.take(')') ? value : std::nullopt;
  }
  cursor.next();
  return named(cursor);
}

std::optional<double> take_product(TextCursor& cursor, const NamedNumber& named, int depth) {
  std::optional<double> value = take_factor(cursor, named, depth);
  while (value) {
    const bool multiplies = cursor.take('*');
    if (!multiplies && !cursor.take('/')) break;
    const auto other = take_factor(cursor, named, depth);
    if (!other || (!multiplies && *other == 0)) return std::nullopt;
    value = multiplies ? *value * *other : *value / *other;
  }
  return value;
}

}  // namespace

std::optional<double> take_sum(TextCursor& cursor, const NamedNumber& named, int depth) {
  std::optional<double> value = take_product(cursor, named, depth);
  while (value) {
    const bool adds = cursor.take('+');
    if (!adds && !cursor.take('-')) break;
    const auto other = take_product(cursor, named, depth);
    if (!other) return std::nullopt;
    value = adds ? *value + *other : *value - *other;
  }
  return value;
}

}  // namespace armtrue
