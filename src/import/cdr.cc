#include "import/cdr.h"

#include <bit>

namespace armtrue {
namespace {

constexpr size_t kHead = 4;

}  // namespace

CdrReader::CdrReader(std::string_view message) {
  if (message.size() < kHead) throw CutMessage();
  is_little_endian_ = (message[1] & 1) != 0;
  rest_ = message.substr(kHead);
}

std::uint64_t CdrReader::number(size_t size) {
  at_ += (size - at_ % size) % size;
  if (rest_.size() < size || at_ > rest_.size() - size) throw CutMessage();
  std::uint64_t value = 0;
  for (size_t k = 0; k < size; ++k) {
    const unsigned char byte = rest_[at_ + (is_little_endian_ ? size - 1 - k : k)];
    value = value << 8 | byte;
  }
  at_ += size;
  return value;
}

std::uint32_t CdrReader::uint32() { return static_cast<std::uint32_t>(number(4)); }

double CdrReader::float64() { return std::bit_cast<double>(number(8)); }

std::string CdrReader::string() {
  const size_t length = uint32();
  if (length > rest_.size() - at_) throw CutMessage();
  std::string text(rest_.substr(at_, length));
  at_ += length;
  if (text.ends_with('\0')) text.pop_back();
  return text;
}

}  // namespace armtrue
