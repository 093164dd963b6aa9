#include "programs/text_cursor.h"

#include <charconv>
#include <system_error>

namespace armtrue {

std::string TextCursor::take_name() {
  skip_blanks();
  const size_t begin = at_;
  if (at_ < end_ && is_letter(text_[at_]))
    while (at_ < end_ && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
  return upper(text_.substr(begin, at_ - begin));
}

std::optional<double> TextCursor::take_number() {
  skip_blanks();
  size_t begin = at_;
  if (begin < end_ && text_[begin] == '+') ++begin;
  size_t digits = begin;
  if (digits == at_ && digits < end_ && text_[digits] == '-') ++digits;
  if (digits >= end_ || (!is_digit(text_[digits]) && text_[digits] != '.')) return std::nullopt;
  double value = 0;
  const auto [rest, error] =
      std::from_chars(text_.data() + begin, text_.data() + end_, value, std::chars_format::general);
  if (error != std::errc()) return std::nullopt;
  at_ = rest - text_.data();
  return value;
}

}  // namespace armtrue
