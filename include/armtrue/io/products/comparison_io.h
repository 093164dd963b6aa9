#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/diagnosis/run_comparison.h"
#include "armtrue/io/document.h"
#include "armtrue/io/provenance.h"
#include "armtrue/io/robot_io.h"

namespace armtrue {

/// The document of a run: a calibrated robot, or the figures of a loop or an evaluation.
struct RunFile {
  enum class Kind { robot, loop, evaluation };
  Kind kind = Kind::robot;
  std::string name, sha256;
  Provenance provenance;
  std::optional<RobotFile> robot;    ///< of a robot file
  std::vector<NamedEffect> effects;  ///< those that have a name, not the remainder
  std::optional<RunErrors> errors;   ///< of a loop or an evaluation
};

/// Reads an armtrue-robot/1, armtrue-loop/1 or armtrue-summary/1 document. Throws InputError for
/// any other; for a certificate the message names the command that compares it.
RunFile read_run(const std::string& path);

/// The run as compare_runs() takes it; refers to `run`. The first input of a run is its robot;
/// inputs that are no documents are its readings.
ComparedRun compared_run(const RunFile& run);

/// "a robot file", "the document of a loop", "an evaluation".
std::string kind_in_words(RunFile::Kind kind);

/// Throws InputError, with the remedy, if the documents are of different kinds.
void require_one_kind(const RunFile& before, const RunFile& after);
/// Throws InputError if the document is not that of a loop.
void require_loop(const RunFile& run);

/// The document armtrue-comparison/1. `notes`: see notes_of_runs().
Document write_comparison(const RunComparison& found, const std::vector<std::string>& notes,
                          const RunFile& before, const RunFile& after,
                          const Provenance& provenance);

}  // namespace armtrue
