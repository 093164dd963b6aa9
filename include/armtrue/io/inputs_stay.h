#pragma once

#include <string>

#include "armtrue/io/output.h"

namespace armtrue {

/// Thrown where a product would be written over a file that was read. The message names both files,
/// and the remedy.
class InputWouldBeLost : public OutputError {
  using OutputError::OutputError;
};

/// While one exists, no file that a Source opens is written or replaced, wherever its name comes
/// from: an argument, a file beside another one, or a name within a file. Two names are one file if
/// device and inode are the same, so also through a link, or if the whole names are. Devices and
/// pipes may be read and written. A command has one object for its run; without one, the library
/// may write what it has read.
class InputsStay {
 public:
  InputsStay();
  ~InputsStay();
  InputsStay(const InputsStay&) = delete;
  InputsStay& operator=(const InputsStay&) = delete;
};

/// Announces that a file, or a folder as a whole, will be written; "-" is standard output. Throws
/// InputWouldBeLost if it was read; from then on, reading it throws.
void expect_output(const std::string& path);

/// Throws InputWouldBeLost if the file, or one in the folder, was read.
void refuse_input(const std::string& path);

/// Called by a Source that opens a file; "-" is standard input. Throws InputWouldBeLost if it will
/// be written, see expect_output().
void note_input(const std::string& path);

}  // namespace armtrue
