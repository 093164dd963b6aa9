#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace armtrue {

/// Thrown for a message that ends before its last field, or states a length that no message has.
class CutMessage : public std::runtime_error {
 public:
  CutMessage() : std::runtime_error("is shorter than its type says") {}
};

/// Reads the fields of a message of ROS 2 one after the other. They are serialized as CDR (OMG,
/// DDSI-RTPS 2.3, 10.2; CORBA 3.3, part 2, 9.3): four bytes state the order of bytes, then each
/// number stands at a multiple of its size, counted from behind these four. Throws CutMessage.
class CdrReader {
 public:
  explicit CdrReader(std::string_view message);

  std::int32_t int32() { return uint32(); }
  std::uint32_t uint32();
  double float64();
  /// A length that counts the zero at the end, then the characters and the zero.
  std::string string();

 private:
  std::uint64_t number(size_t size);

  std::string_view rest_;
  size_t at_ = 0;
  bool is_little_endian_;
};

}  // namespace armtrue
