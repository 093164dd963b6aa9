#include "armtrue/io/inputs_stay.h"

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>
#include <vector>

namespace armtrue {
namespace {

namespace fs = std::filesystem;

// A file that is open or will be written, by its name at that time.
struct NamedFile {
  std::string given;  // for messages
  fs::path whole;     // without links, as far as it exists
};

struct Register {
  std::vector<NamedFile> inputs, outputs;
};

// Sources are opened deep inside the readers, so that none can be forgotten.
std::optional<Register>& opened() {
  static std::optional<Register> all;
  return all;
}

// Nothing for what is written to and never replaced, such as a device or a pipe.
std::optional<NamedFile> find(const std::string& path, const char* stream, const char* name) {
  const bool is_stream = path.empty() || path == "-";
  const std::string file = is_stream ? stream : path;
  struct stat status {};
  if (stat(file.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode))
    return std::nullopt;
  std::error_code error;
  const fs::path absolute = fs::absolute(file, error);
  fs::path whole = fs::weakly_canonical(absolute, error);
  if (error) whole = absolute;  // of a descriptor whose file has lost its name
  return NamedFile{is_stream ? name : path, whole};
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
  for (const NamedFile& input : opened()->inputs)
    if (is_lost(input, *output)) refuse(input, *output);
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
  opened()->inputs.push_back(*input);
}

}  // namespace armtrue
