// mutate TARGET COUNT DICTIONARY SEED...: reads each seed as it is, then COUNT random changes of
// them, the same in every run. A SEED is a file or a folder of files; of a long file the first 20
// kB are changed. An input that takes more than 20 s ends the program by SIGALRM. What the program
// was reading when it crashed stands in the file TARGET.failed then.

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "fuzz/mutation.h"
#include "fuzz/targets.h"

namespace {

namespace fs = std::filesystem;
using namespace armtrue::fuzz;

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  require(file.is_open(), "a seed cannot be read");
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string> seeds_in(const std::vector<fs::path>& paths) {
  std::vector<fs::path> files;
  for (const fs::path& path : paths)
    if (fs::is_directory(path))
      for (const fs::directory_entry& entry : fs::directory_iterator(path))
        files.push_back(entry.path());
    else
      files.push_back(path);
  std::ranges::sort(files);
  std::vector<std::string> seeds;
  for (const fs::path& file : files) {
    seeds.push_back(text_of(file));
    // A KUKA program is one input with its .dat.
    const fs::path dat = fs::path(file).replace_extension(".dat");
    if (file.extension() == ".src" && fs::exists(dat)) seeds.back() += '\0' + text_of(dat);
  }
  require(!seeds.empty(), "there is no seed");
  return seeds;
}

// A line of a dictionary of libFuzzer: "word", with \\, \" and \xHH.
std::string unescaped(const std::string& line) {
  std::string word;
  const size_t end = line.rfind('"');
  for (size_t at = line.find('"') + 1; at < end; ++at) {
    if (line[at] != '\\') {
      word += line[at];
    } else if (line[++at] == 'x') {
      word += static_cast<char>(std::stoi(line.substr(at + 1, 2), nullptr, 16));
      at += 2;
    } else {
      word += line[at];
    }
  }
  return word;
}

std::vector<std::string> words_of(const std::string& dictionary) {
  std::ifstream file(dictionary);
  std::vector<std::string> words;
  for (std::string line; std::getline(file, line);)
    if (line.starts_with('"')) words.push_back(unescaped(line));
  require(!words.empty(), "there is no dictionary");
  return words;
}

const std::string* current = nullptr;  // what is read now
std::string kept_in;

void keep_input(int signal) {
  const int file = open(kept_in.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (file >= 0 && current) (void)!write(file, current->data(), current->size());
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void read_in_time(const Target& target, const std::string& input) {
  current = &input;
  constexpr unsigned kSeconds = 20;
  alarm(kSeconds);
  fuzz_one(target, input);
  alarm(0);
}

}  // namespace

int main(int argc, char** argv) {
  require(argc >= 5, "usage: mutate TARGET COUNT DICTIONARY SEED...");
  const Target* const target = find_target(argv[1]);
  require(target != nullptr, "there is no such target");
  kept_in = std::string(target->name) + ".failed";
  for (const int signal : {SIGABRT, SIGSEGV, SIGFPE, SIGBUS, SIGILL, SIGALRM})
    std::signal(signal, keep_input);
  std::vector<std::string> seeds = seeds_in({argv + 4, argv + argc});
  for (const std::string& seed : seeds) read_in_time(*target, seed);
  constexpr size_t kLongest = 20'000;
  for (std::string& seed : seeds) seed = seed.substr(0, kLongest);
  armtrue::Mutation mutate(1, words_of(argv[3]));
  for (int i = 0; i < std::atoi(argv[2]); ++i)
    read_in_time(*target, mutate(seeds[static_cast<size_t>(i) % seeds.size()]));
}
