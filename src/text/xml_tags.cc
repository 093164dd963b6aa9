#include "armtrue/text/xml_tags.h"

#include <utility>

namespace armtrue {

std::optional<XmlTag> next_tag(std::string_view text, size_t from) {
  for (;;) {
    const size_t begin = text.find('<', from);
    if (begin == text.npos) return std::nullopt;
    std::string_view behind;
    for (const auto& [opening, closing] : {std::pair("<!--", "-->"), std::pair("<![CDATA[", "]]>"),
                                           std::pair("<?", "?>"), std::pair("<!", ">")})
      if (behind.empty() && text.substr(begin).starts_with(opening)) behind = closing;
    if (!behind.empty()) {
      const size_t end = text.find(behind, begin);
      if (end == text.npos) return std::nullopt;
      from = end + behind.size();
      continue;
    }
    size_t end = begin;
    for (char quote = 0; end < text.size() && (quote != 0 || text[end] != '>'); ++end)
      if (quote != 0 ? text[end] == quote : text[end] == '"' || text[end] == '\'')
        quote = quote != 0 ? 0 : text[end];
    if (end == text.size()) return std::nullopt;
    XmlTag tag{begin, end + 1, {}, text[begin + 1] == '/', text[end - 1] == '/'};
    const size_t name = begin + (tag.closes ? 2 : 1);
    tag.name = text.substr(name, text.find_first_of(" \t\r\n/>", name) - name);
    return tag;
  }
}

std::optional<XmlSpan> attribute_span(std::string_view text, const XmlTag& tag,
                                      std::string_view name) {
  size_t at = tag.begin + 1 + tag.name.size();
  while (at < tag.end) {
    at = text.find_first_not_of(kXmlBlanks, at);
    const size_t equals = text.find('=', at);
    if (equals >= tag.end) return std::nullopt;
    std::string_view own = text.substr(at, equals - at);
    own = own.substr(0, own.find_last_not_of(kXmlBlanks) + 1);
    const size_t quote = text.find_first_of("\"'", equals);
    if (quote >= tag.end) return std::nullopt;
    const size_t end = text.find(text[quote], quote + 1);
    if (end >= tag.end) return std::nullopt;
    if (own == name) return XmlSpan{quote + 1, end};
    at = end + 1;
  }
  return std::nullopt;
}

std::string_view attribute_text(std::string_view text, const XmlTag& tag, std::string_view name) {
  const auto span = attribute_span(text, tag, name);
  return span ? text.substr(span->begin, span->end - span->begin) : std::string_view();
}

}  // namespace armtrue
