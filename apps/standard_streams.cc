#include "standard_streams.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>

namespace armtrue::app {
namespace {

constexpr size_t kMaxMessage = 2000, kMessageEnd = 400;

// The whole characters of UTF-8 at the beginning of a text.
size_t whole_characters(const std::string& text, size_t size) {
  while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xC0) == 0x80) --size;
  return size;
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
  for (char& c : message)
    if ((static_cast<unsigned char>(c) < ' ' && c != '\n' && c != '\t') || c == '\x7f') c = '?';
  return message;
}

}  // namespace armtrue::app
