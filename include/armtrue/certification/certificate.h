#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/doubts.h"
#include "armtrue/campaign/training_rows.h"
#include "armtrue/certification/budget.h"
#include "armtrue/certification/path_figures.h"
#include "armtrue/certification/pose_accuracy.h"
#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/joint_names.h"

namespace armtrue {

/// Who measured what, when and with what. Dates are YYYY-MM-DD.
struct About {
  std::string type, serial;  ///< of the robot
  std::string operator_name, date, place;
  std::string instrument, instrument_serial, calibrated_until;
  StatedUncertainty stated;
  std::optional<double> range;  ///< of the instrument, if stated [m]
};

struct CertificateOptions {
  std::optional<double> tolerance;  ///< of AP [m]
  /// The five poses of the standard's cube; if empty, the poses P1 to P5, if all are there.
  std::vector<std::string> cube;
  std::string refitted;               ///< what was fitted to these readings, such as base,tool
  HiddenError hidden;                 ///< by that fit
  bool robot_knows_readings = false;  ///< the robot file was made from these readings
  SeenPoses seen;                     ///< poses that took part in the calibration of the robot
  bool points_look_computed = false;  ///< no instrument seems to have read them
  std::optional<PathFigures> path;    ///< of a recorded path, if there is one
};

/// The figures and the conditions under which they are valid. Of a path alone the rest is empty.
struct Certificate {
  About about;
  std::string robot, refitted;
  std::optional<double> tolerance;
  std::optional<Decision> decision;  ///< on the largest AP of all poses; empty without a tolerance
  std::optional<SetFigures> cube;
  SetFigures all;
  std::optional<PathFigures> path;
  std::optional<Budget> path_budget;  ///< of AT, which the model of the robot has no part in
  Budget budget;                      ///< of AP
  std::vector<PoseFigures> poses;
  std::vector<JointName> joints;   ///< of the robot
  std::vector<std::string> notes;  ///< sentences on the limits of the figures
  /// Contradictions within the readings, see doubts_of_visits(); also among the notes.
  std::vector<std::string> doubts;

  bool has_poses() const { return !poses.empty(); }
};

/// Of a recorded path alone: AT and RT.
Certificate certify_path(const About& about, const PathFigures& path);

/// Throws std::invalid_argument, with a remedy, if no pose has two visits or a pose of the cube is
/// not among those judged.
Certificate certify(const Robot& robot, const Campaign& campaign, const Evaluation& evaluation,
                    const About& about, const CertificateOptions& options);

/// Encoder values by the columns of measured poses, in their units: "q1_deg", "e1_mm".
using JointColumns = std::map<std::string, double>;

/// The joint values of a pose.
JointColumns joint_columns(const PoseFigures& figures, const std::vector<JointName>& joints);

/// A value of a certificate with its expanded uncertainty [m].
struct CertifiedValue {
  std::string name;  ///< `ap`, `rp`, `cube ap`, `cube rp`, `at`, `rt`, or the name of a pose
  double value = 0;
  std::optional<double> expanded;  ///< empty if the visits do not show it
  JointColumns joints{};           ///< of a pose; older certificates have none
};

/// The values of a certificate that a comparison uses: ap and rp of all poses and of the cube, at
/// and rt of the path, and AP of each pose.
struct CertifiedValues {
  std::string serial, type, date;
  std::vector<CertifiedValue> figures, poses;
};
CertifiedValues values_of(const Certificate& certificate);

/// now - before, with U = sqrt(U_now^2 + U_before^2). Errors that both certificates have in common
/// count twice, so the interval is too wide rather than too narrow.
struct CertifiedChange {
  std::string name;
  double before = 0, now = 0, difference = 0;
  std::optional<double> expanded;  ///< empty if one of the values has none
  bool significant = false;        ///< |difference| > expanded; not without it
};

/// A pose whose joint values are not those of the pose with this name in the older certificate.
struct OtherPose {
  std::string name;
  std::string joint;  ///< column of the joint that differs most
  double apart = 0;   ///< of that joint, in the unit of its column
};

/// Differences of the values that both certificates have, without those of other poses. The
/// expanded uncertainty of the m poses is widened so that the chance of any false difference
/// is 4.55 % in all (Bonferroni).
struct Comparison {
  std::string date_before;
  std::vector<CertifiedChange> figures, poses;
  std::vector<OtherPose> others;  ///< a joint differs by more than 1 deg, or 1 mm
};

/// Throws std::invalid_argument if these are not certificates of one robot.
Comparison compare(const CertifiedValues& before, const CertifiedValues& now);

/// What the comparison leaves out because names of poses have another meaning: a sentence, empty if
/// nothing.
std::string doubt_of_poses(const Comparison& comparison);

}  // namespace armtrue
