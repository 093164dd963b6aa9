#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/campaign.h"

namespace armtrue {

/// Cycles that ISO 9283:1998 asks for.
inline constexpr int kStandardCycles = 30;

/// One attained pose and how far it is from the commanded one.
struct Visit {
  Eigen::Vector3d attained = Eigen::Vector3d::Zero();    ///< R_A [m]
  Eigen::Vector3d error = Eigen::Vector3d::Zero();       ///< attained - commanded, R_A [m]
  std::optional<Eigen::Matrix3d> orientation;            ///< R_A from the measured frame
  Eigen::Vector3d turn_error = Eigen::Vector3d::Zero();  ///< rotation vector, R_A [rad]
  Direction arrival{};                                   ///< all 0: not known
  std::optional<double> time_s;
  JointVector q;  ///< encoder values [rad or m]
};

/// ISO 9283:1998, 7.2 and 7.6, of one pose with n visits x_j, mean x and command c:
///     AP = |x - c|,  RP = mean(l) + 3 S,  l_j = |x_j - x|,  S^2 = sum (l_j - mean(l))^2 / (n - 1).
struct PoseFigures {
  std::string pose;
  int visits = 0;
  JointVector q;  ///< encoder values of the first visit [rad or m]
  Eigen::Vector3d ap_axes = Eigen::Vector3d::Zero();  ///< x - c, along the axes of R_A [m]
  double ap = 0;                                      ///< [m]
  double rp = 0;  ///< [m]; 0 if rounding explains the spread, as in all figures below
  /// Of the rotation vector, about the axes of R_A [rad]: AP is the mean error, RP is 3 S (the
  /// standard's +-3 S). Empty without orientations.
  std::optional<Eigen::Vector3d> ap_turn, rp_turn;
  int directions = 0;  ///< number of different directions of arrival; unknown ones do not count
  /// vAP: largest distance between the means of visits from different directions [m]. Only
  /// directions with two visits or more count. Empty if there are fewer than two of them.
  std::optional<double> vap;
  /// Absolute difference of AP, and of RP, between the last half of the visits and the first half,
  /// in the order of time [m]. Empty without times and below four visits.
  std::optional<double> drift_ap, drift_rp;
  /// vAP and drift of orientations, of the rotation vector, about the axes of R_A [rad]: largest
  /// difference of the mean errors from two directions; |AP, RP of the last half - of the first
  /// half|. Empty without orientations, and where the figures of positions are.
  std::optional<Eigen::Vector3d> vap_turn, drift_ap_turn, drift_rp_turn;
  double squared_scatter = 0;  ///< sum of l_j^2 [m^2]
  /// Sum of (x_j - x)(x_j - x)^T [m^2], of which it is the trace.
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
};

/// `spread`, or 0 if it may be the rounding of coordinates as large as `size`.
double resolved(double spread, double size);

/// 95 % interval of the repeatability mean(l) + 3 S that many visits would show, from the largest
/// one of some places, each visited n times (3 or more; two visits have equal distances to their
/// mean, so that S is 0 however much they scatter). Few visits scatter less about their own
/// mean, so that the repeatability of three is too small by a third; the largest of many places is
/// too large. The visits are normal with a covariance of the shape `squares`, whatever its size;
/// the ratio to the value of many visits is simulated, with a fixed seed. The lower end is that of
/// places that repeat equally well, the upper end that of one place which is worse than all others.
/// [0, 0] for a repeatability of 0.
std::array<double, 2> repeatability_ci95(double repeatability, int n, Eigen::Index places,
                                         const Eigen::Matrix3d& squares);

/// The larger distance of the ends of an interval from the value.
inline std::optional<double> expanded_of(double value,
                                         const std::optional<std::array<double, 2>>& ci95) {
  if (!ci95) return std::nullopt;
  return std::max(value - (*ci95)[0], (*ci95)[1] - value);
}

/// Throws std::invalid_argument below two visits.
PoseFigures pose_figures(const std::string& pose, const std::vector<Visit>& visits);

/// The figures of all poses with two visits or more; a pose that several reflectors or sessions saw
/// has one entry for each. `evaluation` is that of the campaign. Throws std::invalid_argument if
/// the campaign has distances instead of points.
struct CampaignFigures {
  std::vector<PoseFigures> poses;     ///< in the order of the ids
  std::vector<std::string> single;    ///< poses with one visit
  std::vector<std::string> not_left;  ///< poses with two visits that follow each other in the file
};
CampaignFigures figures_of(const Campaign& campaign, const Evaluation& evaluation);

/// A largest value and its pose.
struct Largest {
  double value = 0;
  std::string pose;
};

/// The figures of a certificate: the largest in a set of poses.
struct SetFigures {
  int poses = 0;
  int fewest_visits = 0;
  Largest ap, rp;
  /// 95 % interval of the RP that many visits would show [m]; empty if the pose with the largest RP
  /// has two.
  std::optional<std::array<double, 2>> rp_ci95;
  std::optional<Largest> ap_turn, rp_turn;         ///< of any axis, absolute [rad]
  std::optional<Largest> vap, drift_ap, drift_rp;  ///< [m]
  /// Largest of any axis, absolute [rad].
  std::optional<Largest> vap_turn, drift_ap_turn, drift_rp_turn;
  std::optional<double> rp_expanded() const { return expanded_of(rp.value, rp_ci95); }  ///< [m]
};

/// Throws std::invalid_argument if there are no poses.
SetFigures largest_of(const std::vector<PoseFigures>& poses);

/// Standard deviation of a visit about the mean of its pose, per axis, of all poses together [m]:
/// s^2 = sum of |x_j - x|^2 / f, f = 3 sum (n - 1) degrees of freedom.
struct Scatter {
  double deviation = 0;
  double freedom = 0;
};
Scatter scatter_of(const std::vector<PoseFigures>& poses);

}  // namespace armtrue
