#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace armtrue {

/// Output that could not be written. The message names the path, the reason and the remedy.
class OutputError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// True of what is written to and never replaced: /dev/null, a pipe, and an open descriptor by
/// name, such as /dev/stdout, even if it leads to a file.
bool is_device_or_pipe(const std::string& path);

/// True if both names lead to one file, also by a hard link. Names of files that do not exist yet
/// are compared.
bool same_file(const std::string& a, const std::string& b);

/// Throws OutputError if write_output() to `path` would fail, as far as one can know beforehand.
void check_writable(const std::string& path);

struct Product {
  std::string path;  ///< "-" or "" is standard output
  std::string text;
};

/// Writes products that belong together: all take their places, or none does. Each is written to a
/// temporary file (`.part` and the number of the process) beside its path and brought to the disk.
/// Of several, the old files are then set aside (`.old` and that number), the last first, and the
/// new ones take their names, the last at the end: let the last be the one that refers to the
/// others. A process that is killed in between leaves the old files under their own names or set
/// aside, never a mixture. SIGINT, SIGTERM, SIGHUP and SIGQUIT wait until this is over. What
/// is_device_or_pipe() is written to as it stands. Throws OutputError.
void write_outputs(const std::vector<Product>& products);

/// The same with one product.
void write_output(const std::string& path, const std::string& text);

}  // namespace armtrue
