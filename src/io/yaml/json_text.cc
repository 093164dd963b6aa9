#include "io/yaml/json_text.h"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <string_view>

#include "armtrue/text/utf8.h"
#include "io/yaml/plain_text.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

constexpr char32_t kFirstHalves = 0xD800, kSecondHalves = 0xDC00, kAfterHalves = 0xE000;
constexpr char32_t kBeyond = 0x10000;  // characters from here on have two halves

// Entries between brackets, each on a line of its own or all on one.
template <typename AddEntry>
void add_entries(const YAML::Node& node, const char* brackets, size_t indent, bool on_one_line,
                 std::string& json, const AddEntry& add_entry) {
  json += brackets[0];
  const char* before = "";
  for (const auto& entry : node) {
    json += before;
    before = on_one_line ? ", " : ",";
    if (!on_one_line) json += '\n' + std::string(indent + 2, ' ');
    add_entry(entry);
  }
  if (!on_one_line && node.size() > 0) json += '\n' + std::string(indent, ' ');
  json += brackets[1];
}

void add(const YAML::Node& node, size_t indent, bool on_one_line, std::string& json) {
  on_one_line = on_one_line || node.Style() == YAML::EmitterStyle::Flow;
  if (node.IsMap())
    add_entries(node, "{}", indent, on_one_line, json, [&](const auto& entry) {
      json += json_quoted(entry.first.Scalar()) + ": ";
      add(entry.second, indent + 2, on_one_line, json);
    });
  else if (node.IsSequence())
    add_entries(node, "[]", indent, on_one_line, json,
                [&](const auto& item) { add(item, indent + 2, on_one_line, json); });
  else if (!node.IsScalar())
    json += "null";
  else
    json += is_value(node) ? node.Scalar() : json_quoted(node.Scalar());
}

// Of an escape such as \ud83e.
std::optional<char32_t> escaped(std::string_view text) {
  unsigned code = 0;
  if (text.size() < 6 || !text.starts_with("\\u")) return std::nullopt;
  const char* const end = text.data() + 6;
  const auto read = std::from_chars(text.data() + 2, end, code, 16);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  return code;
}

std::string utf8_of_four_bytes(char32_t character) {
  std::string bytes;
  bytes += static_cast<char>(0xF0 | (character >> 18));
  for (const int shift : {12, 6, 0})
    bytes += static_cast<char>(0x80 | ((character >> shift) & 0x3F));
  return bytes;
}

}  // namespace

// A text in quotes. Unprintable characters are escaped, because readers of YAML, which read this
// too, accept them only so. None of them needs a surrogate pair.
std::string json_quoted(const std::string& text) {
  const std::string utf8 = as_utf8(text);
  std::string json = "\"";
  for (size_t at = 0; at < utf8.size();) {
    const auto [character, length] = character_at(utf8, at);
    const std::string_view bytes = std::string_view(utf8).substr(at, length);
    if (bytes == "\"" || bytes == "\\")
      json += '\\', json += bytes;
    else if (is_printable(bytes))
      json += bytes;
    else
      json += fmt::format("\\u{:04x}", static_cast<unsigned>(character));
    at += length;
  }
  return json + '"';
}

std::string json_text(const YAML::Node& root) {
  std::string json;
  add(root, 0, false, json);
  return json;
}

std::string with_whole_characters(std::string text) {
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first == text.npos || (text[first] != '{' && text[first] != '[')) return text;
  for (size_t at = text.find('\\'); at != text.npos; at = text.find('\\', at)) {
    const std::string_view rest = std::string_view(text).substr(at);
    const auto high = escaped(rest);
    if (high && *high >= kFirstHalves && *high < kSecondHalves)
      if (const auto low = escaped(rest.substr(6));
          low && *low >= kSecondHalves && *low < kAfterHalves) {
        const std::string whole =
            utf8_of_four_bytes(kBeyond + ((*high - kFirstHalves) << 10) + (*low - kSecondHalves));
        text.replace(at, 12, whole);
        at += whole.size();
        continue;
      }
    at += 2;  // the character after the \ belongs to it
  }
  return text;
}

}  // namespace armtrue
