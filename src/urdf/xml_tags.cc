#include "urdf/xml_tags.h"

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

}  // namespace armtrue
