#pragma once

#include <string>
#include <vector>

#include "armtrue/programs/krl.h"

namespace armtrue {

/// Reads a program. Without `dat`, the .dat file beside `src` with the same name is read, if there
/// is one. Throws InputError if a file cannot be read.
KrlProgram read_krl(const std::string& src, const std::string& dat = "");

/// The name of the data list of a program that is written to `src`: the same name with the
/// extension of `original`, the data list of the original program, or .dat if that has none.
std::string dat_beside(const std::string& src, const std::string& original);

/// Writes a corrected program to `src` and its data list to dat_beside(): both or none. Throws
/// OutputError.
void write_krl(const CorrectedKrl& corrected, const KrlProgram& original, const std::string& src);

/// A text with the SHA-256 of its bytes.
struct TextFile {
  ProgramText text;
  std::string sha256;
};

/// The texts of a robot program; `with_dat` as read_krl() does. Throws InputError if a file cannot
/// be read.
std::vector<TextFile> read_program_texts(const std::string& path, const std::string& dat,
                                         bool with_dat);

}  // namespace armtrue
