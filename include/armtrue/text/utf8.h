#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace armtrue {

/// Whether all bytes belong to characters of UTF-8 (RFC 3629).
bool is_utf8(std::string_view text);

/// The character of UTF-8 that begins at `at`, and the number of its bytes.
struct Utf8Character {
  char32_t code = 0;
  std::size_t length = 0;  ///< 0 where no character begins
};
Utf8Character character_at(std::string_view text, std::size_t at);

/// The text, if it is UTF-8; otherwise its bytes, read as Latin-1, in UTF-8. Files of older
/// programs are in Latin-1, and names from them stand in products, which are in UTF-8.
std::string as_utf8(std::string_view text);

}  // namespace armtrue
