#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/effects/effect.h"
#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// A rigid body of the arm, for the torques of gravity.
struct Body {
  int link = 0;  ///< 0-based; the body moves with this link
  double mass_kg = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< of mass, in the link's frame [m]
};

/// Noise of the instrument, per axis, one standard deviation; 0 = not stated.
struct InstrumentNoise {
  double position = 0;     ///< [m]
  double orientation = 0;  ///< [rad]
  double pixel = 0;        ///< of a corner in an image [px]
};

/// Parameters of one session of a campaign, such as one station of the instrument or one day.
struct Session {
  Pose base;  ///< R_A from R_0
  /// Its own zero offsets, by 0-based link: theta [rad] of a revolute joint, r [m] of a prismatic
  /// one. The others are those of the chain.
  std::map<int, double> zero;
  std::map<std::string, double> std;  ///< as Robot::std, which holds those of the first session
};

/// Uncertainty of the parameters of a calibrated robot.
struct Uncertainty {
  /// Names of the geometric parameters: those that were identified, which Robot::std names too,
  /// then those of the links that the poses do not show, though others would (lost_to_poses()).
  /// After them come the coefficients of all effects, in their order.
  std::vector<std::string> parameters;
  Eigen::MatrixXd root;  ///< G with G G^T = covariance of all these [SI]; lower triangular
  /// Standard deviation of a reading about the model, per axis, in the region of the calibration.
  /// Contains noise and the lack of fit that differs from pose to pose. 0 for orientations that
  /// were not measured.
  InstrumentNoise reading;
  /// Standard deviation of what the model lacks in a position, per axis, where the readings of the
  /// calibration show that it lacks something, or nothing says how large their noise is [m]. The
  /// part of `reading` that is no noise; other poses have it, too.
  double rest = 0;
  /// 95 % quantile of the lengths of the position residuals, over that of a normal law; above 1
  /// only where more poses of the calibration lie beyond the latter than chance allows (p < 0.05).
  double tail = 1;
  /// Largest variance of a position reading by `root`, summed over its axes, among the poses of the
  /// calibration [m^2].
  double largest_variance = 0;
  /// The same for the measured point, if the readings are lengths; 0 if they are points.
  double largest_variance_of_point = 0;
  int poses = 0;  ///< of the calibration
};

/// A robot as its file describes it: the model that predicts a pose, and the parameters that a
/// calibration may change.
struct Robot {
  std::string name;
  KinematicChain chain;
  /// The sessions of a calibration with several, by name. `chain` has the base and zero offsets of
  /// the first; it also applies to readings without a session or of an unknown one.
  std::map<std::string, Session> sessions;
  /// The link whose frame stands on the ground, 0-based, if a positioner carries the part: the
  /// chain then runs from the part, through the axes of the positioner, to the ground and from
  /// there through the arm to the tool; R_A is the frame of the part and R_0 moves with the table.
  /// Nothing: R_0 stands on the ground.
  std::optional<int> ground_link;
  /// May be empty: torques are then a generic basis. Those of a positioner always are, because its
  /// load is the part.
  std::vector<Body> bodies;
  /// In R_0, or in the frame of `ground_link` [m/s^2].
  Eigen::Vector3d gravity{0, 0, -9.81};
  /// Height of the floor in the same frame [m].
  double floor = 0;
  /// Where the instrument stands in R_A, for effects of its line of sight [m]; if the file does not
  /// say it, at the origin.
  std::optional<Eigen::Vector3d> instrument;
  std::vector<Effect> effects;

  std::vector<std::string> identify{"auto"};  ///< {"auto"}, {"paper-25"}, or parameter names
  /// Zero offsets, such as A2.theta, that have their own value in each session, as the base has.
  std::vector<std::string> identify_per_session;
  InstrumentNoise noise;
  std::map<std::string, double> priors;  ///< standard deviation about the nominal value [SI]
  /// The chain whose values are the means of the priors, if it is not `chain`: that of the robot
  /// before a calibration. Not written to files: the values of a file are its nominal ones.
  std::optional<KinematicChain> nominal;
  std::map<std::string, double> std;       ///< of identified parameters [SI]
  std::optional<Uncertainty> uncertainty;  ///< of a calibrated robot
  /// If true, parameters that `priors` does not name have no prior.
  bool free_links = false;
};

/// Whether a parameter, an index as in parameters.h, belongs to the positioner or to the place of
/// the part on it.
bool is_of_positioner(const Robot& robot, int parameter);

/// Whether a parameter, an index, says where a positioner stands beside the arm: from its first
/// axis to the foot of the arm. As of base and tool, only readings tell its value.
bool places_positioner(const Robot& robot, int parameter);

/// The lengths that `arm.scale` multiplies, as indices of parameters: d and r of the links of the
/// arm. The links of rails and positioners do not count: they are other bodies. Nor does r of a
/// prismatic link, to which the reading of its scale is added.
std::vector<int> lengths_of_arm(const Robot& robot);

/// The vertical in R_A, a unit vector; z where there is no gravity or a positioner turns R_A.
Eigen::Vector3d upwards(const Robot& robot);

/// The place of the instrument in R_A [m].
inline Eigen::Vector3d instrument_place(const Robot& robot) {
  return robot.instrument.value_or(Eigen::Vector3d::Zero());
}

/// Whether it is known where the instrument stands: the file says it, or the origin of R_A lies
/// beyond the reach of the arm, where an instrument can stand. False with a positioner, which turns
/// R_A: the part is there.
bool knows_instrument(const Robot& robot);

/// Whether an effect belongs to the arm, so that programs are corrected for it. Effects on links
/// belong to it. Effects on `base` do if joint angles, their motion or a load drive them, because
/// the foot is compliant; otherwise (time, session, temperature, line of sight, place) they belong
/// to the instrument. Effects on `tool` belong to the tool that carried the reflectors, and count
/// only if the program uses this tool. Effects on the instrument, targets, anchors, contacts,
/// beams, boards and cameras never count, nor those with Effect::may_be_instrument.
bool moves_program(const Effect& effect, bool tool_is_measured);

/// The robot without the effects for which moves_program() is false. Effect::mean of each effect is
/// added to its parameter.
Robot without_station_effects(Robot robot, bool tool_is_measured);

/// Whether a robot file says that it comes from a calibration: standard deviations, an uncertainty,
/// or effects.
bool states_calibration(const Robot& robot);

}  // namespace armtrue
