#include "programs/arithmetic.h"

namespace armtrue {
namespace {

constexpr int kMostBrackets = 32;  // in one another

class Arithmetic {
 public:
  Arithmetic(TextCursor& cursor, const NamedNumber& named, Quotient quotient)
      : cursor_(cursor), named_(named), quotient_(quotient) {}

  std::optional<double> take_sum(int depth = 0) {
    std::optional<double> value = take_product(depth);
    while (value) {
      const bool adds = cursor_.take('+');
      if (!adds && !cursor_.take('-')) break;
      const auto other = take_product(depth);
      if (!other) return std::nullopt;
      value = adds ? *value + *other : *value - *other;
    }
    return value;
  }

 private:
  std::optional<double> take_product(int depth) {
    std::optional<double> value = take_factor(depth);
    while (value) {
      const bool multiplies = cursor_.take('*');
      if (!multiplies && (quotient_ == Quotient::not_followed || !cursor_.take('/'))) break;
      const auto other = take_factor(depth);
      if (!other || (!multiplies && *other == 0)) return std::nullopt;
      value = multiplies ? *value * *other : *value / *other;
    }
    return value;
  }

  // Signs are no recursion: a damaged file has any number of them.
  std::optional<double> take_factor(int depth) {
    double sign = 1;
    for (;; sign = -sign) {
      if (const auto number = cursor_.take_number()) return sign * *number;
      if (!cursor_.take('-')) break;
    }
    if (depth > kMostBrackets) return std::nullopt;
    std::optional<double> value;
    if (cursor_.take('(')) {
      value = take_sum(depth + 1);
      if (!cursor_.take(')')) return std::nullopt;
    } else {
      cursor_.next();
      value = named_(cursor_);
    }
    return value ? std::optional(sign * *value) : std::nullopt;
  }

  TextCursor& cursor_;
  const NamedNumber& named_;
  const Quotient quotient_;
};

}  // namespace

std::optional<double> take_sum(TextCursor& cursor, const NamedNumber& named, Quotient quotient) {
  return Arithmetic(cursor, named, quotient).take_sum();
}

}  // namespace armtrue
