// What is built for the vector instructions of one processor says on another that they lack, before
// all else of the program runs; so this file is compiled for any.
#ifdef ARMTRUE_NEEDS_X86_64_V3

#include <unistd.h>

#include <string_view>

namespace {

/// Runs before all other static initialisers, whose instructions this processor may lack.
__attribute__((constructor(101))) void refuse_an_older_processor() {
  __builtin_cpu_init();
  if (__builtin_cpu_supports("x86-64-v3")) return;
  constexpr std::string_view sentence =
      "armtrue: this program was built for processors with AVX2, which this one lacks; build it "
      "here, or with -DARMTRUE_PORTABLE=ON\n";
  (void)!write(STDERR_FILENO, sentence.data(), sentence.size());
  _exit(1);
}

}  // namespace

#endif
