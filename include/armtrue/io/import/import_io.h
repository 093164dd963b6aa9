#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"

namespace armtrue {

/// What the user says of exported tables; see import-readings(1).
struct ImportOptions {
  std::vector<std::string> columns;                ///< OUR=THEIRS
  std::vector<std::string> units;                  ///< THEIRS=UNIT
  std::vector<std::string> ignored;                ///< THEIRS
  std::string length_unit, angle_unit, time_unit;  ///< of columns that state none; may be empty
  std::string angles;                              ///< abc, rpy, rotvec or empty
  std::string quaternion;                          ///< wxyz, xyzw or empty
  std::string decimal;                             ///< point, comma or empty: told from the cells
  std::string preset;         ///< ur-rtde or empty; holds for the table with the joint angles
  std::string join;           ///< id, order, time or empty
  double max_gap_s = 0.1;     ///< between the two joint samples about a point, join by time
  double clock_offset_s = 0;  ///< is added to the times of the points, join by time
};

struct ImportedReadings {
  Campaign campaign;
  std::string mapping;  ///< table of the columns that were used, for people
  std::vector<std::string> warnings;
};

/// Reads one exported table that has joint angles and measured points. Throws InputError with file,
/// line, column, content and remedy wherever a name, a unit or a cell can be read in two ways.
ImportedReadings import_readings(const std::string& path, const ImportOptions& options);

/// The same of two tables: measured points of an instrument, and joint angles of a controller.
ImportedReadings import_readings(const std::string& points, const std::string& joints,
                                 const ImportOptions& options);

}  // namespace armtrue
