#pragma once

#include <optional>
#include <string_view>

namespace armtrue {

inline constexpr std::string_view kXmlBlanks = " \t\r\n";

/// A tag of an XML text: <name attributes>, </name> or <name attributes/>.
struct XmlTag {
  size_t begin = 0, end = 0;  ///< of the text, from '<' to behind '>'
  std::string_view name;
  bool closes = false, is_empty = false;
};

/// The next tag of a well-formed text at or behind `from`; comments, declarations and CDATA are
/// passed over.
std::optional<XmlTag> next_tag(std::string_view text, size_t from);

}  // namespace armtrue
