#include "import/bag.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "armtrue/io/inputs_stay.h"
#include "armtrue/text/input_error.h"

namespace armtrue {
namespace {

namespace fs = std::filesystem;

void visit_file(const std::string& file, const BagVisitor& visitor) {
  note_input(file);
  file.ends_with(".db3") ? visit_db3(file, visitor) : visit_mcap(file, visitor);
}

bool is_bag_file(const std::string& name) {
  return name.ends_with(".db3") || name.ends_with(".mcap");
}

}  // namespace

bool is_bag(const std::string& path) {
  std::error_code unknown;
  return fs::is_directory(path, unknown) || is_bag_file(path);
}

void visit_bag(const std::string& path, const BagVisitor& visitor) {
  std::error_code error;
  if (!fs::is_directory(path, error)) return visit_file(path, visitor);
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) {
    const std::string file = entry.path().string();
    if (is_bag_file(file)) files.push_back(file);
    if (file.ends_with(".zstd") || file.ends_with(".zst"))
      throw InputError(
          file + ": is packed as a file; unpack it (zstd -d FILE), and give the folder again");
  }
  if (error) throw InputError(fmt::format("{}: {}", path, error.message()));
  if (files.empty())
    throw InputError(path +
                     ": is a folder without a recording of ROS 2, files named .mcap or .db3");
  std::ranges::sort(files);
  for (const std::string& file : files) visit_file(file, visitor);
}

}  // namespace armtrue
