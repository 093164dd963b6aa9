#include "standard_streams.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "armtrue/text/utf8.h"

namespace armtrue::app {
namespace {

constexpr size_t kMaxMessage = 2000, kMessageEnd = 400;

// The whole characters of UTF-8 at the beginning of a text.
size_t whole_characters(const std::string& text, size_t size) {
  while (size > 0 && (text[size] & 0xC0) == 0x80) --size;
  return size;
}

// Of U+0000 to U+001F, a tab and a line feed are shown.
constexpr std::pair<char32_t, char32_t> kHidden[] = {
    {0x00, 0x08},     {0x0B, 0x1F},     {0x7F, 0x9F},     // control characters
    {0x061C, 0x061C}, {0x200E, 0x200F}, {0x202A, 0x202E}, {0x2066, 0x2069},  // direction of writing
    {0x00AD, 0x00AD}, {0x180E, 0x180E}, {0x200B, 0x200D}, {0x2060, 0x2064}, {0x206A, 0x206F},
    {0xFEFF, 0xFEFF}, {0xFFF9, 0xFFFB}, {0xE0000, 0xE007F},  // without width
    {0x2028, 0x2029},                                        // line ends
};

bool is_hidden(char32_t code) {
  return std::ranges::any_of(kHidden, [code](const auto& range) {
    return code >= range.first && code <= range.second;
  });
}

}  // namespace

void reserve_standard_streams() {
  for (int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) >= 0) continue;
    // Opened the wrong way round, so that reading or writing fails; only messages go nowhere.
    (void)!open("/dev/null", stream == STDOUT_FILENO ? O_RDONLY : O_WRONLY);
  }
}

void print_error(std::string_view text) { (void)!std::fwrite(text.data(), 1, text.size(), stderr); }

std::string printable(std::string message) {
  if (message.size() > kMaxMessage) {
    const size_t begin = whole_characters(message, kMaxMessage - kMessageEnd);
    const size_t end = whole_characters(message, message.size() - kMessageEnd);
    message = message.substr(0, begin) + " [...] " + message.substr(end);
  }
  return without_controls(message);
}

std::string without_controls(std::string_view text) {
  std::string shown;
  shown.reserve(text.size());
  for (size_t at = 0; at < text.size();) {
    const auto [code, length] = character_at(text, at);
    const size_t taken = std::max<size_t>(length, 1);
    if (length == 0 || is_hidden(code))
      shown += '?';
    else
      shown += text.substr(at, taken);
    at += taken;
  }
  return shown;
}

}  // namespace armtrue::app
