#include "armtrue/io/program_io.h"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "armtrue/io/source.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/text/edit_distance.h"
#include "io/file_bytes.h"
#include "io/gzip.h"

namespace armtrue {
namespace {

constexpr std::string_view kMark = "\xEF\xBB\xBF";

// No language of a controller has a mark of the order of bytes, which editors put before a text.
void keep_mark_aside(ProgramText& text) {
  text.has_mark = text.text.starts_with(kMark);
  if (text.has_mark) text.text.erase(0, kMark.size());
}

TextFile read_text(const std::string& path) {
  if (const Dialect* const dialect = dialect_of_file(path);
      dialect && dialect->facts().may_be_packed) {
    const std::string bytes = bytes_of_file(path);
    return {program_text(path, bytes), sha256_of(bytes)};
  }
  Source source(path);
  TextFile file;
  file.text.name = source.name();
  file.text.text = source.read_all();
  keep_mark_aside(file.text);
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

ProgramText program_text(const std::string& name, const std::string& bytes) {
  ProgramText text{name, bytes, ""};
  if (is_gzip(bytes)) {
    text.text = gunzip(bytes, name);
    text.packed = bytes;
  }
  check_text(text.text, name);
  keep_mark_aside(text);
  return text;
}

std::string bytes_of_text(const ProgramText& original, const std::string& text) {
  const std::string whole = std::string(original.has_mark ? kMark : "") + text;
  if (original.packed.empty()) return whole;
  return text == original.text ? original.packed : gzip(whole);
}

std::vector<TextFile> read_program_texts(const std::string& path, const std::string& dat,
                                         bool with_dat) {
  std::vector<TextFile> files{read_text(path)};
  if (!with_dat) return files;
  const bool is_file = files[0].text.name == path;  // no standard input
  const std::string beside = !dat.empty() ? dat : is_file ? dat_beside_src(path) : "";
  if (!beside.empty()) files.push_back(read_text(beside));
  return files;
}

bool is_program_text(const std::string& path) {
  if (dialect_of_file(path)) return true;
  const std::filesystem::path name(path);
  const std::string ending = upper_case(name.extension().string());
  const std::string stem = upper_case(name.stem().string());
  // POSREG and SYSFRAME of FANUC; of Yaskawa ALL.PRM holds RC.PRM
  const bool is_listing =
      (ending == ".VA" && (stem.starts_with("P") || stem.starts_with("SYSF"))) ||
      (ending == ".PRM" && (stem == "RC" || stem == "ALL")) ||
      (ending == ".CND" && (stem == "TOOL" || stem == "UFRAME"));
  return is_listing || std::ranges::any_of(dialects(), [&](const Dialect* dialect) {
           const DialectFacts& facts = dialect->facts();
           return !ending.empty() &&
                  (ending == facts.data_list ||
                   std::ranges::find(facts.with_data_list, ending) != facts.with_data_list.end());
         });
}

InputError no_program_in(const std::string& path) {
  return InputError(
      path +
      ": holds no robot program (.src, .mod, .ls, .script, .urp, .jbi); a backup of a "
      "controller has them in a folder such as KRC/R1");
}

std::vector<TextFile> read_program_folder(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (!fs::is_directory(folder, error)) return {read_text(folder)};
  std::vector<std::string> paths;
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    std::error_code none;
    if (is_program_text(at->path().string()) && fs::is_regular_file(at->path(), none))
      paths.push_back(at->path().generic_string());
  }
  if (error)
    throw InputError(folder + ": the folder cannot be read (" + error.message() +
                     "); check its name and its permissions");
  if (paths.empty()) throw no_program_in(folder);
  std::ranges::sort(paths);
  std::vector<TextFile> files;
  for (const std::string& path : paths) files.push_back(read_text(path));
  return files;
}

std::string dat_beside(const std::string& src, const std::string& original) {
  const std::string ending = std::filesystem::path(original).extension().string();
  return std::filesystem::path(src).replace_extension(ending.empty() ? ".dat" : ending).string();
}

}  // namespace armtrue
