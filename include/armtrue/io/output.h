#pragma once

#include <stdexcept>
#include <string>

namespace armtrue {

/// Output that could not be written. The message names the path, the reason and the remedy.
class OutputError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// True of /dev/null, a pipe, or /dev/stdout, even if it leads to a file: they are written to,
/// never replaced.
bool is_device_or_pipe(const std::string& path);

/// Throws OutputError if write_output() to `path` would fail, as far as one can know beforehand.
void check_writable(const std::string& path);

/// Writes a product: to standard output for "-" or "", else to a temporary file beside `path` that
/// then takes its place, so that a file is replaced whole or not at all. What is no regular file
/// (/dev/null, a pipe) is written to as it stands. Throws OutputError.
void write_output(const std::string& path, const std::string& text);

}  // namespace armtrue
