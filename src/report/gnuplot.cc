#include "report/gnuplot.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <stdexcept>

namespace armtrue {
namespace {

// A descriptor that is closed at the end of the scope.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {
    if (number < 0) throw std::runtime_error("a report cannot be drawn: no descriptor is left");
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }

  int number() const { return number_; }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }

 private:
  int number_;
};

// The script goes through a file: through a pipe, gnuplot could block on its output before it has
// read the whole script. The file is in memory and has no name that a shell would read.
int script_file(const std::string& text) {
  const int file = memfd_create("armtrue-plot", MFD_CLOEXEC);
  size_t written = 0;
  while (file >= 0 && written < text.size()) {
    const ssize_t count = write(file, text.data() + written, text.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0)
      throw std::runtime_error("a report cannot be drawn: there is not enough memory");
    written += static_cast<size_t>(count);
  }
  if (file >= 0) lseek(file, 0, SEEK_SET);
  return file;
}

// Nothing if gnuplot could not be started.
pid_t start_gnuplot(int input, int output) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  std::string name = "gnuplot", from_input = "-";
  std::array<char*, 3> arguments{name.data(), from_input.data(), nullptr};
  pid_t child = -1;
  if (posix_spawnp(&child, "gnuplot", &actions, nullptr, arguments.data(), environ) != 0)
    child = -1;
  posix_spawn_file_actions_destroy(&actions);
  return child;
}

std::string read_all_of(int descriptor) {
  std::string text;
  std::array<char, 4096> buffer;
  while (true) {
    const ssize_t count = read(descriptor, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return text;
    text.append(buffer.data(), static_cast<size_t>(count));
  }
}

bool ended_well(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return false;
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

[[noreturn]] void fail_to_draw() {
  throw std::runtime_error(
      "a report needs gnuplot, which could not draw; install the package gnuplot-nox");
}

// What gnuplot writes with one of its terminals.
std::string drawn(const std::string& terminal, const std::string& script, int width, int height) {
  const Descriptor file(script_file("set terminal " + terminal + " size " + std::to_string(width) +
                                    "," + std::to_string(height) + " font 'sans-serif,12'\n" +
                                    script));
  std::array<int, 2> ends{-1, -1};
  (void)!pipe2(ends.data(), O_CLOEXEC);
  const Descriptor reading(ends[0]);
  Descriptor writing(ends[1]);
  const pid_t child = start_gnuplot(file.number(), writing.number());
  writing.close();
  std::string picture = child < 0 ? "" : read_all_of(reading.number());
  if (child < 0 || !ended_well(child)) fail_to_draw();
  return picture;
}

}  // namespace

std::string plot_svg(const std::string& script, int width, int height) {
  const std::string svg = drawn("svg", script, width, height);
  const size_t begin = svg.find("<svg");
  if (begin == std::string::npos) fail_to_draw();
  return svg.substr(begin);  // without the XML prologue, to stand in a page
}

std::string plot_png(const std::string& script, int width, int height) {
  std::string png = drawn("pngcairo", script, width, height);
  if (!png.starts_with("\x89PNG")) fail_to_draw();
  return png;
}

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (char c : text) {
    result += c;
    if (c == '\'') result += '\'';
  }
  return result + "'";
}

}  // namespace armtrue
