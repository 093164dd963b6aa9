#pragma once

#include <string>
#include <string_view>

namespace armtrue {

/// Whether all bytes belong to characters of UTF-8 (RFC 3629).
bool is_utf8(std::string_view text);

/// Text in UTF-8: the same, or, if it is none, its bytes as characters of Latin-1. Files of older
/// programs are in Latin-1, and names from them stand in products, which are in UTF-8.
std::string as_utf8(std::string_view text);

}  // namespace armtrue
