#pragma once

#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// What a line scanner sees whose frame is the measured frame: points of its plane x = 0, along
/// rays from its origin that spread evenly over an angle about its z axis.
struct Scanner {
  Eigen::Vector2d range{0, 0};  ///< from and to, of z of a point [m]; both below 0 of a
                                ///< sensor whose z is negative ahead
  double view = 0;              ///< the angle [rad]
  int rays = 20;                ///< show a line or an arc as well as hundreds do
};

/// The planes and spheres whose place is known: indices into the contacts. Throws
/// std::invalid_argument if there is none.
std::vector<int> scanned_contacts(const KinematicChain& chain);

/// A point of a profile, and the contact on which it lies.
struct ScannedPoint {
  int contact = 0;
  ProfilePoint at;
};

/// What the scanner reads of these contacts with the measured frame at `a_from_measured`: of each
/// ray the nearest surface that it meets in the range, from its front and by less than 60 deg off
/// its normal. A plane has no edges here.
std::vector<ScannedPoint> profile_at(const KinematicChain& chain, const Scanner& scanner,
                                     const std::vector<int>& contacts, const Pose& a_from_measured);

}  // namespace armtrue
