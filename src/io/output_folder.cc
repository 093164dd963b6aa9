#include "armtrue/io/output_folder.h"

#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "armtrue/io/inputs_stay.h"
#include "io/file_rights.h"
#include "io/signals_wait.h"

namespace armtrue {
namespace {

namespace files = std::filesystem;

constexpr const char* kOwnPicture = "<svg xmlns=\"http://www.w3.org/2000/svg\" data-by=\"armtrue\"";

[[noreturn]] void fail_folder(const std::string& path, const std::string& why) {
  throw OutputError(path + ": cannot be replaced: " + why + "; name an empty or a new folder");
}

bool is_own_picture(const files::path& file) {
  std::error_code none;
  if (!files::is_regular_file(files::symlink_status(file, none))) return false;
  std::string begin(std::strlen(kOwnPicture), ' ');
  std::ifstream(file).read(begin.data(), begin.size());
  return begin == kOwnPicture;
}

// The folder itself where the path is a link to it; without a slash at its end.
std::string folder_behind(const std::string& path) {
  refuse_dangling_link(path);
  std::error_code error;
  std::string whole = files::weakly_canonical(files::absolute(path, error), error).string();
  if (error) fail_folder(path, error.message());
  while (whole.size() > 1 && whole.back() == '/') whole.pop_back();
  return whole;
}

// Gives `path` the rights of what it replaces, if there is something.
void keep_rights(const std::string& old, const std::string& path) {
  struct stat status {};
  if (stat(old.c_str(), &status) != 0) return;
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool is_given = descriptor >= 0 && give_rights(descriptor, status);
  const int error = errno;
  if (descriptor >= 0) close(descriptor);
  if (!is_given) fail_folder(path, std::strerror(error));
}

// Exchanges both folders in one step; where the file system cannot, in two.
void exchange(const std::string& part, const std::string& folder, const std::string& path) {
  if (renameat2(AT_FDCWD, part.c_str(), AT_FDCWD, folder.c_str(), RENAME_EXCHANGE) == 0) return;
  if (errno != EINVAL && errno != ENOSYS) fail_folder(path, std::strerror(errno));
  const std::string old = folder + ".old" + std::to_string(getpid());
  if (std::rename(folder.c_str(), old.c_str()) != 0) fail_folder(path, std::strerror(errno));
  if (std::rename(part.c_str(), folder.c_str()) != 0) {
    const std::string why = std::strerror(errno);
    std::rename(old.c_str(), folder.c_str());
    fail_folder(path, why);
  }
  std::rename(old.c_str(), part.c_str());
}

}  // namespace

void check_replaceable(const std::string& path) {
  const std::string folder = folder_behind(path);
  std::error_code error;
  const files::file_status status = files::status(folder, error);
  if (files::exists(status)) {
    if (!files::is_directory(status)) fail_folder(path, "it is no folder");
    for (const auto& entry : files::directory_iterator(folder, error))
      if (!is_own_picture(entry.path()))
        fail_folder(path, "it holds '" + entry.path().filename().string() +
                              "', which is no picture of armtrue and would be lost");
    if (error) fail_folder(path, error.message());
  }
  const std::string above = files::path(folder).parent_path().string();
  if (access(above.c_str(), W_OK | X_OK) != 0) fail_folder(path, std::strerror(errno));
}

void replace_folder(const std::string& path, const std::vector<Product>& pictures) {
  refuse_input(path);
  check_replaceable(path);
  const SignalsWait wait;
  const std::string folder = folder_behind(path);
  const std::string part = folder + ".part" + std::to_string(getpid());
  std::error_code error;
  files::remove_all(part, error);  // of a process that was killed
  if (!files::create_directory(part, error)) fail_folder(path, error.message());
  try {
    for (const Product& picture : pictures) {
      write_output(part + "/" + picture.path, picture.text);
      keep_rights(folder + "/" + picture.path, part + "/" + picture.path);
    }
    keep_rights(folder, part);
    if (!files::exists(folder)) {
      if (std::rename(part.c_str(), folder.c_str()) != 0) fail_folder(path, std::strerror(errno));
    } else {
      exchange(part, folder, path);
    }
  } catch (...) {
    files::remove_all(part, error);
    throw;
  }
  files::remove_all(part, error);
}

}  // namespace armtrue
