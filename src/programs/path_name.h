#pragma once

#include <string>
#include <string_view>

#include "programs/text_cursor.h"

// The parts of the name of a text, with '/' between folders.

namespace armtrue {

/// With the slash at its end; empty if there is none.
inline std::string folder_of(const std::string& path) {
  const size_t slash = path.rfind('/');
  return slash == std::string::npos ? "" : path.substr(0, slash + 1);
}

/// In capitals.
inline std::string name_in_folder(const std::string& path) {
  return upper(std::string_view(path).substr(folder_of(path).size()));
}

/// In capitals, from the point on: `.SRC`; empty if there is none.
inline std::string ending_of(const std::string& path) {
  const size_t point = path.rfind('.');
  return point == std::string::npos ? "" : upper(std::string_view(path).substr(point));
}

}  // namespace armtrue
