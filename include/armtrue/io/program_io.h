#pragma once

#include <string>
#include <vector>

#include "armtrue/programs/program_text.h"
#include "armtrue/text/input_error.h"

namespace armtrue {

/// The name of the data list of a program that is written to `src`: the same name with the
/// extension of `original`, the data list of the original program, or .dat if that has none.
std::string dat_beside(const std::string& src, const std::string& original);

/// A text with the SHA-256 of its bytes.
struct TextFile {
  ProgramText text;
  std::string sha256;
};

/// The text in the bytes of a file, unpacked if need be, without a mark of the order of bytes.
/// Throws InputError if it is no text.
ProgramText program_text(const std::string& name, const std::string& bytes);

/// The bytes of a file with another text: packed and with a mark of the order of bytes if those of
/// the original are, and the very bytes of the original if the text is the same.
std::string bytes_of_text(const ProgramText& original, const std::string& text);

/// The texts of a robot program. If `with_dat`, the second is the file `dat` or, if that is empty,
/// the .dat file beside `path` with the same name, if there is one. Throws InputError if a file
/// cannot be read.
std::vector<TextFile> read_program_texts(const std::string& path, const std::string& dat,
                                         bool with_dat);

/// Whether a file is a text of robot programs, by its name: a program, a module, a data list, a
/// listing of FANUC's registers or frames.
bool is_program_text(const std::string& path);

/// What is said of a folder or an archive without a text of robot programs.
InputError no_program_in(const std::string& path);

/// All texts of robot programs in a folder and the folders in it, by their extensions: programs,
/// modules, data lists. In the order of their names, which begin with `folder`. If `folder` is a
/// file: that file alone. Throws InputError if the folder cannot be read or holds none.
std::vector<TextFile> read_program_folder(const std::string& folder);

}  // namespace armtrue
