#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "armtrue/kinematics/pose.h"

namespace armtrue {

inline constexpr int kJoints = 6;
inline constexpr int kLinks = 7;

/// Encoder angles of the six joints [rad], as the controller shows them.
using JointVector = Eigen::Matrix<double, kJoints, 1>;

/// One link in Khalil's modified Denavit-Hartenberg convention with Hayati's beta:
///     R_{j-1} from R_j = Rot(y, beta) Rot(x, alpha) Trans(x, d) Rot(z, theta_j) Trans(z, r),
/// where theta_j = theta + sign * q_j. Angles rad, lengths m.
/// Source: Khalil and Dombre, "Modeling, Identification and Control of Robots"; Hayati 1985 for
/// beta.
struct Link {
  std::string name;
  double alpha = 0, d = 0, theta = 0, r = 0, beta = 0;
  double sign = 1;                                        ///< direction of the encoder: +1 or -1
  double min = -std::numeric_limits<double>::infinity();  ///< travel of the encoder angle [rad]
  double max = std::numeric_limits<double>::infinity();
};

/// Returns the travel {min, max} of a joint [rad]; a missing limit is replaced by -pi or +pi.
inline std::array<double, 2> travel(const Link& link) {
  return {std::isfinite(link.min) ? link.min : -std::numbers::pi,
          std::isfinite(link.max) ? link.max : std::numbers::pi};
}

/// A reflector, fixed in the measured frame [m].
struct Target {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

/// Fixed end of a draw-wire or ball-bar, in R_A [m]. The reading is |p - position| + zero, where p
/// is a target or the origin of the measured frame.
struct Anchor {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double zero = 0;
};

/// The chain of seven links, six driven and the last (the spindle) fixed, between the frame R_A of
/// the instrument and the measured frame on the tool.
struct KinematicChain {
  Pose base;                       ///< R_A from R_0
  std::array<Link, kLinks> links;  ///< links[6] has no joint
  Pose tool;                       ///< R_7 from the measured frame
  std::vector<Target> targets;
  std::vector<Anchor> anchors;
};

}  // namespace armtrue
