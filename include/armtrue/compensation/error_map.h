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

/// Points of a box, at equal steps from end to end of each side. On a side with one point, it is
/// the middle.
struct Grid {
  Eigen::Vector3d low, high;  ///< of the TCP, in the program's frame [m]
  std::array<int, 3> count{1, 1, 1};
  Eigen::Matrix3d orientation = Eigen::Matrix3d::Identity();  ///< program's frame from TCP

  int points() const { return count[0] * count[1] * count[2]; }
  /// Indices of a point along the three sides; x runs fastest.
  std::array<int, 3> place(int point) const;
  int point(const std::array<int, 3>& place) const;
  double coordinate(int axis, int place) const;  ///< [m]
  Eigen::Vector3d position(int point) const;
};

/// The prediction for one point. Vectors are in the axes of the program's frame. Without joint
/// angles, or outside the travel, there is no prediction.
struct MapPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< intended [m]
  std::optional<JointVector> q;                        ///< in the controller's model [rad]
  bool is_predicted = false;
  /// Position of the TCP of the identified arm minus that in the controller's model [m].
  Eigen::Vector3d error = Eigen::Vector3d::Zero();
  double turn = 0;  ///< angle of the rotation between the two [rad]
  /// Remaining error if the controller gets the identified constants, but no effects [m].
  double left_by_constants = 0;
  /// As CorrectedTarget::deviation, without what the model lacks [m], and ::leverage; nothing if
  /// the robot does not state its uncertainty.
  std::optional<double> deviation, leverage;
  /// Root mean square of the remaining error if constants and effects are corrected [m]:
  /// sqrt(deviation^2 + 3 s^2 + rest^2), with s = Uncertainty::reading, which contains the lack of
  /// fit of the model.
  std::optional<double> after;
  PoseDifference rest;             ///< error that fewer than six axes cannot correct; else 0
  std::vector<CommandNote> notes;  ///< those of map_notes()

  bool has(CommandNote note) const;
};

/// A wrist whose axis 5 is bent by less than this counts as singular in a map [rad]; there
/// corrections are damped.
inline constexpr double kSingularWrist = 3 * kDegree;

/// Predicted errors over a grid, or over the targets of a program.
struct ErrorMap {
  std::vector<std::string> names;  ///< of the points
  std::vector<MapPoint> points;
  /// The causes of the error: the difference of the constants, then every effect of the identified
  /// arm for which moves_program() is true, those named kRemainder together as one cause, then the
  /// effects of the controller's model, if it has any.
  std::vector<std::string> causes;
  size_t effects = 0;  ///< causes that are effects of the identified arm
  /// The part of each cause in the error, points x causes, row after row [m]: the change by this
  /// effect alone. The parts sum to the error, except for products of two of them.
  std::vector<Eigen::Vector3d> parts;
  std::optional<Grid> grid;

  const Eigen::Vector3d& part(size_t point, size_t cause) const {
    return parts[point * causes.size() + cause];
  }
};

/// How the branch of a Cartesian target without a hint follows from the target before.
enum class Following {
  branch,     ///< all sides of the branch stay, as in compensate()
  continuous  ///< as along a path: the wrist may pass through the stretched posture if that is the
              ///< shorter way
};

/// Maps the targets of a program, in its order. Those that cannot be reached stay, with their note.
/// Throws UnreachableTarget for a target that states no branch, or contradicts itself, and
/// std::invalid_argument if an effect's driver is missing.
ErrorMap map_errors(const Robot& identified, const Robot& controller, const Program& program,
                    const CompensationOptions& options, Following following = Following::branch);

/// Maps a grid. Shoulder and elbow are on the side that they have at CompensationOptions::start,
/// which must be given. The wrist is on the side where axis 4 is nearer to the start or, if axis 4
/// does not turn the forearm, on the side of the start. Each joint takes the turn nearest to the
/// start. `conditions`: one row with the values of the drivers, the same at all points; no joint
/// has a direction of arrival.
ErrorMap map_errors(const Robot& identified, const Robot& controller, const Grid& grid,
                    const Campaign& conditions, const CompensationOptions& options);

/// A box of the size of a part in which every point of the grid has a prediction.
struct PartPlace {
  Eigen::Vector3d low, high;  ///< [m]
  double mean = 0;            ///< of the error in it [m]
};

/// The part of one cause in the errors of a map.
struct CauseSummary {
  std::string cause;
  double mean = 0, max = 0;  ///< length of its part [m]
  /// Share in the sum of the squared errors: (sum of part . error) / (sum of error . error). Below
  /// zero if the part reduces the error by the others; all shares sum to 1.
  double share = 0;
};

/// Figures of a map over its predicted points.
struct ErrorMapSummary {
  int predicted = 0;                                     ///< points
  ErrorSummary before, turn, left_by_constants;          ///< [m], [rad], [m]
  std::optional<ErrorSummary> after, deviation;          ///< [m]
  std::vector<CauseSummary> causes;                      ///< as ErrorMap::causes
  Eigen::Vector3d mean_error = Eigen::Vector3d::Zero();  ///< [m]
  /// Unit vector along which the mean square of the error is largest, and its share of the whole.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  double axis_share = 0;
  int best = -1, worst = -1;  ///< points with the smallest and the largest error without correction
  Eigen::Vector3d part = Eigen::Vector3d::Zero();  ///< size of the part [m]
  /// Best and worst place of the part, by the mean error before and after correction. Empty without
  /// a grid, or if no place has predictions at all its points.
  std::optional<PartPlace> best_before, worst_before, best_after, worst_after;
};

/// `part`: size of a part inside the box of the grid; if absent, half the sides of the box. Throws
/// std::invalid_argument if the map has no predicted point.
ErrorMapSummary summarize(const ErrorMap& map, const std::optional<Eigen::Vector3d>& part = {});

/// A summary in one or two sentences.
std::string error_map_sentence(const ErrorMap& map, const ErrorMapSummary& summary);

/// The notes that a map can have, in their order.
const std::vector<CommandNote>& map_notes();

/// How many points have a note.
int count_of(const ErrorMap& map, CommandNote note);

}  // namespace armtrue
