#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/effects/arrival.h"
#include "armtrue/effects/context.h"
#include "armtrue/effects/effect.h"
#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/joint_rows.h"

namespace armtrue {

/// What one row of a campaign reads.
enum class ReadingKind {
  point,       ///< the three coordinates of a point in R_A and, if the campaign has orientations,
               ///< the orientation of the measured frame: a pose
  distance,    ///< the distance of the point from an anchor
  coordinate,  ///< one coordinate of a point; only in a campaign that has other kinds too
  touch,       ///< one number that a touch or a beam reads, see ContactKind
  pixel,       ///< one coordinate of a corner in an image
};

/// The contact that a row touches or sees, and the coordinate that it reads.
struct Touch {
  int contact = -1;       ///< index into contact_names; -1: the row has no touch
  int axis = -1;          ///< coordinate of a point, 0 to 2, or of a pixel, 0 or 1; -1 for a plane
                          ///< or a sphere
  bool is_pixel = false;  ///< the name of the contact is the text of a PixelName
};

/// Name of a pixel in Campaign::contact_names: `left/plate/7` is the point 7 of the board `plate`
/// in the image of the camera `left`. Camera and board are empty where the file names none.
struct PixelName {
  std::string camera, board, corner;

  explicit PixelName(const std::string& name);
  PixelName(std::string of_camera, std::string of_board, std::string of_corner)
      : camera(std::move(of_camera)), board(std::move(of_board)), corner(std::move(of_corner)) {}
  std::string text() const { return camera + "/" + board + "/" + corner; }
};

/// Name of the reading of a beam in Campaign::contact_names: `laser:bar/2` is the distance along
/// the beam `laser` to the face 2 of the artefact `bar`. The beam is empty where the file names
/// none.
struct BeamName {
  std::string beam, contact;

  static bool is_one(const std::string& name) { return name.find(':') != std::string::npos; }
  /// Of a name that is_one().
  explicit BeamName(const std::string& name)
      : beam(name.substr(0, name.find(':'))), contact(name.substr(name.find(':') + 1)) {}
  BeamName(std::string of_beam, std::string of_contact)
      : beam(std::move(of_beam)), contact(std::move(of_contact)) {}
  std::string text() const { return beam + ":" + contact; }
};

/// One coordinate of a measured point.
struct Coordinate {
  int axis = 0;      ///< of R_A: 0 is x, 1 is y, 2 is z
  double value = 0;  ///< [m]
};

/// Number of values in one reading.
struct ReadingSize {
  int position = 3;     ///< 3 for a point, 1 for a distance or a coordinate
  int orientation = 0;  ///< 3 if the campaign has orientations
  int all() const { return position + orientation; }
  /// The share of the unknowns of a fit that is charged to the position: position / all.
  double share_of_position() const { return static_cast<double>(position) / all(); }
};

/// A point of a line profile, (0, y, z) in the measured frame, which is that of the sensor.
struct ProfilePoint {
  double y = 0, z = 0;  ///< [m]
  int number = 0;       ///< among the points of its pose
};

/// Measured poses, one row per reading, in the order of the visits. Each column is its own vector,
/// so that a million rows take the memory of the present columns only. A column that the file does
/// not have is empty.
struct Campaign {
  std::string source;  ///< file name, for messages

  std::vector<int> pose;  ///< index into pose_ids; rows that share it are replicates
  std::vector<std::string> pose_ids;
  std::vector<int> line;  ///< line in the file
  JointRows q;            ///< [rad or m]
  /// The readings [m]: points in R_A, or distances from anchors; the other column is empty.
  std::vector<Eigen::Vector3d> position;
  std::vector<double> distance;
  /// Only in a campaign of points and distances: for each row, the coordinate that it reads, or
  /// nothing if it reads `distance`. A point becomes three rows, because all readings of a campaign
  /// have one size. Otherwise empty. See points_to_coordinates().
  std::vector<std::optional<Coordinate>> coordinate;
  /// Only in a campaign with touches: one for each row; otherwise empty. `distance` then holds the
  /// reading of a gauge: the gap between the point and the contact, 0 if it touches, or that of a
  /// beam. The touch of a
  /// point becomes three rows. See touches_to_coordinates().
  std::vector<Touch> touch;
  /// Only in a campaign of line profiles: the point that touches the contact, in place of the
  /// origin of the measured frame; otherwise empty. Rows of one pose are points of one profile.
  std::vector<ProfilePoint> profile;
  int longest_profile = 1;  ///< one more than the largest ProfilePoint::number
  /// Only in a campaign with images: how much of the board one pixel shows, the median over the
  /// images. The `distance` of a pixel is its coordinate times this number, so it is a length at
  /// the board. See bind_touches(), before which it is 1 and `position` holds the pixels.
  double metre_per_pixel = 0;

  // Optional columns.
  std::vector<int> repeat;
  std::vector<Eigen::Quaterniond> orientation;  ///< R_A from the measured frame, unit
  std::vector<double> time_s;
  std::vector<int> target;  ///< index into target_names
  std::vector<std::string> target_names;
  std::vector<int> anchor;  ///< of a distance: index into anchor_names; of a coordinate: 0
  std::vector<std::string> anchor_names;
  /// `table`, or `bar/2`: point 2 of the artefact `bar`, or the text of a BeamName or a PixelName.
  std::vector<std::string> contact_names;
  std::vector<double> sigma_position;      ///< per axis [m]
  std::vector<double> sigma_orientation;   ///< per axis [rad]
  /// Where rows state covariances: W of each row, without unit, lower triangular. With r the
  /// residual (position, rotation vector) in R_A and D the diagonal of the row's sigma_position and
  /// sigma_orientation, W D^-1 r is white. The sigmas are then the roots of the mean variances of
  /// their axes.
  std::vector<Eigen::Matrix<double, 6, 6>> whitening;
  std::vector<Direction> arrival;
  JointRows stroke;  ///< see Arrival [rad or m]
  std::vector<double> payload_kg;
  std::vector<std::array<double, kMaxJoints>> motor_torque_nm;
  std::vector<Eigen::Vector3d> force_n;
  std::vector<std::string> temperature_names;
  std::vector<std::array<double, kMaxTemperatures>> temperature_c;
  std::vector<int> session;  ///< index into session_names
  std::vector<std::string> session_names;

  int skipped_rows = 0;  ///< rows without a measurement

  int rows() const { return static_cast<int>(q.size()); }
  int poses() const { return static_cast<int>(pose_ids.size()); }
  /// Number of the targets; 1 where there is no column of them.
  int targets() const { return std::max(1, static_cast<int>(target_names.size())); }
  bool has_orientation() const { return !orientation.empty(); }
  /// True if each row reads one number (distance, touch, coordinate, pixel), not a point.
  bool reads_one_number() const { return !distance.empty(); }
  bool has_coordinates() const { return !coordinate.empty(); }
  bool has_touches() const { return !touch.empty(); }
  /// Whether some, or all, readings are pixels.
  bool has_pixels() const { return std::ranges::any_of(touch, &Touch::is_pixel); }
  bool has_pixels_only() const {
    return has_pixels() && std::ranges::all_of(touch, &Touch::is_pixel);
  }
  /// Whether all readings are touches, beams or pixels: then there is no instrument.
  bool has_touches_only() const;
  bool has_profiles() const { return !profile.empty(); }
  /// The point of the measured frame that a row reads without targets [m]: that of a profile, or
  /// the origin.
  Eigen::Vector3d own_point(int row) const {
    return has_profiles() ? Eigen::Vector3d(0, profile[row].y, profile[row].z)
                          : Eigen::Vector3d(0, 0, 0);
  }
  /// Whether all readings are of beams.
  bool has_beams_only() const;
  ReadingKind kind(int row) const;
  /// The reading of a row if reads_one_number(): the distance, the coordinate, or the gauge of a
  /// touch [m].
  double length(int row) const {
    return kind(row) == ReadingKind::coordinate ? coordinate[row]->value : distance[row];
  }
  ReadingSize reading_size() const {
    return {reads_one_number() ? 1 : 3, has_orientation() ? 3 : 0};
  }
  /// Number of the quantity that a row reads of its target: 0 for a point, the index of the anchor
  /// for a distance. In a campaign of points and distances: the axis (0 to 2) for a coordinate, 3 +
  /// the index of the anchor for a distance. Then come three numbers for each contact. Equal
  /// numbers group rows; the number is no index.
  int quantity(int row) const;
  int quantities() const;  ///< one more than the largest possible quantity()
  /// Makes a row read this quantity() of points or distances; its value is then undefined.
  void set_quantity(int row, int quantity);
  /// The first row of each reading, where a point may stand in three rows, one per coordinate: rows
  /// that follow each other, of one pose, line, session and contact, with rising axes. Empty if
  /// each row is a reading.
  std::vector<int> first_rows_of_readings() const;
  /// Number of the readings: lines of a file with a point, a distance or a corner.
  int readings() const;
  /// The lines of some rows, each once, ascending.
  std::vector<int> lines_of(const std::vector<int>& rows) const;
  /// Number of the target, quantity and profile point of a row. Rows with the same session, pose
  /// and channel are replicates.
  int channel(int row) const;
  /// Number of the pose, quantity and profile point of a row, below poses_by_quantity(). All rows
  /// with one number have the same error of the model.
  int pose_by_quantity(int row) const;
  size_t poses_by_quantity() const { return pose_ids.size() * quantities() * longest_profile; }
  /// For every row, the number of its pose in the order of the ids (`P2` before `P10`). Unlike
  /// `pose`, it does not depend on the order of the rows.
  std::vector<int> pose_by_id() const;
  Context context(int row) const;

  /// The campaign of these rows, in this order, with only the pose ids that occur in them.
  Campaign select(const std::vector<int>& rows) const;
};

/// Name of the column that a driver of this kind needs, if the campaign lacks it; otherwise empty.
/// `where`: sensor of a temperature. Payload and force are never missing: without these columns
/// they are zero.
std::string missing_column(const Campaign& campaign, DriverKind kind, const std::string& where);

/// The values of one joint angle, of the time or of one temperature at the rows [SI]; the campaign
/// has the column.
std::vector<double> values_of(const Driver& driver, const Campaign& campaign);

/// Throws std::invalid_argument, with file and remedy, if the campaign lacks the column that drives
/// the effect: time, a temperature, motor torques, directions of arrival or strokes. Campaigns read
/// from a file always have directions, stated or derived (derive_arrival).
void require_drivers(const Campaign& campaign, const Effect& effect);

/// Replaces each row that has a point by three rows, one per coordinate, in a campaign of points
/// and other readings. Before the call, `position` and `distance` have all rows; a row with a
/// point has the distance 0 and no touch. After it, `coordinate` has all rows, and `position` is
/// empty unless pixels wait there.
void points_to_coordinates(Campaign& campaign);

/// Replaces each touch of a point by three rows, one per coordinate, and each pixel by two.
/// `is_point`: for each name in contact_names, whether it is a point or a point of an artefact.
void touches_to_coordinates(Campaign& campaign, const std::vector<bool>& is_point);

/// Numbers the points of each profile, in the order of the rows.
void number_profile_points(Campaign& campaign);

/// The noise that a robot file states for the readings of a campaign, per axis [m]; 0 without any.
/// Of images alone it is that of a pixel, at the board.
double stated_position_noise(const Robot& robot, const Campaign& campaign);

/// Calls `action` for each row, in the order of the times or, without times, of the rows, with the
/// motion of the joints in its session up to this row.
using VisitAction = std::function<void(int row, const Arrival&)>;
void for_each_visit(const Campaign& campaign, const VisitAction& action);

/// Fills `arrival` and `stroke`, unless the campaign has them. `arrival` is the sign of the last
/// motion of each joint in the same session, 0 before the first; `stroke` is its way since its last
/// reversal [rad or m]. Motions below 1e-4 deg do not count. The order of the visits is that of the
/// times or, without times, that of the rows. If the campaign has directions that contradict this
/// order, `stroke` stays empty.
void derive_arrival(Campaign& campaign);

/// Multiplies the encoder values of revolute joints by `factor`, to read them in another unit.
void scale_angles(Campaign& campaign, const KinematicChain& chain, double factor);

/// Begins a new session at each of the times, for example after a knock of the tracker. The
/// sessions are named 1, 2, ... or, if they had names, `day 1`, `day 1 (2)`, ... The campaign must
/// have times.
void begin_sessions(Campaign& campaign, const std::vector<double>& times_s);

}  // namespace armtrue
