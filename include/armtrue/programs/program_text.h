#pragma once

#include <cstddef>
#include <string>

namespace armtrue {

/// A text of a controller, byte by byte. Any encoding and any line ends are kept.
struct ProgramText {
  std::string name;  ///< for messages
  std::string text;
  std::string packed;  ///< the bytes of its file, if they are the text packed by gzip; else empty
  bool has_mark = false;  ///< a mark of the order of bytes (BOM) stands before the text in its file
};

/// A change of one of the texts of a program: `text` in place of the bytes [begin, end).
struct TextEdit {
  int file;  ///< index in RobotProgram::texts
  size_t begin, end;
  std::string text;
};

}  // namespace armtrue
