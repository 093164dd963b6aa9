// libFuzzer on the target that ARMTRUE_FUZZ_TARGET names; see run.

#include <cstdint>
#include <cstdlib>
#include <string>

#include "fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace armtrue::fuzz;
  static const Target* const target = [] {
    const char* const name = std::getenv("ARMTRUE_FUZZ_TARGET");
    const Target* const found = find_target(name ? name : "");
    require(found != nullptr, "ARMTRUE_FUZZ_TARGET names no target");
    return found;
  }();
  fuzz_one(*target, {reinterpret_cast<const char*>(data), size});
  return 0;
}
