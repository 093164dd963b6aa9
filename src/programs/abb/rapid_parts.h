#pragma once

#include <memory>
#include <vector>

#include "armtrue/programs/dialect.h"

// What RapidDialect is made of.

namespace armtrue {

/// See Dialect::parse().
void parse_rapid_program(RobotProgram& program, const KnownFrames& known, TargetParts parts);

/// The name of the text that says what other modules do.
inline constexpr const char* kRapidOthers = "";

/// See FolderTexts: modules that declare global data, and what modules do to data.
std::unique_ptr<FolderTexts> rapid_folder(const std::vector<const ProgramText*>& modules);

}  // namespace armtrue
