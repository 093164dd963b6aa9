#include "armtrue/io/program_io.h"

#include <filesystem>

#include "armtrue/io/output.h"
#include "armtrue/io/source.h"

namespace armtrue {
namespace {

KrlFile read_file(const std::string& path) {
  Source source(path);
  KrlFile file;
  file.name = source.name();
  file.text = source.read_all();
  return file;
}

}  // namespace

KrlProgram read_krl(const std::string& src, const std::string& dat) {
  KrlProgram program{read_file(src), std::nullopt};
  std::filesystem::path beside(src);
  if (!dat.empty()) {
    program.dat = read_file(dat);
  } else if (program.src.name == src && beside.has_extension()) {
    for (const char* extension : {".dat", ".DAT", ".Dat"}) {
      beside.replace_extension(extension);
      std::error_code none;
      if (!std::filesystem::is_regular_file(beside, none)) continue;
      program.dat = read_file(beside.string());
      break;
    }
  }
  return program;
}

std::string dat_beside(const std::string& src, const KrlProgram& original) {
  const std::string ending =
      original.dat ? std::filesystem::path(original.dat->name).extension().string() : "";
  return std::filesystem::path(src).replace_extension(ending.empty() ? ".dat" : ending).string();
}

// The .src is the last, because it refers to the points of the .dat.
void write_krl(const CorrectedKrl& corrected, const KrlProgram& original, const std::string& src) {
  std::vector<Product> products;
  if (corrected.dat) products.push_back({dat_beside(src, original), *corrected.dat});
  products.push_back({src, corrected.src});
  write_outputs(products);
}

}  // namespace armtrue
