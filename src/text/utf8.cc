#include "armtrue/text/utf8.h"

#include <cstdint>

namespace armtrue {
namespace {

// Bytes of the character that begins at `at`; 0 if none does.
size_t length_of_character(std::string_view text, size_t at) {
  const auto byte = [&](size_t k) -> std::uint8_t { return text[k]; };
  const std::uint8_t first = byte(at);
  if (first < 0x80) return 1;
  const size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || at + length > text.size()) return 0;
  for (size_t k = 1; k < length; ++k)
    if ((byte(at + k) & 0xC0) != 0x80) return 0;
  const std::uint8_t second = byte(at + 1);
  const bool is_overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool is_no_character = (first == 0xED && second > 0x9F) || (first == 0xF4 && second > 0x8F);
  return is_overlong || is_no_character ? 0 : length;
}

}  // namespace

Utf8Character character_at(std::string_view text, size_t at) {
  const size_t length = length_of_character(text, at);
  if (length == 0) return {};
  constexpr char32_t kFirstBits[] = {0, 0x7F, 0x1F, 0x0F, 0x07};
  char32_t code = text[at] & kFirstBits[length];
  for (size_t k = 1; k < length; ++k) code = code << 6 | (text[at + k] & 0x3F);
  return {code, length};
}

bool is_utf8(std::string_view text) {
  for (size_t at = 0; at < text.size();) {
    const size_t length = length_of_character(text, at);
    if (length == 0) return false;
    at += length;
  }
  return true;
}

std::string as_utf8(std::string_view text) {
  if (is_utf8(text)) return std::string(text);
  std::string utf8;
  for (const char c : text) {
    const std::uint8_t byte = c;
    if (byte < 0x80) {
      utf8 += c;
    } else {
      utf8 += static_cast<char>(0xC0 | byte >> 6);
      utf8 += static_cast<char>(0x80 | (byte & 0x3F));
    }
  }
  return utf8;
}

}  // namespace armtrue
