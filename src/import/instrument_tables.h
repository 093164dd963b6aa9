#pragma once

#include <string>

#include "import/plain_table.h"
#include "import/presets.h"

namespace armtrue {

/// Reads the table of a preset whose TableForm is not `header`. `body`: the rigid body or marker of
/// a motion capture that is taken; may be empty if there is one only. This and the readers below
/// throw InputError.
PlainTable read_instrument_table(const std::string& path, const Preset& preset,
                                 const std::string& body);

/// Points of SpatialAnalyzer as text: Collection, Group, Point, X, Y, Z, date and time. The file
/// names no columns; names may be left out from the left, the time from the right. A comment `//
/// AXES = CARTESIAN: X, Y, Z (mm)` states the unit.
PlainTable read_spatial_analyzer(const std::string& path);

/// CSV of OptiTrack Motive: a line of properties, then lines of types, names and kinds above the
/// line that begins with Frame. Of the body the columns are called Position X, Rotation W.
PlainTable read_motive(const std::string& path, const std::string& body);

/// CSV of Vicon Nexus or Tracker: Objects, Segments or Trajectories, the rate, names, the line that
/// begins with Frame, units. The times are frame / rate. A body or marker that was not seen has
/// zeros everywhere: its cells become blank.
PlainTable read_vicon(const std::string& path, const std::string& separators,
                      const std::string& body);

/// TSV of Qualisys Track Manager with markers (3D) or rigid bodies (6D): lines such as
/// NO_OF_FRAMES, then that of the column titles, such as Frame, Time, Tool X, Y, Z, Roll, Pitch,
/// Yaw, Residual, Rot[0] to Rot[8]. Unseen bodies as with Vicon.
PlainTable read_qualisys(const std::string& path, const std::string& body);

}  // namespace armtrue
