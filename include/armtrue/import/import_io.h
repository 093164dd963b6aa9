#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/joint_names.h"

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
  /// Names of formats, at most one for the points and one for the joint angles.
  std::vector<std::string> presets;
  std::string body;           ///< rigid body or marker of a motion capture; may be empty
  std::string join;           ///< id, order, time, stops or empty
  double max_gap_s = 0.1;     ///< between the two joint samples about a point, join by time
  /// Is added to the times of the points, join by time; by stops: if nothing, it is found.
  std::optional<double> clock_offset_s;
  /// Whose joints the table has. By stops its geometry tells which stops belong together.
  std::optional<Robot> robot;
  /// How joint states call the joints, by link of the robot, see urdf_joint_of_link(); without an
  /// entry a joint is called as its link.
  std::map<std::string, std::string> joint_of_link;
};

struct ImportedReadings {
  Campaign campaign;
  std::vector<JointName> joints;  ///< of the robot, or those that the table has
  std::string mapping;  ///< table of the columns that were used, for people
  std::vector<std::string> warnings;
};

/// Reads one exported table that has joint angles and measured points. Throws InputError with file,
/// line, column, content and remedy wherever a name, a unit or a cell can be read in two ways.
ImportedReadings import_readings(const std::string& path, const ImportOptions& options);

/// The names of the formats that --preset takes.
std::vector<std::string> import_presets();

/// The same of two tables: measured points of an instrument, and joint angles of a controller.
ImportedReadings import_readings(const std::string& points, const std::string& joints,
                                 const ImportOptions& options);

}  // namespace armtrue
