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
};

/// Parameters of one session of a campaign: a station of the instrument, a day.
struct Session {
  Pose base;  ///< R_A from R_0
  /// Zero offsets of its own, by 0-based link: theta [rad] of a revolute joint, r [m] of a
  /// prismatic one; the others are those of the chain.
  std::map<int, double> theta;
  std::map<std::string, double> std;  ///< as Robot::std; of the first session they stand there
};

/// How far a calibrated robot may be from the arm.
struct Uncertainty {
  /// Geometric parameters by name; after them come the coefficients of all effects, in their order.
  std::vector<std::string> parameters;
  Eigen::MatrixXd root;  ///< G with G G^T = covariance of all these [SI]; lower triangular
  /// Standard deviation of a reading about the model, per axis, where that was calibrated: noise,
  /// and what differs from pose to pose and the model lacks. 0 of orientations: not measured.
  InstrumentNoise reading;
  /// Largest variance of the position by `root`, the sum over its axes, of a pose of the
  /// calibration [m^2].
  double largest_variance = 0;
  int poses = 0;  ///< of the calibration
};

/// A robot as its file describes it: the model that predicts a pose, and what identification is
/// allowed to change in it.
struct Robot {
  std::string name;
  KinematicChain chain;
  /// The sessions of a campaign that had several, by name. `chain` is as in the first, and holds
  /// for readings of no or of an unknown session.
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
  /// Where the instrument stands in R_A, for effects of its line of sight [m]; if the file does not
  /// say it, at the origin.
  std::optional<Eigen::Vector3d> instrument;
  std::vector<Effect> effects;

  std::vector<std::string> identify{"auto"};  ///< {"auto"}, {"paper-25"}, or parameter names
  /// Zero offsets, such as A2.theta, of which each session has its own value, as of its base.
  std::vector<std::string> identify_per_session;
  InstrumentNoise noise;
  std::map<std::string, double> priors;  ///< standard deviation about the nominal value [SI]
  /// The chain that priors are about, if it is not `chain`: that of the robot before a calibration.
  /// Files do not hold it: the values of a file are its nominal ones.
  std::optional<KinematicChain> nominal;
  std::map<std::string, double> std;       ///< of identified parameters [SI]
  std::optional<Uncertainty> uncertainty;  ///< of a calibrated robot
  /// Whether links may be anything: parameters that `priors` does not name have no prior then.
  bool free_links = false;
};

/// Whether a parameter, an index as in parameters.h, belongs to the positioner or to the place of
/// the part on it.
bool is_of_positioner(const Robot& robot, int parameter);

/// The vertical in R_A, a unit vector; z where there is no gravity or a positioner turns R_A.
Eigen::Vector3d upwards(const Robot& robot);

/// The place of the instrument in R_A [m].
inline Eigen::Vector3d instrument_place(const Robot& robot) {
  return robot.instrument.value_or(Eigen::Vector3d::Zero());
}

/// Whether it is known where the instrument stands: the file says it, or the origin of R_A lies
/// beyond the reach of the arm, where an instrument can stand. Not where a positioner turns R_A:
/// there the part is.
bool knows_instrument(const Robot& robot);

}  // namespace armtrue
