#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "armtrue/campaign/stated_covariance.h"
#include "import/table_reader.h"

namespace armtrue {

/// The mean of the points of a standstill [m], and of their orientations and covariances if they
/// have some.
struct MeanReading {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  /// Not divided by the number of points, because they share most of their error.
  PoseCovariance covariance = PoseCovariance::Zero();
};

/// Joint angles for one row of the points.
struct JointMatch {
  int point_row = 0;
  int joint_row = 0;                ///< row whose other columns apply to the point
  JointVector q;                    ///< [rad or m]
  /// Replaces the point of the row; null: none. A million rows have a pointer each.
  std::shared_ptr<const MeanReading> mean;
};

struct JointMatches {
  std::vector<JointMatch> rows;  ///< in the order of the points
  std::string how;               ///< for messages: by id, by order, by time
  /// Without a column of poses: consecutive rows of the same joint angles are one pose.
  bool stops_are_poses = false;
  /// Without a column of poses: rows of the same joint angles are one pose, wherever they stand.
  bool same_joints_are_one_pose = false;
  std::vector<std::string> warnings;
};

/// Throws InputError if a table has no column of times, or if those of the joint angles are so far
/// apart that they are in ns.
void require_times(const TableReader& points, const TableReader& joints);

/// Two clocks may differ by an offset alone: if one has times of day, dates of a single day of the
/// other are dropped. Throws InputError if they are still written in different forms: numbers,
/// times of day, dates with or without a time zone.
void bring_to_one_form(const TableReader& points, TableReader::Clock& a, const TableReader& joints,
                       TableReader::Clock& b);

/// Joins points and joint angles: by the column of poses, by the order of the rows, by time, or by
/// stops (match_by_stops()). By time the joint angles are interpolated between the two samples
/// around the point, and only points are taken at which the joints stand still. Throws InputError
/// if rows cannot be distinguished.
JointMatches match_joints(const TableReader& points, const TableReader& joints,
                          const ImportOptions& options);

}  // namespace armtrue
