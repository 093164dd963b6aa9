#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "fuzz/targets.h"

namespace armtrue::fuzz {

/// A file in memory. Its descriptor serves the next one: to make one takes longer than to read a
// short file.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& text) : descriptor_(take()) {
    require(descriptor_ >= 0, "no file in memory can be made");
    require(pwrite(descriptor_, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()),
            "the file in memory cannot be written");
  }
  ~MemoryFile() {
    require(ftruncate(descriptor_, 0) == 0, "the file in memory cannot be emptied");
    idle().push_back(descriptor_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  static std::vector<int>& idle() {
    static std::vector<int> descriptors;
    return descriptors;
  }
  static int take() {
    if (idle().empty()) return memfd_create("fuzz", 0);
    const int descriptor = idle().back();
    idle().pop_back();
    return descriptor;
  }

  int descriptor_;
};

}  // namespace armtrue::fuzz
