#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

/// Points of a box, both ends of each side included; the middle of a side with one point.
struct Grid {
  Eigen::Vector3d low, high;  ///< of the TCP, in the program's frame [m]
  std::array<int, 3> count{1, 1, 1};
  Eigen::Matrix3d orientation = Eigen::Matrix3d::Identity();  ///< program's frame from TCP

  int points() const { return count[0] * count[1] * count[2]; }
  /// Places along the three sides of a point; x runs first.
  std::array<int, 3> place(int point) const;
  int point(const std::array<int, 3>& place) const;
  double coordinate(int axis, int place) const;  ///< [m]
  Eigen::Vector3d position(int point) const;
};

/// What is predicted of one point. Vectors are in the axes of the program's frame. Without joint
/// angles, or outside the travel, there is no prediction.
struct MapPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< intended [m]
  std::optional<JointVector> q;  ///< where the controller's model has it [rad]
  bool is_predicted = false;
  /// Where the identified arm stands, minus where the controller's model has the TCP [m].
  Eigen::Vector3d error = Eigen::Vector3d::Zero();
  double turn = 0;  ///< angle of the rotation between the two [rad]
  /// The error that is left if the controller takes over the identified constants, but no effects
  /// [m].
  double left_by_constants = 0;
  /// As CorrectedTarget::deviation [m] and ::leverage; nothing if the robot does not state its
  /// uncertainty.
  std::optional<double> deviation, leverage;
  /// Root mean square of the error that is left if constants and effects are taken over [m]:
  /// sqrt(deviation^2 + 3 s^2), with s Uncertainty::reading, which has what the model lacks.
  std::optional<double> after;
  std::vector<CommandNote> notes;  ///< unreachable, limit, singular, outside_readings

  bool has(CommandNote note) const;
};

/// A wrist bent by less is called singular in a map [rad]: corrections are damped there.
inline constexpr double kSingularWrist = 3 * kDegree;

/// Predicted errors over a grid, or over the targets of a program.
struct ErrorMap {
  std::vector<std::string> names;  ///< of the points
  std::vector<MapPoint> points;
  /// What makes the error: the difference of the constants, then every effect of the identified arm
  /// that moves a program and, if the controller's model has effects, these.
  std::vector<std::string> causes;
  size_t effects = 0;  ///< of the identified arm among the causes
  /// The part of each cause in the error, points x causes, row after row [m]: each effect alone
  /// against none. The parts add up to the error but for products of two of them.
  std::vector<Eigen::Vector3d> parts;
  std::optional<Grid> grid;

  const Eigen::Vector3d& part(size_t point, size_t cause) const {
    return parts[point * causes.size() + cause];
  }
};

/// How the joints come from one Cartesian target without a hint to the next.
enum class Following {
  branch,     ///< all signs of the branch stay, as compensate() keeps them
  continuous  ///< as along a path: axes 4 to 6 go the short way through a stretched wrist
};

/// Maps the targets of a program, in its order. Those that cannot be reached stay, with their note.
/// Throws UnreachableTarget for a target that says nothing of its branch, or contradicts itself,
/// and std::invalid_argument if an effect's driver is missing.
ErrorMap map_errors(const Robot& identified, const Robot& controller, const Program& program,
                    const CompensationOptions& options, Following following = Following::branch);

/// Maps a grid. Shoulder and elbow are bent as at CompensationOptions::start, which must be given;
/// the wrist stands to the side where axis 4 is nearer to the start or, if axis 4 does not turn the
/// forearm, to the same side; of whole turns the nearest are taken. `conditions`: one row with what
/// effects are driven by at all points; no joint has a direction of arrival.
ErrorMap map_errors(const Robot& identified, const Robot& controller, const Grid& grid,
                    const Campaign& conditions, const CompensationOptions& options);

/// A box of the size of a part, of which every point of the grid is predicted.
struct Placement {
  Eigen::Vector3d low, high;  ///< [m]
  double mean = 0;            ///< of the error in it [m]
};

struct CauseSummary {
  std::string cause;
  double mean = 0, max = 0;  ///< length of its part [m]
  /// Of the sum of the squared errors: sum of part . error over sum of error . error. Below zero if
  /// it takes away from what the others do; all add up to 1.
  double share = 0;
};

struct ErrorMapSummary {
  int predicted = 0;                                     ///< points
  ErrorSummary before, turn, left_by_constants;          ///< [m], [rad], [m]
  std::optional<ErrorSummary> after, deviation;          ///< [m]
  std::vector<CauseSummary> causes;                      ///< as ErrorMap::causes
  Eigen::Vector3d mean_error = Eigen::Vector3d::Zero();  ///< [m]
  /// Unit vector along which the mean square of the error is largest, and its share of the whole.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  double axis_share = 0;
  int best = -1, worst = -1;  ///< points with the smallest and the largest error before
  Eigen::Vector3d part = Eigen::Vector3d::Zero();  ///< size of the part [m]
  /// Where the part should stand, and where not, by the mean error before and after; nothing
  /// without a grid, or if no place is predicted as a whole.
  std::optional<Placement> best_before, worst_before, best_after, worst_after;
};

/// `part`: size of what shall stand in the box of the grid; half its sides if absent. Throws
/// std::invalid_argument if the map has no predicted point.
ErrorMapSummary summarize(const ErrorMap& map, const std::optional<Eigen::Vector3d>& part = {});

/// All in a sentence or two.
std::string error_map_sentence(const ErrorMap& map, const ErrorMapSummary& summary);

/// Words for the notes of a map, in their order.
const std::vector<CommandNote>& map_notes();

/// How many points have a note.
int count_of(const ErrorMap& map, CommandNote note);

}  // namespace armtrue
