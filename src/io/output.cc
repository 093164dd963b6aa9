#include "armtrue/io/output.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace armtrue {

bool is_device_or_pipe(const std::string& path) {
  std::error_code none;
  return path.rfind("/dev/", 0) == 0 || path.rfind("/proc/", 0) == 0 ||
         (std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none));
}

void write_output(const std::string& path, const std::string& text) {
  const auto fail = [](const std::string& name) {
    throw OutputError(name + ": cannot be written: " + std::strerror(errno));
  };
  if (path.empty() || path == "-") {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
      fail("<stdout>");
    return;
  }
  if (is_device_or_pipe(path)) {
    std::FILE* const device = std::fopen(path.c_str(), "ab");
    if (!device) fail(path);
    const bool taken = std::fwrite(text.data(), 1, text.size(), device) == text.size();
    if (std::fclose(device) != 0 || !taken) fail(path);
    return;
  }
  // A link stays; the file that it names is replaced.
  const std::string target = std::filesystem::weakly_canonical(path).string();
  const std::string temporary = target + ".part" + std::to_string(getpid());
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (!file) fail(path);
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  const bool closed = std::fclose(file) == 0;
  if (!written || !closed || std::rename(temporary.c_str(), target.c_str()) != 0) {
    const int error = errno;
    std::remove(temporary.c_str());
    errno = error;
    fail(path);
  }
}

}  // namespace armtrue
