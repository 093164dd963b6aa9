#include "programs/written_number.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace armtrue {
namespace {

constexpr int kMaxDecimals = 9;

}  // namespace

int written_decimals(std::string_view number) {
  const size_t exponent = std::min(number.find_first_of("eE"), number.size());
  const size_t point = number.find('.');
  int decimals =
      point < exponent ? static_cast<int>(std::min<size_t>(exponent - point - 1, 20)) : 0;
  if (exponent < number.size()) {
    int power = 0;
    size_t from = exponent + 1;
    if (from < number.size() && number[from] == '+') ++from;
    std::from_chars(number.data() + from, number.data() + number.size(), power);
    decimals = power > decimals ? 0 : std::min(decimals - power, kMaxDecimals);
  }
  return std::min(decimals, kMaxDecimals);
}

std::string rounded_text(double value, int at_least, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, std::max(at_least, decimals));
  if (const size_t point = text.find('.'); point != std::string::npos) {
    while (text.size() - point - 1 > static_cast<size_t>(at_least) && text.back() == '0')
      text.pop_back();
    if (text.back() == '.') text.pop_back();
  }
  if (text.find_first_not_of("-0.") == std::string::npos && text[0] == '-') text.erase(0, 1);
  return text;
}

}  // namespace armtrue
