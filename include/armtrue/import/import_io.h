#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/path/path.h"

namespace armtrue {

/// Options for exported tables; see import-readings(1).
struct ImportOptions {
  std::vector<std::string> columns;                ///< OUR=THEIRS
  std::vector<std::string> units;                  ///< THEIRS=UNIT
  std::vector<std::string> ignored;                ///< THEIRS
  std::string length_unit, angle_unit, time_unit;  ///< of columns that state none; may be empty
  std::string angles;                              ///< abc, rpy, rotvec or empty
  std::string quaternion;                          ///< wxyz, xyzw or empty
  std::string decimal;                             ///< point, comma or empty: found from the cells
  std::string dates;  ///< day-first, month-first or empty: found from the cells
  /// Names of formats, at most one for the points and one for the joint angles.
  std::vector<std::string> presets;
  std::string body;  ///< rigid body or marker, of several in a table; child frame of transforms
  std::string points_topic, joints_topic;  ///< of a recording of ROS 2; empty: the only one of its
                                           ///< kind
  std::vector<std::string> markers;  ///< markers that are read, if rows have several; empty: those
                                     ///< with numbers
  std::string join;        ///< id, order, time, stops or empty
  double max_gap_s = 0.1;  ///< join by time: largest gap of joint samples around a point
  /// Added to the times of the points, for a join by time or stops [s]. For a join by stops it is
  /// estimated if empty.
  std::optional<double> clock_offset_s;
  /// The robot of the joints in the table. For a join by stops its geometry decides which stops
  /// belong together.
  std::optional<Robot> robot;
  /// Name of each joint in joint states, by link of the robot, see urdf_joint_of_link(). A joint
  /// without an entry has the name of its link.
  std::map<std::string, std::string> joint_of_link;
};

struct ImportedReadings {
  Campaign campaign;
  std::vector<JointName> joints;  ///< of the robot, or those of the table
  std::string mapping;            ///< table of the used columns, for a terminal
  std::vector<std::string> warnings;
};

/// Reads one exported table with joint angles and measured points. Throws InputError with file,
/// line, column, content and remedy if a name, a unit or a cell is ambiguous.
ImportedReadings import_readings(const std::string& path, const ImportOptions& options);

/// The names of the formats that --preset takes.
std::vector<std::string> import_presets();

/// The same for two tables: measured points of an instrument, and joint angles of a controller.
ImportedReadings import_readings(const std::string& points, const std::string& joints,
                                 const ImportOptions& options);

struct ImportedPass {
  Path path;                      ///< positions, forces or both
  std::vector<JointName> joints;  ///< of the columns, if it has joint angles
  std::string mapping;            ///< as of ImportedReadings
  std::vector<std::string> warnings;
};

/// Reads the exported record of one pass, of its forces, or of both; its times increase. Rows
/// without a point are lost samples and left out. Throws InputError as import_readings() does.
ImportedPass import_pass(const std::string& path, const ImportOptions& options);

}  // namespace armtrue
