#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "armtrue/effects/context.h"
#include "armtrue/effects/effect.h"

namespace armtrue {

/// How many numbers a reading consists of.
struct ReadingSize {
  int position = 3;     ///< 1: a distance
  int orientation = 0;  ///< 3 if it is read
  int all() const { return position + orientation; }
  /// Of the unknowns of a fit, about: what position takes of its own degrees of freedom.
  double share_of_position() const { return static_cast<double>(position) / all(); }
};

/// Measured poses, one row a reading, in order of visit. Columns are vectors of their own, so that
/// a million rows cost only what they hold; an optional column is empty when absent.
struct Campaign {
  std::string source;  ///< file name, for messages

  std::vector<int> pose;  ///< index into pose_ids; rows that share it are replicates
  std::vector<std::string> pose_ids;
  std::vector<int> line;       ///< line in the file
  std::vector<JointVector> q;  ///< [rad]
  /// What was measured, in R_A [m]: points, or distances to anchors; the other is empty.
  std::vector<Eigen::Vector3d> position;
  std::vector<double> distance;

  // Optional columns.
  std::vector<int> repeat;
  std::vector<Eigen::Quaterniond> orientation;  ///< R_A from the measured frame, unit
  std::vector<double> time_s;
  std::vector<int> target;  ///< index into target_names
  std::vector<std::string> target_names;
  std::vector<int> anchor;  ///< of a distance; index into anchor_names
  std::vector<std::string> anchor_names;
  /// Points and distances in one: the first three anchors are the axes of R_A, and what is read
  /// from them, as a distance, is a coordinate. A point is three rows.
  bool has_coordinates = false;
  std::vector<double> sigma_position;     ///< per axis [m]
  std::vector<double> sigma_orientation;  ///< per axis [rad]
  std::vector<Direction> arrival;
  std::vector<double> payload_kg;
  std::vector<std::array<double, kJoints>> motor_torque_nm;
  std::vector<Eigen::Vector3d> force_n;
  std::vector<std::string> temperature_names;
  std::vector<std::array<double, kMaxTemperatures>> temperature_c;
  std::vector<int> session;  ///< index into session_names
  std::vector<std::string> session_names;

  int skipped_rows = 0;  ///< rows without a measurement

  int rows() const { return static_cast<int>(q.size()); }
  bool has_orientation() const { return !orientation.empty(); }
  bool has_distances() const { return !distance.empty(); }
  ReadingSize reading_size() const { return {has_distances() ? 1 : 3, has_orientation() ? 3 : 0}; }
  /// Numbers what a row reads of its pose, by target and anchor: rows of one pose and channel are
  /// replicates.
  int channel(int row) const;
  /// Numbers poses or, where distances are read, poses by anchor: what the model lacks at a pose
  /// strikes such rows alike.
  int pose_by_anchor(int row) const;
  /// Numbers the pose of every row in the order of the ids (`P2` before `P10`), which, unlike
  /// `pose`, does not depend on the order of the rows.
  std::vector<int> pose_by_id() const;
  Context context(int row) const;

  /// The rows of the given indices, in that order, with the pose ids that occur in them.
  Campaign select(const std::vector<int>& rows) const;
};

/// The column that a driver of this kind is read from, if the campaign lacks it, else nothing.
/// `where` is the sensor of a temperature. A campaign without a payload or a force had none: it
/// lacks nothing.
std::string missing_column(const Campaign& campaign, DriverKind kind, const std::string& where);

/// Throws std::invalid_argument, with file and remedy, if the effect follows what the campaign does
/// not tell of its readings: time, a temperature, motor torques or directions of arrival. Those
/// that are read from a file have directions, stated or derived (derive_arrival).
void require_drivers(const Campaign& campaign, const Effect& effect);

/// Makes three rows, its coordinates, of each row with a point in a campaign of points and
/// distances: one whose `position` and `distance` have all rows, the latter 0 where there is none.
/// Of an anchor without a column its name is empty.
void points_to_coordinates(Campaign& campaign);

/// Fills `arrival` from the previous visit of the same session where the file does not state it:
/// the sign of each joint's last motion, 0 before its first. Motions below 1e-4 deg are none. Rows
/// are visited in the order of their times or, without times, as they stand.
void derive_arrival(Campaign& campaign);

/// From each of the times on, readings are of a session of their own, as after a knock of the
/// tracker. The sessions are called 1, 2, ... or, where they had names, `day 1`, `day 1 (2)`, ...
/// The campaign has times.
void begin_sessions(Campaign& campaign, const std::vector<double>& times_s);

}  // namespace armtrue
