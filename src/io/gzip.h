#pragma once

#include <string>

namespace armtrue {

/// Whether bytes begin as those of a gzip file do.
bool is_gzip(const std::string& bytes);

/// What a gzip file holds. Throws InputError if it is damaged, was cut off, or holds more than 64
/// MB. `file`: for messages.
std::string gunzip(const std::string& bytes, const std::string& file);

/// The bytes of a gzip file: the same of the same text, without the time and the name.
std::string gzip(const std::string& text);

}  // namespace armtrue
