#include "report/gnuplot.h"

#include <stdlib.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <stdexcept>

namespace armtrue {
namespace {

// The script goes through a file: through a pipe, gnuplot could block on its output before it has
// read the whole script.
class ScriptFile {
 public:
  explicit ScriptFile(const std::string& text)
      : path_((std::filesystem::temp_directory_path() / "armtrue-plot-XXXXXX").string()) {
    const int descriptor = mkstemp(path_.data());
    std::FILE* file = descriptor < 0 ? nullptr : fdopen(descriptor, "w");
    if (!file) throw std::runtime_error("cannot write " + path_);
    const bool whole = std::fwrite(text.data(), 1, text.size(), file) == text.size();
    if (std::fclose(file) != 0 || !whole) throw std::runtime_error("cannot write " + path_);
  }
  ScriptFile(const ScriptFile&) = delete;
  ScriptFile& operator=(const ScriptFile&) = delete;
  ~ScriptFile() { unlink(path_.c_str()); }

  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace

std::string plot_svg(const std::string& script, int width, int height) {
  const ScriptFile file("set terminal svg size " + std::to_string(width) + "," +
                        std::to_string(height) + " font 'sans-serif,12'\n" + script);
  std::FILE* pipe = popen(("gnuplot '" + file.path() + "' 2>/dev/null").c_str(), "r");
  if (!pipe) throw std::runtime_error("cannot start gnuplot");
  std::string svg;
  char buffer[4096];
  for (size_t count = 0; (count = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;)
    svg.append(buffer, count);
  if (pclose(pipe) != 0 || svg.find("<svg") == std::string::npos)
    throw std::runtime_error(
        "a report needs gnuplot, which could not draw; install the package gnuplot-nox");
  return svg.substr(svg.find("<svg"));  // without the XML prologue, to stand in a page
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
