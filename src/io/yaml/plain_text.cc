#include "io/yaml/plain_text.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "armtrue/text/edit_distance.h"
#include "armtrue/text/utf8.h"

namespace armtrue {
namespace {

// Truth values, null, and the signs for merging and for a default value (YAML 1.1, tags bool, null,
// merge and value).
constexpr std::array<std::string_view, 13> kWords{"",   "~",    "null", "true", "false", "y", "n",
                                                  "yes", "no", "on",   "off",  "<<",    "="};

bool is_word_of_yaml(std::string_view text) {
  return std::ranges::find(kWords, lower_case(text)) != kWords.end();
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Takes the characters of a kind off the beginning of a text.
template <typename OfKind>
size_t take(std::string_view& text, const OfKind& of_kind) {
  const auto end = std::ranges::find_if_not(text, of_kind);
  const size_t count = end - text.begin();
  text.remove_prefix(count);
  return count;
}

bool take_any(std::string_view& text, std::string_view characters) {
  if (text.empty() || characters.find(text.front()) == std::string_view::npos) return false;
  text.remove_prefix(1);
  return true;
}

// All forms of YAML 1.1 and 1.2: digits with underscores between them, octal, hexadecimal, binary
// and sexagesimal numbers, a point, an exponent, .inf and .nan.
bool may_be_a_number(std::string_view text) {
  take_any(text, "+-");
  if (text.size() > 2 && text[0] == '0' && std::string_view("xXoObB").find(text[1]) != text.npos) {
    text.remove_prefix(2);
    take(text, [](unsigned char c) { return std::isxdigit(c) || c == '_'; });
    return text.empty();
  }
  if (text.size() == 4 && text[0] == '.' && std::isalpha(static_cast<unsigned char>(text[1])))
    return true;  // .inf, .nan in any case
  const auto of_number = [](char c) { return is_digit(c) || c == '_'; };
  size_t places = take(text, of_number);
  while (take_any(text, ":")) places += take(text, of_number);
  if (take_any(text, ".")) places += take(text, of_number);
  if (take_any(text, "eE")) {
    take_any(text, "+-");
    take(text, is_digit);
  }
  return places > 0 && text.empty();
}

// 2026-11-27, alone or before a time.
bool begins_as_a_date(std::string_view text) {
  constexpr size_t kYear = 4;
  return take(text, is_digit) == kYear && take_any(text, "-") && take(text, is_digit) > 0 &&
         take_any(text, "-") && take(text, is_digit) > 0;
}

bool begins_with_a_sign(std::string_view text) {
  constexpr std::string_view kSigns = "-?:,[]{}#&*!|>'\"%@`";
  return kSigns.find(text.front()) != std::string_view::npos || text.starts_with("...");
}

}  // namespace

bool is_plain_text(std::string_view text) {
  return !is_word_of_yaml(text) && !may_be_a_number(text) && !begins_as_a_date(text) &&
         !begins_with_a_sign(text) && is_printable(text);
}

bool is_printable(std::string_view text) {
  for (size_t at = 0; at < text.size();) {
    const auto [character, length] = character_at(text, at);
    const bool is_control = character < 0x20 || (character >= 0x7F && character < 0xA0);
    const bool is_line_end = character == 0x2028 || character == 0x2029;
    const bool is_mark = character == 0xFEFF || character == 0xFFFE || character == 0xFFFF;
    if (is_control || is_line_end || is_mark) return false;
    at += length;
  }
  return true;
}

}  // namespace armtrue
