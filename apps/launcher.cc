// Each command in bin is a link to this: it runs the command as it was built for this processor. It
// is linked statically and compiled for any processor, so it starts everywhere. Beside it:
//     x86-64-v3/COMMAND    for processors with AVX2
//     x86-64/COMMAND       for all
//     loader               optional: the system's libraries come with the commands, in libraries

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

namespace fs = std::filesystem;

int main(int argc, char** argv) {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (error || argc < 1) {
    std::fputs("armtrue: /proc is not mounted, so the command cannot find its files\n", stderr);
    return 1;
  }
  const fs::path home = self.parent_path();
  const std::string command = fs::path(argv[0]).filename();
  __builtin_cpu_init();
  fs::path program = home / "x86-64-v3" / command;
  if (!__builtin_cpu_supports("x86-64-v3") || !fs::exists(program, error))
    program = home / "x86-64" / command;

  std::vector<std::string> words;
  const fs::path loader = home / "loader";
  if (fs::exists(loader, error))
    words = {loader, "--library-path", home / "libraries", "--argv0", command, program};
  else
    words = {program};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.insert(arguments.end(), argv + 1, argv + argc);
  arguments.push_back(nullptr);
  execv(words.front().c_str(), arguments.data());
  std::perror(("armtrue: " + words.front()).c_str());
  return 1;
}
