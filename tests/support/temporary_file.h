#pragma once

#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <string>

namespace armtrue {

/// A file with the given text, gone at the end of the scope.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text) {
    char name[] = "/tmp/armtrue-test-XXXXXX";
    const int handle = mkstemp(name);
    if (handle >= 0) close(handle);
    path = name;
    std::ofstream(path, std::ios::binary) << text;
  }
  ~TemporaryFile() { std::remove(path.c_str()); }
  std::string path;
};

}  // namespace armtrue
