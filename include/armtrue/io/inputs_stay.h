#pragma once

#include <string>

#include "armtrue/io/output.h"

namespace armtrue {

/// A product would be written over a file that was read. The message names both, and the remedy.
class InputWouldBeLost : public OutputError {
  using OutputError::OutputError;
};

/// While one exists, no file that a Source opens is written or replaced, whatever led to its name:
/// an argument, a file beside another one, or a name within a file. Files are the same by device
/// and inode, so also by a link, or by their whole names. Devices and pipes may be read and
/// written. A command has one for its run; a library may write what it has read.
class InputsStay {
 public:
  InputsStay();
  ~InputsStay();
  InputsStay(const InputsStay&) = delete;
  InputsStay& operator=(const InputsStay&) = delete;
};

/// Says that a file, or a folder as a whole, will be written; "-" is standard output. Throws
/// InputWouldBeLost if it was read, and from then on reading it does.
void expect_output(const std::string& path);

/// Throws InputWouldBeLost if the file, or one in the folder, was read.
void refuse_input(const std::string& path);

/// A Source says that it opens a file; "-" is standard input. Throws InputWouldBeLost if it will be
/// written.
void note_input(const std::string& path);

}  // namespace armtrue
