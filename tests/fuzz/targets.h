#pragma once

#include <span>
#include <string>

namespace armtrue::fuzz {

/// Something that reads bytes which people, controllers or other programs wrote.
struct Target {
  const char* name;  ///< as in targets.txt
  /// Reads the bytes, or refuses them by an InputError. Aborts if what was read does not come back
  /// from what is written.
  void (*read)(const std::string& bytes);
};

/// In data_files.cc, exported_tables.cc, robot_programs.cc and arguments.cc.
std::span<const Target> data_file_targets();
std::span<const Target> exported_table_targets();
std::span<const Target> robot_program_targets();
std::span<const Target> argument_targets();

/// The target with this name; nullptr if there is none.
const Target* find_target(const std::string& name);

/// Reads once. An InputError is a right answer; every other exception, a crash, an endless loop and
/// a leak are mistakes.
void fuzz_one(const Target& target, const std::string& bytes);

/// Aborts with a message unless it holds.
void require(bool holds, const char* what);

}  // namespace armtrue::fuzz
