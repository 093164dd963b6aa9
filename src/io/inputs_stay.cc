#include "armtrue/io/inputs_stay.h"

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <system_error>
#include <unordered_map>
#include <utility>
#include <vector>

namespace armtrue {
namespace {

namespace fs = std::filesystem;

// A file that is open or will be written, by its name at that time.
struct NamedFile {
  std::string given;  // for messages
  fs::path whole;     // without links, as far as it exists
  std::optional<std::pair<dev_t, ino_t>> inode;  // if it exists
};

// Two indices of the inputs, because folders hold thousands of programs: each output is looked up.
struct Register {
  std::vector<NamedFile> inputs, outputs;
  // The first input of each kind:
  std::map<std::pair<dev_t, ino_t>, size_t> by_inode;
  std::unordered_map<std::string, size_t> by_name;  // also by each folder that contains it

  void add_input(const NamedFile& input) {
    const size_t index = inputs.size();
    inputs.push_back(input);
    if (input.inode) by_inode.try_emplace(*input.inode, index);
    fs::path path = input.whole;
    // A folder that is entered has its parents entered.
    while (by_name.try_emplace(path.string(), index).second && path.has_relative_path())
      path = path.parent_path();
  }

  const NamedFile* input_lost_by(const NamedFile& output) const {
    size_t first = inputs.size();
    if (output.inode)
      if (const auto found = by_inode.find(*output.inode); found != by_inode.end())
        first = found->second;
    if (const auto found = by_name.find(output.whole.string()); found != by_name.end())
      first = std::min(first, found->second);
    return first < inputs.size() ? &inputs[first] : nullptr;
  }
};

// Global, because every Source enters itself, wherever a reader opens it: none can be forgotten.
std::optional<Register>& opened() {
  static std::optional<Register> all;
  return all;
}

// Nothing for what is written to and never replaced, such as a device or a pipe.
std::optional<NamedFile> find(const std::string& path, const char* stream, const char* name) {
  const bool is_stream = path.empty() || path == "-";
  const std::string file = is_stream ? stream : path;
  struct stat status {};
  const bool exists = stat(file.c_str(), &status) == 0;
  if (exists && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode)) return std::nullopt;
  std::error_code error;
  const fs::path absolute = fs::absolute(file, error);
  fs::path whole = fs::weakly_canonical(absolute, error);
  if (error) whole = absolute;  // of a descriptor whose file has lost its name
  NamedFile result{is_stream ? name : path, whole, {}};
  if (exists) result.inode = {status.st_dev, status.st_ino};
  return result;
}
std::optional<NamedFile> find_input(const std::string& path) {
  return find(path, "/dev/stdin", "<stdin>");
}
std::optional<NamedFile> find_output(const std::string& path) {
  return find(path, "/dev/stdout", "<stdout>");
}

bool is_lost(const NamedFile& input, const NamedFile& output) {
  if (same_file(input.whole.string(), output.whole.string())) return true;
  return std::ranges::mismatch(output.whole, input.whole).in1 == output.whole.end();  // in a folder
}

[[noreturn]] void refuse(const NamedFile& input, const NamedFile& output) {
  const std::string also = input.given == output.given ? "" : " as " + input.given;
  throw InputWouldBeLost(output.given + ": is read by this command" + also +
                         ", and would be lost as its product; give the product another name");
}

}  // namespace

InputsStay::InputsStay() { opened().emplace(); }
InputsStay::~InputsStay() { opened().reset(); }

void refuse_input(const std::string& path) {
  if (!opened()) return;
  const std::optional<NamedFile> output = find_output(path);
  if (!output) return;
  if (const NamedFile* const input = opened()->input_lost_by(*output)) refuse(*input, *output);
}

void expect_output(const std::string& path) {
  if (!opened()) return;
  refuse_input(path);
  if (const auto output = find_output(path)) opened()->outputs.push_back(*output);
}

void note_input(const std::string& path) {
  if (!opened()) return;
  const std::optional<NamedFile> input = find_input(path);
  if (!input) return;
  for (const NamedFile& output : opened()->outputs)
    if (is_lost(*input, output)) refuse(*input, output);
  opened()->add_input(*input);
}

}  // namespace armtrue
