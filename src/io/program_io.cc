#include "armtrue/io/program_io.h"

#include <filesystem>

#include "armtrue/io/source.h"

namespace armtrue {
namespace {

TextFile read_text(const std::string& path) {
  Source source(path);
  TextFile file;
  file.text.name = source.name();
  file.text.text = source.read_all();
  file.sha256 = source.sha256();
  return file;
}

// The .dat beside a .src; empty if there is none.
std::string dat_beside_src(const std::string& src) {
  std::filesystem::path beside(src);
  if (!beside.has_extension()) return "";
  for (const char* extension : {".dat", ".DAT", ".Dat"}) {
    beside.replace_extension(extension);
    std::error_code none;
    if (std::filesystem::is_regular_file(beside, none)) return beside.string();
  }
  return "";
}

}  // namespace

std::vector<TextFile> read_program_texts(const std::string& path, const std::string& dat,
                                         bool with_dat) {
  std::vector<TextFile> files{read_text(path)};
  if (!with_dat) return files;
  const bool is_file = files[0].text.name == path;  // no standard input
  const std::string beside = !dat.empty() ? dat : is_file ? dat_beside_src(path) : "";
  if (!beside.empty()) files.push_back(read_text(beside));
  return files;
}

std::string dat_beside(const std::string& src, const std::string& original) {
  const std::string ending = std::filesystem::path(original).extension().string();
  return std::filesystem::path(src).replace_extension(ending.empty() ? ".dat" : ending).string();
}

}  // namespace armtrue
