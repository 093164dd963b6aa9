#pragma once

#include <cstddef>
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

/// Where the value of an attribute stands between its quotes, in the text.
struct XmlSpan {
  size_t begin = 0, end = 0;
};

/// The value of an attribute of a tag of this text; nothing if the tag has none with this name.
std::optional<XmlSpan> attribute_span(std::string_view text, const XmlTag& tag,
                                      std::string_view name);

/// The same as text, empty if there is none; entities such as &amp; stay as they are.
std::string_view attribute_text(std::string_view text, const XmlTag& tag, std::string_view name);

}  // namespace armtrue
