// Preloaded into a command: it has as many processors as ARMTRUE_TEST_THREADS says. Each time that
// it asks, a line goes to the file ARMTRUE_TEST_ASKED.

#include <cstdlib>
#include <fstream>
#include <thread>

unsigned std::thread::hardware_concurrency() noexcept {
  if (const char* const asked = std::getenv("ARMTRUE_TEST_ASKED"))
    std::ofstream(asked, std::ios::app) << "asked\n";
  const char* const threads = std::getenv("ARMTRUE_TEST_THREADS");
  return threads ? static_cast<unsigned>(std::atoi(threads)) : 0;
}
