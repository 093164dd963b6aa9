#pragma once

#include <string>

namespace armtrue {

/// The bytes of a file, which counts as an input of the command (note_input). Throws InputError if
/// it cannot be read or is empty.
std::string bytes_of_file(const std::string& path);

/// SHA-256 in hexadecimal.
std::string sha256_of(const std::string& bytes);

}  // namespace armtrue
