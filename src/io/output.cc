#include "armtrue/io/output.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>

#include "armtrue/io/inputs_stay.h"
#include "armtrue/text/edit_distance.h"
#include "io/file_rights.h"
#include "io/signals_wait.h"
#include "io/table_json.h"

namespace armtrue {
namespace {

namespace fs = std::filesystem;

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
    case EFBIG:
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

// The file that is replaced: behind a symbolic link, which stays, the file that it names.
std::string target(const std::string& path) {
  refuse_dangling_link(path);
  std::error_code error;
  const auto absolute = fs::absolute(path, error);
  const auto whole = error ? absolute : fs::weakly_canonical(absolute, error);
  if (error) fail(path, error.value());
  return whole.string();
}

// A name of an open descriptor, such as /dev/stdout or /proc/self/fd/3.
bool names_a_descriptor(const fs::path& path) {
  const std::string name = path.lexically_normal().string();
  return name.starts_with("/dev/fd/") || name.starts_with("/dev/std") ||
         (name.starts_with("/proc/") && name.find("/fd/") != std::string::npos);
}

bool leads_to_a_descriptor(fs::path path) {
  constexpr int kMaxLinks = 40;  // as many as Linux follows
  std::error_code error;
  for (int links = 0; links < kMaxLinks; ++links) {
    if (names_a_descriptor(path)) return true;
    const fs::path next = fs::read_symlink(path, error);
    if (error) return false;  // no link
    path = path.parent_path() / next;
  }
  return false;
}

void write_all(int descriptor, const std::string& text, const std::string& path) {
  size_t written = 0;
  while (written < text.size()) {
    const ssize_t count = write(descriptor, text.data() + written, text.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail(path);
    written += count;
  }
}

// Synchronises the folder, so that the new name survives a loss of power. Errors are ignored: some
// file systems cannot do it.
void sync_folder(const std::string& file) {
  const int folder = open(fs::path(file).parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  fsync(folder);
  close(folder);
}

// A file that is written under another name first. Until commit(), the old file is as it was, or
// set aside under a name of its own; what was not committed is undone at the end of the scope.
class ReplacedFile {
 public:
  explicit ReplacedFile(const Product& product)
      : path_(product.path),
        file_(target(product.path)),
        part_(file_ + suffix(".part")),
        old_(file_ + suffix(".old")) {
    unlink(part_.c_str());  // of a process that was killed
    struct stat old {};
    const bool is_replaced = stat(file_.c_str(), &old) == 0;
    const mode_t mode = is_replaced ? 0600 : 0666;  // nobody else may read it before it is like old
    const int descriptor = open(part_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (descriptor < 0) fail(path_);
    is_part_ = true;
    try {
      write_all(descriptor, product.text, path_);
      if (is_replaced && !give_rights(descriptor, old)) fail(path_);
      if (fsync(descriptor) != 0 && errno != EINVAL && errno != ENOTSUP) fail(path_);
    } catch (const OutputError&) {
      close(descriptor);
      undo();
      throw;
    }
    if (close(descriptor) == 0) return;
    const int error = errno;
    undo();
    fail(path_, error);
  }
  ReplacedFile(const ReplacedFile&) = delete;
  ReplacedFile& operator=(const ReplacedFile&) = delete;
  ~ReplacedFile() {
    if (!committed_) undo();
  }

  void set_old_aside() {
    if (std::rename(file_.c_str(), old_.c_str()) == 0)
      is_aside_ = true;
    else if (errno != ENOENT)
      fail(path_);
  }

  void put_in_place() {
    if (std::rename(part_.c_str(), file_.c_str()) != 0) fail(path_);
    is_part_ = false;
    is_new_ = true;
    sync_folder(file_);
  }

  void commit() {
    committed_ = true;
    if (is_aside_) unlink(old_.c_str());
  }

 private:
  static std::string suffix(const char* kind) { return kind + std::to_string(getpid()); }

  void undo() {
    if (is_part_) unlink(part_.c_str());
    if (is_aside_)
      std::rename(old_.c_str(), file_.c_str());
    else if (is_new_)
      unlink(file_.c_str());
    is_part_ = is_aside_ = is_new_ = false;
  }

  std::string path_, file_, part_, old_;
  bool is_part_ = false, is_aside_ = false, is_new_ = false, committed_ = false;
};

void write_to_device(const Product& product) {
  if (product.path.empty() || product.path == "-") {
    const std::string& text = product.text;
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
      fail("<stdout>");
    return;
  }
  const int device = open(product.path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (device < 0) fail(product.path);
  try {
    write_all(device, product.text, product.path);
  } catch (const OutputError&) {
    close(device);
    throw;
  }
  if (close(device) != 0) fail(product.path);
}

}  // namespace

bool is_device_or_pipe(const std::string& path) {
  std::error_code none;
  return leads_to_a_descriptor(path) ||
         (fs::exists(path, none) && !fs::is_regular_file(path, none));
}

void refuse_dangling_link(const std::string& path) {
  std::error_code none;
  struct stat status {};
  if (stat(path.c_str(), &status) == 0 || (errno != ENOENT && errno != ELOOP)) return;
  if (!fs::is_symlink(fs::symlink_status(path, none))) return;
  throw OutputError(path + ": is a link to '" + fs::read_symlink(path, none).string() +
                    "', and there is no such file; remove the link, or name the file itself");
}

bool same_file(const std::string& a, const std::string& b) {
  struct stat first {
  }, second{};
  if (stat(a.c_str(), &first) == 0 && stat(b.c_str(), &second) == 0)
    return first.st_dev == second.st_dev && first.st_ino == second.st_ino;
  std::error_code none;
  const auto whole = [&](const std::string& path) {
    return fs::weakly_canonical(fs::absolute(path, none), none);
  };
  return whole(a) == whole(b);
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
  const std::string folder = fs::path(file).parent_path().string();
  if (access(folder.c_str(), W_OK | X_OK) != 0) fail(path);
}

void write_outputs(const std::vector<Product>& products) {
  for (const Product& product : products) {
    refuse_input(product.path);
    check_writable(product.path);
  }
  {
    const SignalsWait wait;
    std::vector<std::unique_ptr<ReplacedFile>> files;
    for (const Product& product : products)
      if (!product.path.empty() && product.path != "-" && !is_device_or_pipe(product.path))
        files.push_back(std::make_unique<ReplacedFile>(product));
    if (files.size() > 1)
      for (size_t k = files.size(); k-- > 0;) files[k]->set_old_aside();
    for (const auto& file : files) file->put_in_place();
    for (const auto& file : files) file->commit();
  }
  for (const Product& product : products)
    if (product.path.empty() || product.path == "-" || is_device_or_pipe(product.path))
      write_to_device(product);
}

Product::Product(std::string to, const std::string& what)
    : path(std::move(to)), text(is_json_file(path) ? table_as_json(what) : what) {}

void write_output(const std::string& path, const std::string& text) {
  write_outputs({{path, text}});
}

void write_output(const std::string& path, const Document& document) {
  write_outputs({{path, document}});
}

bool is_json_file(const std::string& path) {
  return lower_case(fs::path(path).extension().string()) == ".json";
}

}  // namespace armtrue
