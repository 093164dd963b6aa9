#include "fuzz/targets.h"

#include <cstdio>
#include <cstdlib>

#include "armtrue/text/input_error.h"

namespace armtrue::fuzz {

const Target* find_target(const std::string& name) {
  for (const std::span<const Target> targets :
       {data_file_targets(), exported_table_targets(), robot_program_targets(), argument_targets()})
    for (const Target& target : targets)
      if (name == target.name) return &target;
  return nullptr;
}

void fuzz_one(const Target& target, const std::string& bytes) {
  try {
    target.read(bytes);
  } catch (const InputError&) {
  }
}

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

}  // namespace armtrue::fuzz
