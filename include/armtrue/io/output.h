#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/io/document.h"

namespace armtrue {

/// Thrown for output that could not be written. The message names the path, the reason and the
/// remedy.
class OutputError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// True for an output that is written to and never replaced: /dev/null, a pipe, or the name of an
/// open descriptor, such as /dev/stdout, even if it leads to a file.
bool is_device_or_pipe(const std::string& path);

/// Throws OutputError if `path` is a link to a file or folder that does not exist: writing would
/// replace the link.
void refuse_dangling_link(const std::string& path);

/// True if both names lead to the same file, also by a hard link. If a file does not exist yet, the
/// names are compared.
bool same_file(const std::string& a, const std::string& b);

/// Throws OutputError if write_output() to `path` would fail, as far as this can be checked
/// beforehand.
void check_writable(const std::string& path);

struct Product {
  /// A text. Under the name of a JSON file it is a CSV table, which is written as JSON.
  Product(std::string to, const std::string& what);
  /// A document is written as JSON if is_json_file(), else as YAML.
  Product(std::string to, const Document& document)
      : path(std::move(to)), text(is_json_file(path) ? document.json() : document) {}
  /// The bytes of a file of the user, whatever its name is.
  static Product bytes(const std::string& to, std::string bytes) {
    Product product(to, Document{});
    product.text = std::move(bytes);
    return product;
  }

  std::string path;  ///< "-" or "" is standard output
  std::string text;
};

/// Writes products that belong together: either all of them or none. None may be a file that was
/// read, see InputsStay. A file that is replaced keeps its mode and, as far as the process may set
/// them, its owner and group. Each is first written to a temporary file beside its path (`.part`
/// and the process id) and synchronised to the disk. With several products, the old files are then
/// renamed (`.old` and the process id), the last one first, and the new files get their names, the
/// last one last. So the last product should be the one that refers to the others. If the process
/// is killed in between, the old files remain, under their own or their `.old` names, and never a
/// mixture of old and new. SIGINT, SIGTERM, SIGHUP and SIGQUIT wait until this is done. An output
/// with is_device_or_pipe() is written to directly. Throws OutputError.
void write_outputs(const std::vector<Product>& products);

/// The same with one product.
void write_output(const std::string& path, const std::string& text);
void write_output(const std::string& path, const Document& document);

}  // namespace armtrue
