#include "armtrue/io/output.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace armtrue {
namespace {

const char* remedy(int error) {
  switch (error) {
    case EACCES:
    case EPERM:
    case EROFS:
      return "; name a file in a folder that you may write to, or have it opened to you";
    case ENOENT:
    case ENOTDIR:
    case EISDIR:
    case ELOOP:
      return "; name a file in a folder that there is";
    case ENOSPC:
    case EDQUOT:
      return "; make room there, or name a file elsewhere";
    case ENAMETOOLONG:
      return "; give it a shorter name";
    default:
      return "";
  }
}

[[noreturn]] void fail(const std::string& path, int error = errno) {
  throw OutputError(path + ": cannot be written: " + std::strerror(error) + remedy(error));
}

// A symbolic link stays; the file that it names is replaced.
std::string target(const std::string& path) {
  std::error_code error;
  const auto absolute = std::filesystem::absolute(path, error);
  const auto whole = error ? absolute : std::filesystem::weakly_canonical(absolute, error);
  if (error) fail(path, error.value());
  return whole.string();
}

}  // namespace

bool is_device_or_pipe(const std::string& path) {
  std::error_code none;
  return path.rfind("/dev/", 0) == 0 || path.rfind("/proc/", 0) == 0 ||
         (std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none));
}

void check_writable(const std::string& path) {
  if (path.empty() || path == "-") return;
  if (is_device_or_pipe(path)) {
    if (access(path.c_str(), F_OK) == 0 && access(path.c_str(), W_OK) != 0) fail(path);
    return;
  }
  const std::string file = target(path);
  // Renaming replaces a write-protected file if its folder is writable; refuse that.
  if (access(file.c_str(), F_OK) == 0 && access(file.c_str(), W_OK) != 0) fail(path);
  const std::string folder = std::filesystem::path(file).parent_path().string();
  if (access(folder.c_str(), W_OK | X_OK) != 0) fail(path);
}

void write_output(const std::string& path, const std::string& text) {
  if (path.empty() || path == "-") {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
      fail("<stdout>");
    return;
  }
  check_writable(path);
  if (is_device_or_pipe(path)) {
    std::FILE* const device = std::fopen(path.c_str(), "ab");
    if (!device) fail(path);
    const bool taken = std::fwrite(text.data(), 1, text.size(), device) == text.size();
    if (std::fclose(device) != 0 || !taken) fail(path);
    return;
  }
  const std::string file_name = target(path);
  const std::string temporary = file_name + ".part" + std::to_string(getpid());
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (!file) fail(path);
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  const bool closed = std::fclose(file) == 0;
  if (!written || !closed || std::rename(temporary.c_str(), file_name.c_str()) != 0) {
    const int error = errno;
    std::remove(temporary.c_str());
    errno = error;
    fail(path);
  }
}

}  // namespace armtrue
