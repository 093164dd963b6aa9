#pragma once

#include <string_view>

namespace armtrue {

/// Whether every reader of YAML 1.1 or 1.2 takes these characters, without quotes, for a text: not
/// for a number (also 0o17, 0x1F, 1_000, 12:30, .inf), a date, a truth value (also yes, on, y), null,
/// or a sign of YAML. `text` is UTF-8.
bool is_plain_text(std::string_view text);

/// Whether every reader takes these characters between quotes as they are: no control character, no
/// line end (also U+0085, U+2028, U+2029), none that YAML forbids. `text` is UTF-8.
bool is_printable(std::string_view text);

}  // namespace armtrue
