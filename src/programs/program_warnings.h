#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace armtrue {

/// Warnings on the lines of a program. Those with the same text become one warning with all its
/// lines.
class ProgramWarnings {
 public:
  /// `file`: the name that every warning begins with. `lines`: as which each line counts, see
  /// RobotProgram::lines.
  explicit ProgramWarnings(std::string file, std::vector<int> lines = {})
      : file_(std::move(file)), counted_(std::move(lines)) {}

  void add(int line, const std::string& text);
  /// In the order in which each text was first added; the first five lines of each are named.
  std::vector<std::string> list() const;

 private:
  struct Kind {
    std::string text;
    std::vector<int> lines;
    std::set<int> known;  // lines, if they count as others
  };
  std::string file_;
  std::vector<int> counted_;
  std::vector<Kind> kinds_;
  std::map<std::string, size_t> places_;  // of the texts among kinds_
};

}  // namespace armtrue
