#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/campaign/reading_sigma.h"
#include "armtrue/campaign/training_rows.h"
#include "armtrue/effects/robot.h"
#include "armtrue/io/document.h"
#include "armtrue/io/provenance.h"

namespace armtrue {

struct RobotFile {
  Robot robot;
  /// Standard deviation of the residuals of its calibration, per axis; 0 for orientations if it had
  /// none.
  std::optional<ReadingSigma> residual_spread;
  std::optional<double> pixel_spread;  ///< the same for images [px]
  std::string name;  ///< of the file, for messages and provenance
  std::string sha256;
  /// Of a calibrated robot: file and SHA-256 of the nominal robot, from its provenance.
  std::optional<std::pair<std::string, std::string>> nominal;
  /// SHA-256 of all files that made it, from its provenance.
  std::vector<std::string> made_of;
  TrainingRows training;  ///< rows of its calibration; none if not stated
  Provenance provenance;  ///< command, version and inputs that the file states, or empty
};

/// Reads an armtrue-robot/1 document. Throws InputError with file, line and key.
RobotFile read_robot(const std::string& path);
Robot parse_robot(const std::string& text, const std::string& file);
/// The same from the text of the file; `name` and `sha256` are empty.
RobotFile parse_robot_file(const std::string& text, const std::string& file);

/// The armtrue-robot/1 document of a robot, with provenance if that names a command. Numbers read
/// back exactly.
Document write_robot(const Robot& robot, const Provenance& provenance = {});

}  // namespace armtrue
